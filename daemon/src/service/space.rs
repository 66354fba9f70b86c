//! Is there enough shared memory? Asked before anything is made.
//!
//! Writing to a page that a full `/dev/shm` cannot give is SIGBUS, so the daemon first reserves,
//! in a file that it removes again, all the bytes it and its most consumers will need.

use std::fs::{OpenOptions, remove_file};
use std::io;
use std::path::Path;

use lodestone_config::model::{Config, DriverKind, SharedMemory};
use lodestone_schema::ServiceKind;
use rustix::fs::{FallocateFlags, fallocate, statvfs};
use rustix::io::Errno;
use tracing::warn;

use super::prefault::SHARED_MEMORY_DIRECTORY;
use crate::publisher::{qos_of, sample_bytes};

const PAGE: u64 = 4096;

// What iceoryx2 0.10 adds, fitted to the files it makes (histories of 16 and 512, 3 and 16
// subscribers) and rounded up; a test compares the sum with what a lane really takes.
/// Header, index and padding of one sample.
const SAMPLE_OVERHEAD: u64 = 56;
/// Management of one data segment.
const SEGMENT_OVERHEAD: u64 = 1024;
/// One entry of a connection's two queues.
const QUEUE_ENTRY: u64 = 16;
/// Management of one connection.
const CONNECTION_OVERHEAD: u64 = 512;
/// A service's list of ports and nodes: what is fixed, and what each consumer adds.
const PORT_LIST: u64 = 1024;
const PORT_LIST_PER_CONSUMER: u64 = 256;
/// Node, event service and directory entries of one camera, and of its consumers.
const NODES_PER_CAMERA: u64 = 16 * PAGE;

/// Why the daemon will not start.
#[derive(Debug, thiserror::Error)]
pub enum SpaceError {
    /// Too little is free.
    #[error(
        "needs {} MiB in {directory}, {} MiB free: free some, mount it larger, or lower shared_memory.pose_history or max_subscribers",
        mebibytes_up(*.needed),
        mebibytes_down(*.free)
    )]
    TooLittle {
        /// The directory.
        directory: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes free.
        free: u64,
    },
    /// The directory cannot be used at all.
    #[error("cannot reserve memory in {directory}: {source}")]
    Io {
        /// The directory.
        directory: String,
        /// What the system says.
        source: io::Error,
    },
}

/// Tenths of a MiB, so that neither a need nor what is free reads as 0 when it is not; a need is
/// rounded up and what is free down, so that the two differ as printed.
fn mebibytes_up(bytes: u64) -> f64 {
    (bytes as f64 / f64::from(1 << 20) * 10.0).ceil() / 10.0
}

fn mebibytes_down(bytes: u64) -> f64 {
    (bytes as f64 / f64::from(1 << 20) * 10.0).floor() / 10.0
}

/// Bytes of shared memory that the daemon takes with this configuration when every camera has its
/// most consumers.
pub fn needed_bytes(config: &Config) -> u64 {
    let cameras: u64 = config.camera.iter().map(|camera| camera_bytes(config, camera.driver)).sum();
    let published = [ServiceKind::World, ServiceKind::Relative, ServiceKind::Transforms];
    // A rig's body is published as a camera is, but for samples.
    let bodies = config.rigs().len() as u64 * camera_bytes(config, DriverKind::Zed2);
    cameras
        + bodies
        + published.map(|kind| service_bytes(kind, &config.shared_memory)).iter().sum::<u64>()
}

fn camera_bytes(config: &Config, driver: DriverKind) -> u64 {
    let settings = &config.shared_memory;
    let published = |kind: &ServiceKind| match kind {
        ServiceKind::Sample => settings.publish_samples,
        ServiceKind::Truth => driver == DriverKind::Synthetic,
        ServiceKind::Pose | ServiceKind::Health => true,
        _ => false,
    };
    let services = ServiceKind::OF_LANE.iter().filter(|kind| published(kind));
    NODES_PER_CAMERA + services.map(|&kind| service_bytes(kind, settings)).sum::<u64>()
}

fn service_bytes(kind: ServiceKind, settings: &SharedMemory) -> u64 {
    let qos = qos_of(kind, settings);
    let (history, consumers) = (qos.history as u64, qos.max_subscribers as u64);
    // As schema's transport asks for: a consumer's buffer takes the whole history.
    let in_flight = history.max(2) + qos.max_borrowed as u64;
    // iceoryx2's static_config/publish_subscribe.rs, with one sample loaned.
    let samples = consumers.saturating_mul(in_flight).saturating_add(history + 1);
    let sample = sample_bytes(kind) as u64 + SAMPLE_OVERHEAD;
    let segment = samples.saturating_mul(sample).saturating_add(SEGMENT_OVERHEAD);
    let connection = samples.saturating_add(in_flight * QUEUE_ENTRY + CONNECTION_OVERHEAD);
    let ports = PORT_LIST + consumers.saturating_mul(PORT_LIST_PER_CONSUMER);
    whole_pages(segment)
        .saturating_add(consumers.saturating_mul(whole_pages(connection)))
        .saturating_add(whole_pages(ports))
}

