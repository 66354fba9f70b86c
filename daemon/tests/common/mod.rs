//! What the daemon's integration tests share.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part")]

use std::process::{Command, Output};

use lodestone_config::model::SharedMemory;
use lodestone_schema::transport::Domain;
use lodestone_schema::{CalibratedSample, Pose};

const CHILD: &str = "LODESTONE_TEST_CHILD";

/// Runs a test's body in a process of its own: a process can enter one domain only.
pub fn in_child(test: &str, body: impl FnOnce()) {
    if is_child(test) {
        return body();
    }
    let output = child(test).output().expect("start this test binary again");
    assert!(output.status.success(), "{}", said(&output));
}

/// Whether this process was started to play a part: by [`child`] and its kin.
pub fn is_child(part: &str) -> bool {
    std::env::var_os(CHILD).is_some_and(|name| name == part)
}

/// This test binary again, to run the body of one test.
pub fn child(test: &str) -> Command {
    let mut command = Command::new(std::env::current_exe().expect("own path"));
    command.args(["--exact", test, "--nocapture"]).env(CHILD, test);
    command
}

/// Like [`child`], with a tmpfs of the given size of its own on `/dev/shm`; `None`, with a line
/// that says so, where this user may not make one.
pub fn child_on_small_shm(test: &str, size_bytes: u64) -> Option<Command> {
    let mut command = on_small_shm(size_bytes)?;
    command.arg(std::env::current_exe().expect("own path"));
    command.args(["--exact", test, "--nocapture"]).env(CHILD, test);
    Some(command)
}

/// A command, to be completed by a program and its arguments, that runs with a tmpfs of the given
/// size of its own on `/dev/shm`.
pub fn on_small_shm(size_bytes: u64) -> Option<Command> {
    let script = format!(
        "mount -t tmpfs -o size={size_bytes},mode=1777 tmpfs /dev/shm && exec \"$0\" \"$@\""
    );
    let with = |namespaces: &'static [&'static str]| {
        let mut command = Command::new("unshare");
        command.args(namespaces).args(["sh", "-c", &script]);
        command
    };
    for namespaces in [&["--mount"][..], &["--user", "--map-root-user", "--mount"][..]] {
        if with(namespaces).arg("true").output().is_ok_and(|o| o.status.success()) {
            return Some(with(namespaces));
        }
    }
    println!("skipped: no right to mount a tmpfs of its own on /dev/shm (unshare, mount)");
    None
}

/// What a child wrote.
pub fn said(output: &Output) -> String {
    format!(
        "{}\n{}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// A domain that no other test uses, and the guard that ends it.
pub fn own_domain(test: &str) -> (Domain, DomainGuard) {
    let root = tempfile::tempdir().expect("temporary directory");
    let prefix = format!("t{}_{test}_", std::process::id());
    let domain = Domain { prefix: prefix.clone(), root: format!("{}/", root.path().display()) };
    (domain, DomainGuard { prefix, _root: root })
}

/// Removes what a domain leaves: its root, and a file of iceoryx2's that outlives every node.
#[derive(Debug)]
pub struct DomainGuard {
    prefix: String,
    _root: tempfile::TempDir,
}

impl Drop for DomainGuard {
    fn drop(&mut self) {
        for name in shared_memory_files(&self.prefix) {
            let _ = std::fs::remove_file(format!("/dev/shm/{name}"));
        }
    }
}

/// The files of a prefix on `/dev/shm`.
pub fn shared_memory_files(prefix: &str) -> Vec<String> {
    let entries = std::fs::read_dir("/dev/shm").expect("shared memory").flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(prefix)).collect()
}

/// Small settings, for quick tests.
pub fn small() -> SharedMemory {
    SharedMemory { pose_history: 16, max_subscribers: 3, ..SharedMemory::default() }
}

/// A pose with a number.
pub fn pose(sequence: u64) -> Pose {
    Pose {
        sequence,
        camera_id: 0,
        reset_counter: 0,
        status: 1,
        validity: 1,
        heading_source: 1,
        position_source: 1,
        aids_used: 0,
        aids_refused: 0,
        world_epoch: 1,
        sensor_time_ns: 1,
        time_ns: 1,
        arrival_time_ns: 1,
        ring_time_ns: 1,
        step_start_time_ns: 1,
        step_end_time_ns: 1,
        published_time_ns: 0,
        unix_offset_ns: 0,
        position_m: [sequence as f64; 3],
        velocity_m_s: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        angular_rate_rad_s: [0.0; 3],
        specific_force_m_s2: [0.0, 0.0, 9.81],
        position_covariance_m2: [1.0; 6],
        velocity_covariance_m2_s2: [1.0; 6],
        orientation_covariance_rad2: [1.0; 6],
    }
}

/// A sample with a number.
pub fn sample(sequence: u64) -> CalibratedSample {
    CalibratedSample {
        sequence,
        camera_id: 0,
        flags: 0,
        sensor_time_ns: 1,
        time_ns: 1,
        arrival_time_ns: 1,
        angular_rate_rad_s: [0.0; 3],
        specific_force_m_s2: [0.0, 0.0, 9.81],
        magnetic_field_ut: [f64::NAN; 3],
        temperature_c: 30.0,
    }
}

/// Bytes that the files of a prefix take on `/dev/shm`.
pub fn shared_memory_taken(prefix: &str) -> u64 {
    use std::os::unix::fs::MetadataExt;
    let files = shared_memory_files(prefix).into_iter();
    files
        .filter_map(|name| std::fs::metadata(format!("/dev/shm/{name}")).ok())
        .map(|file| file.blocks() * 512)
        .sum()
}
