//! A consumer in a process of its own: `lodestone echo --json`.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::spawn;

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use super::{TestDomain, eventually, lodestone};

/// What a consumer has said so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Poses printed.
    pub poses: u64,
    /// Sequence number of the first pose of the daemon's present run.
    pub first_sequence: Option<u64>,
    /// Sequence number of the latest pose.
    pub last_sequence: Option<u64>,
    /// Poses of the daemon's present run.
    pub poses_of_run: u64,
    /// Runs of the daemon after the first one, by sequence numbers that begin anew.
    pub runs_after_first: u64,
    /// The latest pose.
    pub latest: Value,
}

impl Tally {
    fn add(&mut self, pose: Value) {
        let sequence = pose["sequence"].as_u64().expect("a pose has a number");
        self.poses += 1;
        if self.last_sequence.is_some_and(|last| sequence <= last) {
            self.runs_after_first += 1;
            self.poses_of_run = 0;
        }
        if self.poses_of_run == 0 {
            self.first_sequence = Some(sequence);
        }
        self.poses_of_run += 1;
        self.last_sequence = Some(sequence);
        self.latest = pose;
    }

    /// Poses of the present run that did not come.
    pub fn missing(&self) -> u64 {
        match (self.first_sequence, self.last_sequence) {
            (Some(first), Some(last)) => last - first + 1 - self.poses_of_run,
            _ => 0,
        }
    }
}

/// Follows one camera; ends with this value if not before.
#[derive(Debug)]
pub struct Follower {
    child: Child,
    tally: Arc<Mutex<Tally>>,
    complaints: Arc<Mutex<String>>,
}

impl Follower {
    /// Starts to follow a camera, which must exist.
    pub fn start(domain: &TestDomain, camera: &str) -> Self {
        let mut child = lodestone()
            .args(["echo", "--json", "--wait", "30", "--camera", camera])
            .args(["--prefix", &domain.prefix, "--root", &domain.root])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts");
        let tally = Arc::new(Mutex::new(Tally::default()));
        let complaints = Arc::new(Mutex::new(String::new()));
        read_poses(child.stdout.take().expect("a pipe"), Arc::clone(&tally));
        read_complaints(child.stderr.take().expect("a pipe"), Arc::clone(&complaints));
        Self { child, tally, complaints }
    }

    /// What it has said so far.
    pub fn tally(&self) -> Tally {
        self.tally.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// What it has complained of so far: lost poses, restarts.
    pub fn complaints(&self) -> String {
        self.complaints.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Poses lost, by its own account.
    pub fn told_lost(&self) -> u64 {
        let complaints = self.complaints();
        let told = complaints.lines().filter_map(|line| line.split_once(" poses lost"));
        told.filter_map(|(before, _)| before.rsplit(' ').next()?.parse::<u64>().ok()).sum()
    }

    /// Waits for so many more poses.
    pub fn await_more(&self, poses: u64) {
        let before = self.tally().poses;
        eventually("the consumer gets poses", || {
            (self.tally().poses >= before + poses).then_some(())
        });
    }

    /// Waits until the latest pose was published after so many others.
    pub fn await_sequence(&self, sequence: u64) {
        eventually("the consumer gets the latest poses", || {
            self.tally().last_sequence.is_some_and(|last| last >= sequence).then_some(())
        });
    }

    /// Sends a signal.
    pub fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).expect("it runs");
    }

    /// kill -9.
    pub fn kill(mut self) {
        self.child.kill().expect("it runs");
        self.child.wait().expect("it is gone");
    }

    /// Asks it to end, and waits: its exit code.
    pub fn stop(mut self) -> Option<i32> {
        self.signal(Signal::INT);
        self.child.wait().expect("it ends").code()
    }
}

fn read_poses(output: impl Read + Send + 'static, tally: Arc<Mutex<Tally>>) {
    spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            // The last line of a killed process may be cut.
            let Ok(pose) = serde_json::from_str(&line) else { continue };
            tally.lock().unwrap_or_else(PoisonError::into_inner).add(pose);
        }
    });
}

fn read_complaints(output: impl Read + Send + 'static, complaints: Arc<Mutex<String>>) {
    spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            let mut complaints = complaints.lock().unwrap_or_else(PoisonError::into_inner);
            complaints.push_str(&line);
            complaints.push('\n');
        }
    });
}

impl Drop for Follower {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