const fn whole_pages(bytes: u64) -> u64 {
    bytes.div_ceil(PAGE).saturating_mul(PAGE)
}

/// Makes sure that `/dev/shm` can give `needed` bytes now.
///
/// # Errors
/// [`SpaceError`] says how much is needed and how much is free.
pub fn ensure(needed: u64, prefix: &str) -> Result<(), SpaceError> {
    ensure_in(Path::new(SHARED_MEMORY_DIRECTORY), needed, prefix)
}

fn ensure_in(directory: &Path, needed: u64, prefix: &str) -> Result<(), SpaceError> {
    let failed = |source| SpaceError::Io { directory: directory.display().to_string(), source };
    match reserve_once(directory, needed, prefix) {
        Ok(()) => Ok(()),
        Err(e) if is_full(&e) => Err(SpaceError::TooLittle {
            directory: directory.display().to_string(),
            needed,
            free: free_bytes(directory).map_err(failed)?,
        }),
        Err(e) => Err(failed(e)),
    }
}

/// Really reserves, as a quota or a control group may allow less than the file system has.
fn reserve_once(directory: &Path, needed: u64, prefix: &str) -> io::Result<()> {
    let path = directory.join(format!("{prefix}probe.{}", std::process::id()));
    let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
    // Unlinked first: whatever ends this process now leaves nothing behind.
    remove_file(&path)?;
    fallocate(&file, FallocateFlags::empty(), 0, needed.max(1))?;
    Ok(())
}

fn is_full(error: &io::Error) -> bool {
    [Errno::NOSPC, Errno::DQUOT, Errno::FBIG]
        .iter()
        .any(|full| error.raw_os_error() == Some(full.raw_os_error()))
}

/// Less than this is short: the files of a joining consumer take some pages, and iceoryx2 writes
/// them without reserving.
const SHORT: u64 = 1 << 20;

/// Tells, once for each time it happens, that shared memory ran short under the running daemon.
#[derive(Debug, Default)]
pub struct SpaceWatch {
    short: bool,
}

impl SpaceWatch {
    /// Looks; a system call, for housekeeping only.
    pub fn look(&mut self) {
        let Ok(free) = free_bytes(Path::new(SHARED_MEMORY_DIRECTORY)) else { return };
        if self.turns_short(free) {
            let mebibytes = mebibytes_down(free);
            warn!(
                "{SHARED_MEMORY_DIRECTORY} has only {mebibytes} MiB free: poses go on, but a consumer that joins when it is full ends this daemon and itself (SIGBUS)"
            );
        }
    }

    fn turns_short(&mut self, free: u64) -> bool {
        let was = std::mem::replace(&mut self.short, free < SHORT);
        self.short && !was
    }
}

/// Bytes an unprivileged process may still take.
fn free_bytes(directory: &Path) -> io::Result<u64> {
    let fs = statvfs(directory)?;
    Ok(fs.f_bavail.saturating_mul(fs.f_frsize))
}

#[cfg(test)]
mod tests {
    use lodestone_config::model::Camera;

    use super::*;

    fn with_cameras(count: usize) -> Config {
        Config { camera: vec![Camera::default(); count], ..Config::default() }
    }

    #[test]
    fn every_camera_needs_the_same_and_more_consumers_need_more() {
        let one = needed_bytes(&with_cameras(1));
        let shared = needed_bytes(&with_cameras(0));
        assert_eq!(needed_bytes(&with_cameras(3)) - shared, 3 * (one - shared));
        let mut more = with_cameras(1);
        more.shared_memory.max_subscribers *= 2;
        assert!(needed_bytes(&more) > one);
        assert!(shared > 0 && shared < one, "{shared} of {one}");
    }

    #[test]
    fn a_need_beyond_any_memory_is_refused_and_leaves_no_file() {
        let directory = tempfile::tempdir().unwrap();
        let error = ensure_in(directory.path(), 1 << 55, "t_").unwrap_err();
        assert!(matches!(error, SpaceError::TooLittle { .. }), "{error:?}");
        assert!(error.to_string().contains("MiB free"), "{error}");
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_need_that_can_be_met_leaves_no_file() {
        let directory = tempfile::tempdir().unwrap();
        ensure_in(directory.path(), 1 << 16, "t_").unwrap();
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
    }

    #[test]
    fn running_short_is_told_once_each_time() {
        let mut watch = SpaceWatch::default();
        let told: Vec<_> = [SHORT, SHORT - 1, 0, SHORT, SHORT - 1]
            .into_iter()
            .map(|free| watch.turns_short(free))
            .collect();
        assert_eq!(told, [false, true, false, false, true]);
    }

    #[test]
    fn a_directory_that_is_missing_is_named() {
        let error = ensure_in(Path::new("/nowhere/at/all"), 1, "t_").unwrap_err();
        assert!(error.to_string().contains("/nowhere/at/all"), "{error}");
    }
}
