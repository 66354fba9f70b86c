//! A daemon that serves.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{JoinHandle, spawn};

use rustix::process::{Pid, Signal, kill_process};

use super::{eventually, lodestoned};

/// `lodestoned run` as a process; it ends with this value if not before.
#[derive(Debug)]
pub struct Daemon {
    child: Child,
    log: Arc<Mutex<String>>,
    listener: Option<JoinHandle<()>>,
}

impl Daemon {
    /// Starts one and waits until it serves all its cameras.
    pub fn start(configuration: &Path) -> Self {
        Self::start_by(lodestoned(), configuration)
    }

    /// The same by a command that ends with the program, such as [`super::without_rights`].
    pub fn start_by(program: Command, configuration: &Path) -> Self {
        let mut daemon = Self::spawn_by(program, configuration);
        eventually("the daemon serves", || {
            let ended = daemon.child.try_wait().expect("can be asked");
            assert!(ended.is_none(), "ended instead of serving: {}", daemon.log());
            daemon.log().contains("serving ").then_some(())
        });
        daemon
    }

    /// Starts one and waits for nothing: its cameras begin one after the other.
    pub fn spawn(configuration: &Path) -> Self {
        Self::spawn_by(lodestoned(), configuration)
    }

    fn spawn_by(mut program: Command, configuration: &Path) -> Self {
        let mut child = program
            .args(["run", "--config"])
            .arg(configuration)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts");
        let log = Arc::new(Mutex::new(String::new()));
        let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
        let heard = Arc::clone(&log);
        let listener = spawn(move || {
            for line in lines.map_while(Result::ok) {
                let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
                heard.push_str(&line);
                heard.push('\n');
            }
        });
        Self { child, log, listener: Some(listener) }
    }

    /// Its process id.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// What it has logged so far.
    pub fn log(&self) -> String {
        self.log.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).expect("it runs");
    }

    /// kill -9.
    pub fn kill(self) {
        self.signal(Signal::KILL);
        assert_eq!(self.ended().0, None);
    }

    /// Waits for its end: exit code, if it ended by itself, and the whole log.
    pub fn ended(mut self) -> (Option<i32>, String) {
        let status = eventually("the daemon ends", || self.child.try_wait().expect("can be asked"));
        if let Some(listener) = self.listener.take() {
            listener.join().expect("the listener does not panic");
        }
        let log = self.log();
        assert!(!log.contains("panicked"), "{log}");
        (status.code(), log)
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
