//! A rig's lane, wired: each member's driver → ring on a thread of its own; all rings → worker →
//! publishers on the rig's.

use std::sync::Arc;

use lodestone_config::model::Rig;

use super::core::RigCore;
use super::settings::RigSettings;
use super::worker::{Outlet, RigWorker};
use crate::commands::supervision::{LaneContext, LaneFailure, LaneHandle, LaneThread, Ready};
use crate::driver::Driver;
use crate::pipeline::{PATIENCE, Reader};
use crate::publisher::{AidingInbox, LanePublisher};
use crate::reading::HostTime;
use crate::realtime::{ThreadSetup, enter};
use crate::ring::{Consumer, Doorbell, ring_with, wait_for_any};
use crate::service::housekeeping::{HousekeptLane, TruthProvider};
use crate::source::{Source, open};
use crate::status_board::LaneBoard;
use crate::world::Membership;

/// A rig's lane that was started.
pub struct StartedRig {
    /// To watch and to join it.
    pub handle: Box<dyn LaneHandle>,
    /// What housekeeping looks after: the body and each member.
    pub kept: Vec<HousekeptLane>,
}

/// What the rig's thread begins with.
struct Begin {
    rig: Rig,
    members: Vec<LaneContext>,
    sources: Vec<Source>,
    board: Arc<LaneBoard>,
}

/// Starts the lane of one rig with its members; returns once its services are open.
///
/// # Errors
/// [`LaneFailure`] names what could not be opened.
pub fn start(rig: &Rig, members: Vec<LaneContext>) -> Result<StartedRig, LaneFailure> {
    let mut sources = Vec::new();
    let mut truths: Vec<Option<Box<dyn TruthProvider>>> = Vec::new();
    for context in &members {
        let mut source = open(context).map_err(LaneFailure::of)?;
        truths.push(source.truth.take());
        sources.push(source);
    }
    let first = &members[0];
    let (config, stop) = (&first.loaded.config, first.stop.clone());
    let (name, body_id) = (config.body[rig.body].name.clone(), config.camera.len() + rig.body);
    let board = Arc::new(LaneBoard::new());
    let mut kept = vec![HousekeptLane { camera: body_id, board: Arc::clone(&board), truth: None }];
    for (context, truth) in members.iter().zip(truths) {
        let (camera, board) = (context.camera, Arc::clone(&context.board));
        kept.push(HousekeptLane { camera, board, truth });
    }
    let boards = kept.iter().map(|lane| Arc::clone(&lane.board)).collect();
    let begin = Begin { rig: rig.clone(), members, sources, board };
    let handle = LaneThread::start_named(&name, &stop, boards, move |ready| run(begin, ready))?;
    Ok(StartedRig { handle: Box::new(handle), kept })
}

/// The lane's body, on its own thread: iceoryx2's ports stay on the thread that made them.
fn run(begin: Begin, ready: Ready) -> Result<(), LaneFailure> {
    let Begin { rig, members, sources, board } = begin;
    let rates: Vec<f64> = sources.iter().map(|s| s.driver.info().nominal_rate_hz).collect();
    let first = &members[0];
    let settings = RigSettings::new(&first.loaded, &rig, &rates).map_err(LaneFailure::of)?;
    let settings = settings.with_kept(first.kept_place);
    let world = Arc::clone(&first.world);
    let membership = Membership::new(world, first.camera, settings.place);
    let setup = ThreadSetup::of_body(&first.loaded.config, rig.body, &rig.members);
    let roster = Arc::clone(&board.roster);
    let core = RigCore::in_world(&settings, membership);
    let body = Outlet { publisher: publisher(first, &settings.body)?, board };
    let mut outlets = Vec::new();
    for (context, source) in members.iter().zip(&sources) {
        let name = &context.settings().name;
        tracing::info!(
            camera = name,
            body = settings.body,
            source = source.driver.info().description,
            "lane starts"
        );
        let (publisher, board) = (publisher(context, name)?, Arc::clone(&context.board));
        outlets.push((Outlet { publisher, board }, source.host_rate));
    }
    let inboxes = inboxes(&members, &settings.body)?;
    let worker = RigWorker::new(core, settings, body, outlets, first.unix_offset.clone());
    let _enrolled = enter(&setup, &roster);
    ready.tell();
    let drivers = sources.into_iter().map(|source| source.driver).collect();
    serve(&members, drivers, worker, inboxes)
}

/// What others measure at each member, and at the body's origin.
type Inboxes = Vec<(Option<usize>, AidingInbox)>;

fn inboxes(members: &[LaneContext], body: &str) -> Result<Inboxes, LaneFailure> {
    let open = |name: &str| {
        let settings = &members[0].loaded.config.shared_memory;
        AidingInbox::open(&members[0].domain, settings, name).map_err(LaneFailure::of)
    };
    let of_members = members.iter().enumerate();
    let of_members = of_members.map(|(k, context)| Ok((Some(k), open(&context.settings().name)?)));
    of_members.chain([open(body).map(|inbox| (None, inbox))]).collect()
}

fn publisher(context: &LaneContext, name: &str) -> Result<LanePublisher, LaneFailure> {
    let settings = &context.loaded.config.shared_memory;
    LanePublisher::open(&context.domain, settings, name).map_err(LaneFailure::of)
}

/// Takes readings out of all rings until every source has ended.
fn serve(
    members: &[LaneContext],
    drivers: Vec<Box<dyn Driver>>,
    mut worker: RigWorker<LanePublisher>,
    mut inboxes: Inboxes,
) -> Result<(), LaneFailure> {
    let bell = Doorbell::default();
    let capacity = members[0].loaded.config.lane.ring_capacity;
    let (mut readers, mut consumers): (Vec<Reader>, Vec<Consumer>) = (Vec::new(), Vec::new());
    for (context, driver) in members.iter().zip(drivers) {
        let (producer, consumer) = ring_with(capacity, bell.clone());
        readers.push(Reader::start(context, driver, producer)?);
        consumers.push(consumer);
    }
    while !consumers.iter().all(|consumer| consumer.is_closed() && consumer.is_empty()) {
        wait_for_any(&bell, &consumers, PATIENCE);
        for (member, inbox) in &mut inboxes {
            while let Some(message) = inbox.next_message() {
                worker.hear(*member, &message);
            }
        }
        drain(&mut consumers, &mut worker);
        for (member, reader) in readers.iter().enumerate() {
            worker.watch(member, reader.state(), HostTime::now());
        }
    }
    readers.into_iter().try_for_each(Reader::join)
}

/// Takes what waits, one reading of each member in turn, so that none runs ahead.
fn drain(consumers: &mut [Consumer], worker: &mut RigWorker<LanePublisher>) {
    loop {
        let mut any = false;
        for (member, consumer) in consumers.iter_mut().enumerate() {
            if let Some((reading, in_ring)) = consumer.pop_stamped() {
                worker.take(member, &reading, in_ring);
                any = true;
            }
        }
        if !any {
            return;
        }
    }
}
