//! The demo's consumer: a process that knows the client's library and nothing else of the daemon.
//!
//! ```text
//! CloudMerger (clouds placed by their camera's own pose) ─> Merges ─┬─> VoxelMap each ─> PLY
//! OtherPoses (truth, without magnetometer), CloudRefiner (ICP) ─────┘
//! ```
//!
//! One stream of clouds feeds all merges, so that they differ by poses alone.

mod files;
mod merges;
mod poses;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lodestone_client::{
    CameraMerge, CameraNameError, Client, CloudMerger, DomainError, MergeError, RefineError,
    VoxelMapError,
};

use super::event::Event;
use super::result::Seen;
use super::setup::CAMERAS;
use crate::service::signals::StopFlag;
pub use files::REPORT;
use merges::{Merges, Watched};
use poses::OtherPoses;

/// How long poses and clouds may take to come.
const PATIENCE: Duration = Duration::from_mins(1);
/// Between two lines of progress.
const TELL: Duration = Duration::from_millis(200);
/// How long a cloud is waited for at a time.
const CLOUD_WAIT: Duration = Duration::from_millis(50);

/// Why the consumer cannot do its part.
#[derive(Debug, thiserror::Error)]
pub enum ConsumerError {
    /// There is no such place in shared memory.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// A camera's name is none.
    #[error(transparent)]
    Name(#[from] CameraNameError),
    /// The clouds cannot be merged so.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// A map cannot be made.
    #[error(transparent)]
    Map(#[from] VoxelMapError),
    /// Clouds cannot be laid over each other.
    #[error(transparent)]
    Refine(#[from] RefineError),
    /// Something never came.
    #[error("{what} did not come within {} s", PATIENCE.as_secs())]
    Missing {
        /// What.
        what: String,
    },
    /// Nothing was merged of a camera.
    #[error("nothing was merged of camera {camera:?}: {why}")]
    Nothing {
        /// The camera.
        camera: String,
        /// What is known of the reason.
        why: String,
    },
    /// SIGINT or SIGTERM.
    #[error("interrupted")]
    Interrupted,
    /// A file cannot be written.
    #[error("{}: cannot be written: {what}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        what: String,
    },
}

/// How long to settle and to merge.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Between the last pose's initialisation and the first cloud that counts.
    pub settle: Duration,
    /// Clouds that count.
    pub merge: Duration,
}

/// Merges the clouds of the demo's cameras and writes what came of it into a directory; tells its progress on
/// standard output.
///
/// # Errors
/// [`ConsumerError`].
pub fn consume(out: &Path, times: Times, stop: &StopFlag) -> Result<(), ConsumerError> {
    let client = Client::builder().name("lodestoned-demo-consumer").connect()?;
    let mut merger = merger(&client)?;
    let watched = CAMERAS.map(|name| Ok(Watched::new(name, OtherPoses::open(&client, name)?)));
    let watched = watched.into_iter().collect::<Result<_, CameraNameError>>()?;
    let mut merges = Merges::new(watched)?;

    wait_for_all(&mut merger, &mut merges, stop)?;
    tell(&Event::Settling);
    until(times.settle, stop, |_| {
        // Young filters still move: what they place would smear. ICP may learn the surfaces meanwhile.
        if let Some(cloud) = merger.wait(CLOUD_WAIT) {
            merges.refine(&cloud);
        }
        None
    })?;
    until(times.merge, stop, |share| {
        if let Some(cloud) = merger.wait(CLOUD_WAIT) {
            merges.take(&cloud);
        }
        Some(Event::Merging { share, points: merges.points() })
    })?;
    tell(&Event::Writing);
    files::write(out, &merges, &seen(&merger, &merges, times)?)
}

fn merger(client: &Client) -> Result<CloudMerger, MergeError> {
    let builder = client.merger();
    CAMERAS.into_iter().fold(builder, |b, name| b.camera(CameraMerge::new(name))).open()
}

/// Waits until each camera's clouds come with its own pose, and all other poses are there.
fn wait_for_all(
    merger: &mut CloudMerger,
    merges: &mut Merges,
    stop: &StopFlag,
) -> Result<(), ConsumerError> {
    let (begin, mut told) = (Instant::now(), String::new());
    let mut has_cloud = CAMERAS.map(|_| false);
    loop {
        if let Some(cloud) = merger.wait(CLOUD_WAIT) {
            has_cloud[cloud.camera()] = true;
        }
        let Some(what) = missing(&has_cloud, merger, merges) else { return Ok(()) };
        if stop.is_raised() {
            return Err(ConsumerError::Interrupted);
        }
        if begin.elapsed() > PATIENCE {
            return Err(ConsumerError::Missing { what });
        }
        if what != told {
            tell(&Event::Waiting { what: what.clone() });
            told = what;
        }
    }
}

fn missing(has_cloud: &[bool], merger: &CloudMerger, merges: &mut Merges) -> Option<String> {
    for (index, name) in CAMERAS.iter().enumerate() {
        if !has_cloud[index] {
            let refused = merger.refused(index).map(|why| format!(" ({why})"));
            return Some(format!("a cloud of {name} with its pose{}", refused.unwrap_or_default()));
        }
        if let Some(what) = merges.watched[index].missing() {
            return Some(format!("{what} of {name}"));
        }
    }
    None
}

/// Does something again and again for a time, with the share of it that is over, and tells what it gives.
fn until<T: Into<Option<Event>>>(
    time: Duration,
    stop: &StopFlag,
    mut step: impl FnMut(f64) -> T,
) -> Result<(), ConsumerError> {
    let (begin, mut told) = (Instant::now(), Instant::now());
    while begin.elapsed() < time {
        if stop.is_raised() {
            return Err(ConsumerError::Interrupted);
        }
        let event = step(begin.elapsed().as_secs_f64() / time.as_secs_f64()).into();
        if let Some(event) = event.filter(|_| told.elapsed() >= TELL) {
            tell(&event);
            told = Instant::now();
        }
    }
    Ok(())
}

fn seen(merger: &CloudMerger, merges: &Merges, times: Times) -> Result<Seen, ConsumerError> {
    let nothing = |index: usize| ConsumerError::Nothing {
        camera: CAMERAS[index].into(),
        why: merger.refused(index).map_or_else(|| "no cloud came".into(), ToString::to_string),
    };
    let cameras = merges.watched.iter().enumerate().map(|(index, watched)| {
        watched.report(merger.counts(index).lost).ok_or_else(|| nothing(index))
    });
    Ok(Seen {
        settled_s: times.settle.as_secs_f64(),
        merged_s: times.merge.as_secs_f64(),
        merges: merges.all.iter().map(merges::Merged::report).collect(),
        cameras: cameras.collect::<Result<_, _>>()?,
        refinement: merges.refinement(),
    })
}

/// A line for whoever started it; one that went away does not matter.
fn tell(event: &Event) {
    let mut out = io::stdout();
    let _ = writeln!(out, "{}", event.to_line()).and_then(|()| out.flush());
}
