//! The demo's processes: started, watched, ended, with their logs.

use std::fs::{self, File};
use std::io;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, getpid, kill_process};

/// How long a process may take to end after SIGTERM.
const PATIENCE: Duration = Duration::from_secs(5);
/// Between two looks at a process that is to end.
const LOOK: Duration = Duration::from_millis(20);
/// Last lines of a log that are shown when its process fails.
const SHOWN_LINES: usize = 6;

/// Why a process is not there.
#[derive(Debug, thiserror::Error)]
pub enum ChildError {
    /// It cannot be started.
    #[error("cannot start {name}: {source}")]
    Start {
        /// The process.
        name: String,
        /// What the system says.
        source: io::Error,
    },
    /// It ended although it was to run.
    #[error("{name} ended ({status}); the end of {}:\n{tail}", log.display())]
    Ended {
        /// The process.
        name: String,
        /// How.
        status: ExitStatus,
        /// Its log.
        log: PathBuf,
        /// The last lines of it.
        tail: String,
    },
}

/// A process that ends with this value at the latest.
#[derive(Debug)]
struct Running {
    name: String,
    process: Child,
    log: PathBuf,
}

/// Processes of one demo; they end in reverse order, whatever becomes of the demo.
#[derive(Debug)]
pub struct Children {
    program: PathBuf,
    logs: PathBuf,
    variables: Vec<(&'static str, String)>,
    running: Vec<Running>,
}

impl Children {
    /// None yet. They will run this program, log into a directory, and find variables in their environment.
    ///
    /// # Errors
    /// If the program does not know its own path.
    pub fn new(logs: &Path, variables: Vec<(&'static str, String)>) -> io::Result<Self> {
        let program = std::env::current_exe()?;
        Ok(Self { program, logs: logs.into(), variables, running: Vec::new() })
    }

    /// Starts a process that logs into `NAME.log`.
    ///
    /// # Errors
    /// [`ChildError::Start`].
    pub fn start(&mut self, name: &str, arguments: &[&str]) -> Result<(), ChildError> {
        let log = self.logs.join(format!("{name}.log"));
        let start = |file: File| {
            let errors = file.try_clone()?;
            self.command(arguments).stdout(file).stderr(errors).spawn()
        };
        self.keep(name, log.clone(), File::create(log).and_then(start)).map(|_| ())
    }

    /// The same with its standard output for the caller.
    ///
    /// # Errors
    /// [`ChildError::Start`].
    pub fn start_piped(
        &mut self,
        name: &str,
        arguments: &[&str],
    ) -> Result<Option<ChildStdout>, ChildError> {
        let log = self.logs.join(format!("{name}.log"));
        let start =
            |file: File| self.command(arguments).stdout(Stdio::piped()).stderr(file).spawn();
        let child = self.keep(name, log.clone(), File::create(log).and_then(start))?;
        Ok(child.process.stdout.take())
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        // A ctrl-c is for the demo, which ends them in the right order; and they end with it if it is killed.
        command.process_group(0).stdin(Stdio::null());
        command.arg("--with-parent").arg(getpid().as_raw_nonzero().to_string()).args(arguments);
        command.envs(self.variables.iter().map(|(name, value)| (name, value)));
        command
    }

    fn keep(
        &mut self,
        name: &str,
        log: PathBuf,
        started: io::Result<Child>,
    ) -> Result<&mut Running, ChildError> {
        let process = started.map_err(|source| ChildError::Start { name: name.into(), source })?;
        self.running.push(Running { name: name.into(), process, log });
        let last = self.running.len() - 1;
        Ok(&mut self.running[last])
    }

    /// Looks whether all still run but the last one, which may have ended well: then `true`.
    ///
    /// # Errors
    /// [`ChildError::Ended`] for the first that has not.
    pub fn look(&mut self) -> Result<bool, ChildError> {
        let last = self.running.len().saturating_sub(1);
        for (index, running) in self.running.iter_mut().enumerate() {
            // A process that cannot be asked is not this one's child; it was never waited for.
            let Ok(Some(status)) = running.process.try_wait() else { continue };
            if index == last && status.success() {
                return Ok(true);
            }
            return Err(running.ended(status));
        }
        Ok(false)
    }

    /// Ends them all, the last started first.
    pub fn end(&mut self) {
        while let Some(mut running) = self.running.pop() {
            running.end();
        }
    }
}

impl Drop for Children {
    fn drop(&mut self) {
        self.end();
    }
}

impl Running {
    fn ended(&self, status: ExitStatus) -> ChildError {
        let text = fs::read(&self.log).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let lines: Vec<&str> = text.lines().collect();
        let tail = lines[lines.len().saturating_sub(SHOWN_LINES)..].join("\n");
        ChildError::Ended { name: self.name.clone(), status, log: self.log.clone(), tail }
    }

    /// Asks it to end, and makes it end if it does not.
    fn end(&mut self) {
        let begin = Instant::now();
        // Only of one that has not been waited for the number is still its own.
        if !matches!(self.process.try_wait(), Ok(None)) {
            return;
        }
        let _ = kill_process(Pid::from_child(&self.process), Signal::TERM);
        while begin.elapsed() < PATIENCE {
            match self.process.try_wait() {
                Ok(None) => thread::sleep(LOOK),
                _ => return,
            }
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
