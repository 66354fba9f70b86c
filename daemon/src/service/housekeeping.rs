//! The thread beside the lanes: health once a second, truth of synthetic worlds, clean-up after
//! dead consumers.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use iceoryx2::node::Node;
use iceoryx2::prelude::ipc;
use lodestone_config::model::Config;
use lodestone_schema::Pose;
use lodestone_schema::transport::Domain;

use super::overview::{LaneMonitor, Overview};
use super::prefault::prefault;
use super::signals::StopFlag;
use super::space::SpaceWatch;
use super::world_duty::WorldDuty;
use crate::clock::UnixOffset;
use crate::publisher::{HealthPublisher, PublisherError, TruthPublisher};
use crate::reading::HostTime;
use crate::realtime::lock_memory;
use crate::status_board::LaneBoard;
use crate::world::Keeper;

/// Between two looks at the lanes.
const TICK: Duration = Duration::from_millis(100);
/// Between two looks at the truth, where there is any.
const TRUTH_TICK: Duration = Duration::from_millis(10);
/// Between two health messages, and two clean-ups.
const HEALTH_INTERVAL: Duration = Duration::from_secs(1);

/// The truth of a synthetic world, beside and not through the lane.
pub trait TruthProvider: Send {
    /// The true pose at this moment, or `None` before the world began and after it ended.
    fn truth_at_now(&mut self) -> Option<Pose>;
}

/// What housekeeping needs to know of one lane.
pub struct HousekeptLane {
    /// Index of the camera in the configuration, or behind the cameras of the body.
    pub camera: usize,
    /// Where the lane reports.
    pub board: Arc<LaneBoard>,
    /// The truth, for a synthetic camera.
    pub truth: Option<Box<dyn TruthProvider>>,
}

/// What housekeeping looks after.
pub struct Duties {
    /// Every lane.
    pub lanes: Vec<HousekeptLane>,
    /// The world.
    pub keeper: Keeper,
    /// When raised, the world is defined anew.
    pub reset: Arc<AtomicBool>,
}

/// The running thread.
#[derive(Debug)]
pub struct Housekeeping {
    thread: JoinHandle<()>,
    stop: StopFlag,
}

