//! Lanes as the daemon sees them: started, watched, joined.

use std::any::Any;
use std::fmt::Display;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use lodestone_config::Loaded;
use lodestone_config::model::Camera;
use lodestone_schema::LaneState;
use lodestone_schema::transport::Domain;

use crate::clock::UnixOffset;
use crate::lane::LaneSettings;
use crate::service::housekeeping::TruthProvider;
use crate::service::signals::StopFlag;
use crate::status_board::LaneBoard;
use crate::world::{MemberSettings, Membership, Place, WorldFrame};

/// A lane must say within this time that its services are open.
const START_LIMIT: Duration = Duration::from_secs(10);

/// Everything a lane needs to know.
#[derive(Clone, Debug)]
pub struct LaneContext {
    /// Index of the camera in the configuration.
    pub camera: usize,
    /// The whole configuration, and where it came from.
    pub loaded: Arc<Loaded>,
    /// Where the lane publishes.
    pub domain: Domain,
    /// Where the lane reports.
    pub board: Arc<LaneBoard>,
    /// From `CLOCK_MONOTONIC` to UNIX time; housekeeping keeps it up to date.
    pub unix_offset: UnixOffset,
    /// The world that all lanes share.
    pub world: Arc<WorldFrame>,
    /// Where the camera was in the last run, as far as it was kept.
    pub kept_place: Option<Place>,
    /// When raised, the lane ends.
    pub stop: StopFlag,
}

impl LaneContext {
    /// The lane's part in the world.
    pub fn membership(&self, settings: &LaneSettings) -> Membership {
        let settings = MemberSettings { kept: self.kept_place, ..settings.member };
        Membership::new(Arc::clone(&self.world), self.camera, settings)
    }

    /// The camera's own settings.
    pub fn settings(&self) -> &Camera {
        &self.loaded.config.camera[self.camera]
    }
}

/// Why a lane ended, when it should not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LaneFailure {
    /// It said so.
    #[error("{0}")]
    Error(String),
    /// A bug: its thread panicked.
    #[error("panicked: {0}")]
    Panic(String),
    /// It did not open its services in time.
    #[error("was not ready within {} s", START_LIMIT.as_secs())]
    NotReady,
}

impl LaneFailure {
    /// Takes any error.
    pub fn of(error: impl Display) -> Self {
        Self::Error(error.to_string())
    }
}

/// A lane that runs.
pub trait LaneHandle {
    /// Whether it has ended.
    fn is_finished(&self) -> bool;

    /// Waits for its end.
    ///
    /// # Errors
    /// [`LaneFailure`] if it failed or panicked.
    fn join(self: Box<Self>) -> Result<(), LaneFailure>;
}

/// A lane that was started.
pub struct StartedLane {
    /// To watch and to join it.
    pub handle: Box<dyn LaneHandle>,
    /// The truth beside it, for a synthetic camera.
    pub truth: Option<Box<dyn TruthProvider>>,
}

/// With this a lane says that its services are open and its poses will come.
#[derive(Debug)]
pub struct Ready(SyncSender<()>);

impl Ready {
    /// Says it.
    pub fn tell(self) {
        // Whoever waited gave up; the stop flag says so.
        let _ = self.0.send(());
    }
}

/// A lane on a thread of its own.
#[derive(Debug)]
pub struct LaneThread(JoinHandle<Result<(), LaneFailure>>);

impl LaneThread {
    /// Starts a lane's body and waits until it [says](Ready::tell) that it is ready. When the body
    /// ends, in whichever way, the board says [`LaneState::Ended`].
    ///
    /// # Errors
    /// [`LaneFailure`] if the body ended instead, or took too long.
    pub fn start<B>(context: LaneContext, body: B) -> Result<Self, LaneFailure>
    where
        B: FnOnce(&LaneContext, Ready) -> Result<(), LaneFailure> + Send + 'static,
    {
        let name = context.settings().name.clone();
        let (stop, boards) = (context.stop.clone(), vec![Arc::clone(&context.board)]);
        Self::start_named(&name, &stop, boards, move |ready| body(&context, ready))
    }

    /// The same for a lane that reports on several boards.
    ///
    /// # Errors
    /// As [`LaneThread::start`].
    pub fn start_named<B>(
        name: &str,
        stop: &StopFlag,
        boards: Vec<Arc<LaneBoard>>,
        body: B,
    ) -> Result<Self, LaneFailure>
    where
        B: FnOnce(Ready) -> Result<(), LaneFailure> + Send + 'static,
    {
        let (sender, ready) = sync_channel(1);
        let name = format!("lane-{name}");
        let run = move || {
            let ended = SayEnded(boards);
            let result = body(Ready(sender));
            drop(ended);
            result
        };
        let thread = thread::Builder::new().name(name).spawn(run).map_err(LaneFailure::of)?;
        match ready.recv_timeout(START_LIMIT) {
            Ok(()) => Ok(Self(thread)),
            Err(RecvTimeoutError::Timeout) => {
                stop.raise();
                Err(LaneFailure::NotReady)
            }
            Err(RecvTimeoutError::Disconnected) => Box::new(Self(thread))
                .join()
                .and_then(|()| Err(LaneFailure::of("it ended before it was ready"))),
        }
    }
}

/// Also while a panic unwinds.
struct SayEnded(Vec<Arc<LaneBoard>>);

impl Drop for SayEnded {
    fn drop(&mut self) {
        self.0.iter().for_each(|board| board.set_state(LaneState::Ended));
    }
}

impl LaneHandle for LaneThread {
    fn is_finished(&self) -> bool {
        self.0.is_finished()
    }

    fn join(self: Box<Self>) -> Result<(), LaneFailure> {
        self.0.join().unwrap_or_else(|panic| Err(LaneFailure::Panic(message_of(&*panic))))
    }
}

fn message_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    text.unwrap_or_else(|| "no message".into())
}

/// Lanes in the order of the configuration, each until it has ended.
#[derive(Default)]
pub struct Lanes(Vec<(String, Option<Box<dyn LaneHandle>>)>);

impl Lanes {
    /// Takes a started lane.
    pub fn add(&mut self, camera: &str, handle: Box<dyn LaneHandle>) {
        self.0.push((camera.into(), Some(handle)));
    }

    /// Joins what has ended; `Ok(true)` once no lane is left.
    ///
    /// # Errors
    /// The first lane that failed, with its camera.
    pub fn reap(&mut self) -> Result<bool, (String, LaneFailure)> {
        self.join_if(|lane| lane.is_finished())?;
        Ok(self.0.iter().all(|(_, lane)| lane.is_none()))
    }

    /// Joins every lane, also after one failed.
    ///
    /// # Errors
    /// The first lane that failed, with its camera.
    pub fn join_all(&mut self) -> Result<(), (String, LaneFailure)> {
        self.join_if(|_| true)
    }

    fn join_if(
        &mut self,
        wanted: fn(&dyn LaneHandle) -> bool,
    ) -> Result<(), (String, LaneFailure)> {
        let mut result = Ok(());
        for (camera, lane) in &mut self.0 {
            let Some(handle) = lane.take_if(|lane| wanted(&**lane)) else { continue };
            if let Err(failure) = handle.join() {
                result = result.and(Err((camera.clone(), failure)));
            }
        }
        result
    }
}
