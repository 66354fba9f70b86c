//! `lodestoned run`: everything in the order in which it must start, and back again.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use lodestone_config::model::Config;
use lodestone_config::{LoadError, Loaded};
use lodestone_schema::transport::{Domain, DomainError};
use tracing::info;

use super::supervision::{LaneContext, LaneFailure, Lanes, StartedLane};
use crate::cli::RunArgs;
use crate::clock::UnixOffset;
use crate::console::Console;
use crate::rig::{is_member, lane as rig_lane};
use crate::service::housekeeping::{Duties, Housekeeping, HousekeepingError, HousekeptLane};
use crate::service::instance::{InstanceError, InstanceLock};
use crate::service::leftovers;
use crate::service::overview::Overview;
use crate::service::signals::{StopFlag, reset_on_signal};
use crate::service::space::{self, SpaceError};
use crate::status_board::LaneBoard;
use crate::world::{Beginning, Keeper, Place, WorldFrame};

/// Between two looks at lanes, signals and console: five redraws a second.
const TICK: Duration = Duration::from_millis(200);

/// Why the daemon did not start, or stopped.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// There is nothing to do.
    #[error("the configuration has no camera: add a [[camera]] section")]
    NoCamera,
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(std::io::Error),
    /// Another daemon runs, or the domain's directory cannot be used.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// There is too little shared memory.
    #[error(transparent)]
    Space(#[from] SpaceError),
    /// The domain cannot be entered.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The kept world cannot be used.
    #[error(transparent)]
    World(#[from] LoadError),
    /// A lane did not start, or failed.
    #[error("camera {camera:?}: {failure}")]
    Lane {
        /// The camera's name.
        camera: String,
        /// What happened.
        failure: LaneFailure,
    },
    /// Housekeeping did not start.
    #[error(transparent)]
    Housekeeping(#[from] HousekeepingError),
    /// Housekeeping ended: a bug.
    #[error("the housekeeping thread panicked")]
    HousekeepingPanicked,
}

impl RunError {
    /// 2 where the configuration is to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::NoCamera
            | Self::World(_)
            | Self::Domain(DomainError::Prefix(_) | DomainError::Root(_)) => 2,
            _ => 1,
        }
    }
}

/// Runs until a signal, the end of the duration, the end of every source, or a failure.
///
/// `start` starts one camera's lane and returns when it is ready. Start order: lock, leftovers of
/// killed processes, space, lanes, housekeeping, console; back in reverse, but housekeeping outlives the lanes, so
/// that the last health message says that they ended.
///
/// # Errors
/// [`RunError`]; whatever was started has been stopped again by then.
pub fn run(
    loaded: Loaded,
    args: &RunArgs,
    mut console: Console,
    mut start: impl FnMut(LaneContext) -> Result<StartedLane, LaneFailure>,
) -> Result<(), RunError> {
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(RunError::Signals)?;
    let reset = reset_on_signal().map_err(RunError::Signals)?;
    let kept = loaded.kept_world()?;
    let loaded = Arc::new(loaded);
    let (domain, _lock) = prepare(&loaded.config)?;
    let unix_offset = UnixOffset::sampled();
    let (keeper, Beginning { frame, places }) = Keeper::begin(&loaded, kept);
    let mut lanes = Lanes::default();
    let members = contexts(&loaded, &domain, &unix_offset, &frame, (&places, &stop));
    let result =
        start_all(&loaded.config, &mut lanes, &members, &mut start).and_then(|lanes_kept| {
            let duties = Duties { lanes: lanes_kept, keeper, reset };
            let overview = Overview::default();
            let housekeeping =
                Housekeeping::start(&domain, &loaded.config, duties, &overview, &unix_offset)?;
            info!("serving {} cameras in {}", loaded.config.camera.len(), domain.root);
            let watched = watch(&mut lanes, &housekeeping, &overview, &mut console, args, &stop);
            stop.raise();
            let joined = lanes.join_all().map_err(lane_error);
            let kept_well = housekeeping.stop();
            console.show(&overview.views());
            watched.and(joined).and(kept_well.then_some(()).ok_or(RunError::HousekeepingPanicked))
        });
    stop.raise();
    let joined = lanes.join_all().map_err(lane_error);
    info!("stopped");
    result.and(joined)
}

/// What must hold before the first file is made in shared memory.
fn prepare(config: &Config) -> Result<(Domain, InstanceLock), RunError> {
    if config.camera.is_empty() {
        return Err(RunError::NoCamera);
    }
    let settings = &config.shared_memory;
    let domain = Domain { prefix: settings.prefix.clone(), root: settings.root.clone() };
    let entered = domain.enter()?;
    let lock = InstanceLock::acquire(&domain.root)?;
    // A killed predecessor's memory would count as taken.
    leftovers::clear(entered);
    space::ensure(space::needed_bytes(config), &domain.prefix)?;
    Ok((domain, lock))
}

/// What each camera's lane needs to know.
fn contexts(
    loaded: &Arc<Loaded>,
    domain: &Domain,
    unix_offset: &UnixOffset,
    world: &Arc<WorldFrame>,
    (places, stop): (&[Option<Place>], &StopFlag),
) -> Vec<LaneContext> {
    let context = |(camera, place): (usize, &Option<Place>)| LaneContext {
        camera,
        loaded: Arc::clone(loaded),
        domain: domain.clone(),
        board: Arc::new(LaneBoard::new()),
        unix_offset: unix_offset.clone(),
        world: Arc::clone(world),
        kept_place: *place,
        stop: stop.clone(),
    };
    places.iter().take(loaded.config.camera.len()).enumerate().map(context).collect()
}

/// Starts a lane for each camera that moves for itself, and one for each rig.
fn start_all(
    config: &Config,
    lanes: &mut Lanes,
    contexts: &[LaneContext],
    start: &mut impl FnMut(LaneContext) -> Result<StartedLane, LaneFailure>,
) -> Result<Vec<HousekeptLane>, RunError> {
    let mut kept = Vec::new();
    for context in contexts.iter().filter(|c| !is_member(config, c.camera)) {
        let (camera, board) = (context.camera, Arc::clone(&context.board));
        let name = &config.camera[camera].name;
        let started = start(context.clone()).map_err(|e| lane_error((name.clone(), e)))?;
        lanes.add(name, started.handle);
        kept.push(HousekeptLane { camera, board, truth: started.truth });
    }
    for rig in config.rigs() {
        let name = &config.body[rig.body].name;
        let members = rig.members.iter().map(|&camera| contexts[camera].clone()).collect();
        let started = rig_lane::start(&rig, members).map_err(|e| lane_error((name.clone(), e)))?;
        lanes.add(name, started.handle);
        kept.extend(started.kept);
    }
    kept.sort_by_key(|lane| lane.camera);
    Ok(kept)
}

fn watch(
    lanes: &mut Lanes,
    housekeeping: &Housekeeping,
    overview: &Overview,
    console: &mut Console,
    args: &RunArgs,
    stop: &StopFlag,
) -> Result<(), RunError> {
    let start = Instant::now();
    let remaining = || args.duration.map_or(TICK, |limit| limit.saturating_sub(start.elapsed()));
    while !stop.is_raised() && !remaining().is_zero() {
        console.show(&overview.views());
        if lanes.reap().map_err(lane_error)? {
            info!("every source ended");
            break;
        }
        if housekeeping.is_finished() {
            return Err(RunError::HousekeepingPanicked);
        }
        thread::sleep(TICK.min(remaining()));
    }
    Ok(())
}

fn lane_error((camera, failure): (String, LaneFailure)) -> RunError {
    RunError::Lane { camera, failure }
}
