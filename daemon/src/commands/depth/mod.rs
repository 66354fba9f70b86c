//! `lodestoned depth`: the depth source of synthetic cameras, a process of its own.
//!
//! It follows the `truth` service of each camera as a consumer would, casts rays into the configured
//! scene, and publishes what they meet as clouds. Of the daemon's estimate it knows nothing.

mod schedule;
mod source;
mod tally;

use std::io;
use std::thread;
use std::time::{Duration, Instant};

use lodestone_client::{CameraNameError, Client, DomainError, PublishError};
use lodestone_config::Loaded;
use lodestone_config::model::{Config, DriverKind};
use tracing::info;

use crate::cli::DepthArgs;
use crate::scene::{DepthCamera, Scene};
use crate::service::signals::StopFlag;
use source::Source;
use tally::Tally;

/// Between two looks at the clock and at the sources.
const TICK: Duration = Duration::from_millis(50);

/// Why there is no depth source.
#[derive(Debug, thiserror::Error)]
pub enum DepthError {
    /// There is nothing to see.
    #[error(
        "the configuration has no scene: add a table [scene.room], as in config/shipped/default.toml"
    )]
    NoScene,
    /// No such camera.
    #[error("there is no camera {name:?}; allowed: {known}")]
    UnknownCamera {
        /// As asked for.
        name: String,
        /// What is configured.
        known: String,
    },
    /// A camera that is not simulated has no true place.
    #[error("camera {0:?} is not synthetic; allowed: a camera with driver = \"synthetic\"")]
    NotSynthetic(String),
    /// A camera was named twice.
    #[error("camera {0:?} is named twice; allowed: each camera once")]
    Twice(String),
    /// Signals cannot be handled.
    #[error("cannot handle signals: {0}")]
    Signals(io::Error),
    /// The domain cannot be entered.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// A name that no service can have.
    #[error(transparent)]
    Name(#[from] CameraNameError),
    /// Clouds that cannot be published at all.
    #[error(transparent)]
    Publish(#[from] PublishError),
    /// There is no thread to be had.
    #[error("cannot start a thread: {0}")]
    Thread(io::Error),
    /// A source ended: a bug.
    #[error("the depth source of camera {0:?} panicked")]
    Panicked(String),
}

impl DepthError {
    /// 2 where command line or configuration are to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::NoScene
            | Self::UnknownCamera { .. }
            | Self::NotSynthetic(_)
            | Self::Twice(_)
            | Self::Domain(DomainError::Prefix(_) | DomainError::Root(_)) => 2,
            _ => 1,
        }
    }
}

/// Publishes clouds until a signal or the end of the duration.
///
/// # Errors
/// [`DepthError`]; a daemon that does not run yet is none, it is waited for.
pub fn depth(loaded: &Loaded, args: &DepthArgs) -> Result<(), DepthError> {
    let config = &loaded.config;
    let scene = Scene::new(config.scene.as_ref().ok_or(DepthError::NoScene)?);
    let cameras = chosen(config, &args.camera)?;
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(DepthError::Signals)?;
    let memory = &config.shared_memory;
    let client = Client::builder()
        .prefix(&memory.prefix)
        .root(&memory.root)
        .name("lodestoned depth")
        .connect()?;
    thread::scope(|scope| {
        let start = |(name, camera): (String, DepthCamera)| {
            let (client, scene, stop) = (client.clone(), &scene, &stop);
            let source_name = name.clone();
            let serve = move || Ok(Source::open(&client, source_name, camera)?.serve(scene, stop));
            let thread = thread::Builder::new().name(format!("depth-{name}"));
            let handle = thread.spawn_scoped(scope, serve).map_err(DepthError::Thread)?;
            Ok(Running { name, handle })
        };
        let started: Result<Vec<_>, DepthError> = cameras.into_iter().map(start).collect();
        let running = started.inspect_err(|_| stop.raise())?;
        watch(&running, args.duration, &stop);
        stop.raise();
        running.into_iter().try_for_each(Running::end)
    })
}

/// The cameras that were asked for.
fn chosen(config: &Config, names: &[String]) -> Result<Vec<(String, DepthCamera)>, DepthError> {
    let one = |(before, name): (usize, &String)| {
        if names[..before].contains(name) {
            return Err(DepthError::Twice(name.clone()));
        }
        let found = config.camera.iter().enumerate().find(|(_, camera)| camera.name == *name);
        let (index, camera) = found.ok_or_else(|| unknown(config, name))?;
        if camera.driver != DriverKind::Synthetic {
            return Err(DepthError::NotSynthetic(name.clone()));
        }
        Ok((name.clone(), DepthCamera::new(camera, index)))
    };
    names.iter().enumerate().map(one).collect()
}

fn unknown(config: &Config, name: &str) -> DepthError {
    let known: Vec<&str> = config.camera.iter().map(|camera| camera.name.as_str()).collect();
    DepthError::UnknownCamera { name: name.into(), known: known.join(", ") }
}

/// One source on its thread.
struct Running<'scope> {
    name: String,
    handle: thread::ScopedJoinHandle<'scope, Result<Tally, DepthError>>,
}

impl Running<'_> {
    fn end(self) -> Result<(), DepthError> {
        let tally = self.handle.join().map_err(|_| DepthError::Panicked(self.name.clone()))??;
        info!("{}: {tally}", self.name);
        Ok(())
    }
}

/// Waits for the end: a signal, the duration, or a source that failed.
fn watch(running: &[Running<'_>], duration: Option<Duration>, stop: &StopFlag) {
    let start = Instant::now();
    let over = || duration.is_some_and(|limit| start.elapsed() >= limit);
    while !stop.is_raised() && !over() && !running.iter().any(|r| r.handle.is_finished()) {
        let left = duration.map_or(TICK, |limit| limit.saturating_sub(start.elapsed()));
        thread::sleep(left.min(TICK));
    }
}
