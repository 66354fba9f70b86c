//! This program in a part of its own.

use std::error::Error;
use std::io::Read;
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};

use super::told::Told;
use crate::domain::OwnDomain;

/// A process; killed if it is dropped before its end.
pub struct Part {
    child: Child,
    role: String,
}

/// How a part measures.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Seconds until it counts.
    pub settle_s: f64,
    /// Seconds that count.
    pub measure_s: f64,
    /// With real-time priority, where that is allowed.
    pub real_time: bool,
}

/// Seconds by which peers' publishers outlive consumers.
const SPARE_S: f64 = 1.0;

impl Conditions {
    /// For who publishes to those who measure under these.
    #[must_use]
    pub const fn longer(self) -> Self {
        Self { measure_s: self.measure_s + SPARE_S, ..self }
    }
}

impl Part {
    /// Starts a role with its arguments.
    ///
    /// # Errors
    /// If the process cannot be started.
    pub fn start(arguments: &[&str]) -> Result<Self, Box<dyn Error>> {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped());
        Ok(Self { child: command.spawn()?, role: arguments.join(" ") })
    }

    /// Starts a role that watches a domain.
    ///
    /// # Errors
    /// As [`Part::start`].
    pub fn watch(
        role: &[&str],
        own: &OwnDomain,
        conditions: Conditions,
    ) -> Result<Self, Box<dyn Error>> {
        let (settle, measure) = (conditions.settle_s.to_string(), conditions.measure_s.to_string());
        let domain = own.domain();
        let place = [domain.prefix.as_str(), &domain.root, &settle, &measure];
        let ordinary: &[&str] = if conditions.real_time { &[] } else { &["--ordinary"] };
        Self::start(&[ordinary, role, &place].concat())
    }

    /// The process's number.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// What it told, once it has ended.
    ///
    /// # Errors
    /// If it failed, or told nothing that can be read.
    pub fn finish(mut self) -> Result<Told, Box<dyn Error>> {
        let mut text = String::new();
        if let Some(output) = &mut self.child.stdout {
            output.read_to_string(&mut text)?;
        }
        self.expect_success()?;
        let told = serde_json::from_str(text.lines().next_back().unwrap_or_default());
        told.map_err(|e| format!("{}: it told nothing: {e}", self.role).into())
    }

    /// Asks it to stop, and waits until it has.
    ///
    /// # Errors
    /// If it failed.
    pub fn stop(&mut self) -> Result<(), Box<dyn Error>> {
        kill_process(Pid::from_child(&self.child), Signal::TERM)?;
        self.expect_success()
    }

    /// Waits for its end.
    ///
    /// # Errors
    /// If it failed.
    pub fn expect_success(&mut self) -> Result<(), Box<dyn Error>> {
        let status = self.child.wait()?;
        if status.success() { Ok(()) } else { Err(format!("{}: {status}", self.role).into()) }
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        // One that has ended already is left in peace.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