/// Why housekeeping did not start.
#[derive(Debug, thiserror::Error)]
pub enum HousekeepingError {
    /// A service could not be opened.
    #[error(transparent)]
    Publisher(#[from] PublisherError),
    /// The thread could not be started.
    #[error("cannot start the housekeeping thread: {0}")]
    Thread(#[from] std::io::Error),
    /// The thread ended by itself.
    #[error("the housekeeping thread ended while starting")]
    Ended,
}

impl Housekeeping {
    /// Starts the thread; returns once its services are open.
    ///
    /// # Errors
    /// [`HousekeepingError`].
    pub fn start(
        domain: &Domain,
        config: &Config,
        duties: Duties,
        overview: &Overview,
        unix_offset: &UnixOffset,
    ) -> Result<Self, HousekeepingError> {
        let stop = StopFlag::new();
        let (ready, opened) = sync_channel(1);
        let thread = {
            let (domain, config) = (domain.clone(), config.clone());
            let (overview, stop) = (overview.clone(), stop.clone());
            let unix_offset = unix_offset.clone();
            thread::Builder::new().name("housekeeping".into()).spawn(move || {
                serve(&domain, &config, duties, &overview, &unix_offset, &stop, &ready);
            })?
        };
        match opened.recv() {
            Ok(Ok(())) => Ok(Self { thread, stop }),
            Ok(Err(e)) => Err(e.into()),
            Err(_) => Err(HousekeepingError::Ended),
        }
    }

    /// Whether the thread ended without being asked to.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Stops the thread, after a last health message; `false` if it had panicked.
    pub fn stop(self) -> bool {
        self.stop.raise();
        self.thread.join().is_ok()
    }
}

/// One lane's ports and monitor, on the thread.
struct Kept {
    monitor: LaneMonitor,
    health: HealthPublisher,
    truth: Option<(TruthPublisher, Box<dyn TruthProvider>)>,
}

impl Kept {
    fn open(
        node: &Node<ipc::Service>,
        config: &Config,
        lane: HousekeptLane,
    ) -> Result<Self, PublisherError> {
        let (settings, name) = (&config.shared_memory, config.published_as(lane.camera).0);
        let health = HealthPublisher::open(node, settings, name)?;
        let with_port = |provider| {
            Ok::<_, PublisherError>((TruthPublisher::open(node, settings, name)?, provider))
        };
        let truth = lane.truth.map(with_port).transpose()?;
        let monitor = LaneMonitor::new(config, lane.camera, lane.board, HostTime::now());
        Ok(Self { monitor, health, truth })
    }

    fn publish_truth(&mut self) {
        if let Some((port, provider)) = &mut self.truth
            && let Some(truth) = provider.truth_at_now()
        {
            port.publish(&truth);
        }
    }

    /// `shared_errors` are those of the services that all lanes share; each lane's health has them.
    fn publish_health(&mut self, shared_errors: u64) {
        let truth_errors = self.truth.as_ref().map_or(0, |(port, _)| port.errors());
        let errors = self.health.errors() + truth_errors + shared_errors;
        let health = self.monitor.end_interval(HostTime::now(), errors);
        self.health.publish(&health);
    }
}

type Ready = SyncSender<Result<(), PublisherError>>;

fn serve(
    domain: &Domain,
    config: &Config,
    duties: Duties,
    overview: &Overview,
    unix_offset: &UnixOffset,
    stop: &StopFlag,
    ready: &Ready,
) {
    let opened = domain.open_node("lodestoned").map_err(Into::into).and_then(|node| {
        let kept = duties.lanes.into_iter().map(|lane| Kept::open(&node, config, lane));
        let kept = kept.collect::<Result<Vec<_>, PublisherError>>()?;
        let world = WorldDuty::open(&node, config, duties.keeper, duties.reset)?;
        prefault(&domain.prefix)?;
        lock_memory_of(config, &kept);
        Ok((kept, world, node))
    });
    let (mut kept, mut world, node) = match opened {
        Ok(opened) => opened,
        Err(e) => return drop(ready.send(Err(e))),
    };
    overview.set(kept.iter().map(|lane| lane.monitor.view()).collect());
    // The receiver waits in `start`; if that thread died, the stop flag will not come either.
    if ready.send(Ok(())).is_ok() {
        keep(&mut kept, &mut world, &node, overview, unix_offset, stop);
    }
}

/// Without it the lanes run on, and their health says so.
fn lock_memory_of(config: &Config, lanes: &[Kept]) {
    if !config.realtime.lock_memory {
        return;
    }
    if let Err(refusal) = lock_memory() {
        tracing::warn!("{refusal}");
        for lane in lanes {
            lane.monitor.roster().note_memory_refused();
        }
    }
}

fn publish_health(lanes: &mut [Kept], world: &WorldDuty) {
    for lane in lanes {
        lane.publish_health(world.errors());
    }
}

fn keep(
    kept: &mut [Kept],
    world: &mut WorldDuty,
    node: &Node<ipc::Service>,
    overview: &Overview,
    unix_offset: &UnixOffset,
    stop: &StopFlag,
) {
    let has_truth = kept.iter().any(|lane| lane.truth.is_some());
    let pause = if has_truth { TRUTH_TICK } else { TICK };
    let mut space = SpaceWatch::default();
    let (mut last_look, mut last_health) = (Instant::now(), Instant::now());
    while !stop.is_raised() {
        thread::sleep(pause);
        kept.iter_mut().for_each(Kept::publish_truth);
        if last_health.elapsed() >= HEALTH_INTERVAL {
            last_health = Instant::now();
            unix_offset.refresh();
            for lane in kept.iter() {
                lane.monitor.roster().pin_again();
            }
            publish_health(kept, world);
            world.publish(unix_offset.as_nanos());
            // Files of consumers that were killed stay until somebody looks.
            node.try_cleanup_dead_nodes();
            space.look();
        }
        if last_look.elapsed() >= TICK {
            last_look = Instant::now();
            world.look(unix_offset.as_nanos());
            overview.set(kept.iter().map(|lane| lane.monitor.view()).collect());
        }
    }
    // Consumers read how it ended.
    world.finish();
    publish_health(kept, world);
    overview.set(kept.iter().map(|lane| lane.monitor.view()).collect());
}
