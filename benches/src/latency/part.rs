//! This program in a part of its own.

use std::error::Error;
use std::io::Read;
use std::process::{Child, Command, Stdio};

use super::told::Told;
use crate::domain::OwnDomain;

/// A process; killed if it is dropped before its end.
pub struct Part {
    child: Child,
    role: String,
}

/// When a part's measurement begins, and how long it takes, s.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Until it counts.
    pub settle_s: f64,
    /// While it counts.
    pub measure_s: f64,
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
    pub fn watch(role: &[&str], own: &OwnDomain, timing: Timing) -> Result<Self, Box<dyn Error>> {
        let (settle, measure) = (timing.settle_s.to_string(), timing.measure_s.to_string());
        let domain = own.domain();
        let place = [domain.prefix.as_str(), &domain.root, &settle, &measure];
        Self::start(&[role, &place].concat())
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
