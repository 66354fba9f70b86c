//! The two programs.

use std::path::PathBuf;
use std::process::{Command, Output};

use super::skipped;

/// `lodestoned`.
pub fn lodestoned() -> Command {
    program("system-lodestoned")
}

/// `lodestone`.
pub fn lodestone() -> Command {
    program("system-lodestone")
}

/// Cargo puts a package's programs one directory above its tests, and builds them first.
fn program(name: &str) -> Command {
    let mut command = Command::new(path(name));
    command.env_remove("RUST_LOG").env_remove("IOX2_LOG_LEVEL");
    command
}

fn path(name: &str) -> PathBuf {
    let own = std::env::current_exe().expect("own path");
    let directory = own.parent().and_then(|deps| deps.parent()).expect("below target");
    directory.join(name)
}

/// A command, to be completed by a program and its arguments, that runs with a tmpfs of the given
/// size of its own on `/dev/shm`; `None`, with a line that says so, where this user may not make
/// one.
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
    skipped("no right to mount a tmpfs of its own on /dev/shm (unshare, mount)");
    None
}

/// A program without the rights to real-time priority and to more than 64 KiB of locked memory, also
/// for root; `None`, with a line that says so, where the tools for it are missing.
pub fn without_rights(program: &Command) -> Option<Command> {
    let stripped = || {
        let mut command = Command::new("setpriv");
        command.args(["--bounding-set=-all", "--inh-caps=-all"]);
        command.args(["prlimit", "--rtprio=0", "--memlock=65536"]);
        command
    };
    if !stripped().arg("true").output().is_ok_and(|o| o.status.success()) {
        skipped("no setpriv or prlimit to run a program without rights");
        return None;
    }
    let mut command = stripped();
    command.arg(program.get_program());
    Some(command)
}

/// What a program that ended wrote, for messages.
pub fn said(output: &Output) -> String {
    format!(
        "{}\n{}\n{}",
        output.status,
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}
