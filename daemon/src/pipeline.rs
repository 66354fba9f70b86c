//! One camera's lane, wired: driver → ring → worker → publisher, on one thread or two.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use lodestone_config::model::Threads;

use crate::commands::supervision::{LaneContext, LaneFailure, LaneThread, Ready, StartedLane};
use crate::driver::{Driver, SourceState};
use crate::handover::{HandOver, Rhythm};
use crate::lane::{Core, LaneSettings, Publish, Worker};
use crate::publisher::{AidingInbox, LanePublisher};
use crate::reading::HostTime;
use crate::realtime::{ThreadSetup, enter};
use crate::ring::{Consumer, Producer, ring};
use crate::source::{Source, open};
use crate::status_board::LaneBoard;

/// Longest wait for a sample before the lane looks after itself; well below the time after which
/// silence counts as stale.
pub(crate) const PATIENCE: Duration = Duration::from_millis(20);

/// Starts the lane of one camera; returns once its services are open.
///
/// # Errors
/// [`LaneFailure`] names what could not be opened.
pub fn start(context: LaneContext) -> Result<StartedLane, LaneFailure> {
    let mut source = open(&context).map_err(LaneFailure::of)?;
    let truth = source.truth.take();
    let handle = LaneThread::start(context, move |c, ready| run(c, source, ready))?;
    Ok(StartedLane { handle: Box::new(handle), truth })
}

/// The lane's body, on its own thread: iceoryx2's ports stay on the thread that made them.
fn run(context: &LaneContext, source: Source, ready: Ready) -> Result<(), LaneFailure> {
    let Source { driver, host_rate, .. } = source;
    let (config, camera) = (&context.loaded.config, context.settings());
    let calibration = context.loaded.calibration(camera).map_err(LaneFailure::of)?;
    let info = driver.info();
    tracing::info!(camera = camera.name, source = info.description, "lane starts");
    let settings = LaneSettings::new(
        config,
        context.camera,
        camera,
        calibration.as_ref(),
        info.nominal_rate_hz,
    )
    .map_err(LaneFailure::of)?;
    let publisher = LanePublisher::open(&context.domain, &config.shared_memory, &camera.name)
        .map_err(LaneFailure::of)?;
    let inbox = AidingInbox::open(&context.domain, &config.shared_memory, &camera.name)
        .map_err(LaneFailure::of)?;
    let board = Arc::clone(&context.board);
    let membership = context.membership(&settings);
    let core = Core::in_world(&settings, membership);
    let unix_offset = context.unix_offset.clone();
    let worker = Worker::new(core, settings, publisher, board, unix_offset, host_rate);
    let (producer, consumer) = ring(config.lane.ring_capacity);
    let setup = ThreadSetup::of_camera(config, context.camera);
    let _enrolled = enter(&setup, &context.board.roster);
    ready.tell();
    let rate_hz = info.nominal_rate_hz;
    let ring = (producer, consumer);
    match config.lane.threads {
        Threads::One => {
            run_on_one_thread(context, driver, ring, worker, inbox);
            Ok(())
        }
        Threads::Two => run_on_two_threads(context, driver, ring, worker, inbox, HandOver::WakeUp),
        Threads::Timed => {
            let timed = HandOver::Timed(Rhythm::new(rate_hz));
            run_on_two_threads(context, driver, ring, worker, inbox, timed)
        }
    }
}

/// Reads, steps and publishes in turn: no hand-over to wait for.
fn run_on_one_thread<P: Publish>(
    context: &LaneContext,
    mut driver: Box<dyn Driver>,
    (mut producer, mut consumer): (Producer, Consumer),
    mut worker: Worker<P>,
    mut inbox: AidingInbox,
) {
    while !context.stop.is_raised() {
        let state = driver.poll(PATIENCE, &mut producer);
        while let Some((reading, in_ring)) = consumer.pop_stamped() {
            worker.take(&reading, in_ring);
        }
        hear(&mut worker, &mut inbox);
        count(&*driver, &producer, &context.board);
        worker.watch(state, HostTime::now());
        if state == SourceState::Ended {
            break;
        }
    }
}

/// The driver fills the ring on a thread of its own, so a stalled publisher loses no samples that
/// the ring can hold; each sample pays for the hand-over.
fn run_on_two_threads<P: Publish>(
    context: &LaneContext,
    driver: Box<dyn Driver>,
    (producer, mut consumer): (Producer, Consumer),
    mut worker: Worker<P>,
    mut inbox: AidingInbox,
    mut hand_over: HandOver,
) -> Result<(), LaneFailure> {
    let reader = Reader::start(context, driver, producer)?;
    while !(consumer.is_closed() && consumer.is_empty()) {
        hand_over.wait(&mut consumer, PATIENCE);
        while let Some((reading, in_ring)) = consumer.pop_stamped() {
            hand_over.note(reading.arrival);
            worker.take(&reading, in_ring);
        }
        hear(&mut worker, &mut inbox);
        worker.watch(reader.state(), HostTime::now());
    }
    reader.join()
}

/// A driver that fills a ring on a thread of its own.
pub(crate) struct Reader {
    thread: JoinHandle<()>,
    lost: Arc<AtomicBool>,
}

impl Reader {
    /// Starts to read.
    ///
    /// # Errors
    /// [`LaneFailure`] if there is no thread to be had.
    pub(crate) fn start(
        context: &LaneContext,
        mut driver: Box<dyn Driver>,
        mut producer: Producer,
    ) -> Result<Self, LaneFailure> {
        let (stop, board) = (context.stop.clone(), Arc::clone(&context.board));
        let lost = Arc::new(AtomicBool::new(false));
        let says_lost = Arc::clone(&lost);
        let setup = ThreadSetup::of_camera(&context.loaded.config, context.camera);
        let read = move || {
            let _enrolled = enter(&setup, &board.roster);
            let mut state = SourceState::Streaming;
            while !stop.is_raised() && state != SourceState::Ended {
                state = driver.poll(PATIENCE, &mut producer);
                says_lost.store(state == SourceState::Lost, Ordering::Relaxed);
                count(&*driver, &producer, &board);
            }
        };
        let name = format!("driver-{}", context.settings().name);
        let thread = thread::Builder::new().name(name).spawn(read).map_err(LaneFailure::of)?;
        Ok(Self { thread, lost })
    }

    /// Whether the source is there.
    pub(crate) fn state(&self) -> SourceState {
        let lost = self.lost.load(Ordering::Relaxed);
        if lost { SourceState::Lost } else { SourceState::Streaming }
    }

    /// Waits for the source's end.
    ///
    /// # Errors
    /// [`LaneFailure`] if the driver panicked.
    pub(crate) fn join(self) -> Result<(), LaneFailure> {
        self.thread.join().map_err(|_| LaneFailure::Panic("the driver's thread".into()))
    }
}

/// What others measured is as late as it is; no sample waits for it.
fn hear<P: Publish>(worker: &mut Worker<P>, inbox: &mut AidingInbox) {
    while let Some(message) = inbox.next_message() {
        worker.hear(&message);
    }
}

fn count(driver: &dyn Driver, producer: &Producer, board: &LaneBoard) {
    let (driver, ring) = (driver.counters(), producer.monitor().counters());
    board.counters.ring_dropped.set(ring.dropped);
    board.counters.reconnects.set(driver.reconnects);
    board.driver_invalid.set(driver.malformed + driver.marked_invalid);
    board.driver_duplicates.set(driver.duplicates);
}
