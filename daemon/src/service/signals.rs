//! SIGINT and SIGTERM ask for a clean stop; a second one ends the process at once. SIGUSR1 asks for a
//! new world.
//!
//! SIGPIPE needs nothing here: Rust's runtime ignores it before `main`, so a closed pipe is an
//! error of the write and not the end of the daemon.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

/// A flag that SIGUSR1 raises from now on: define the world anew.
///
/// # Errors
/// What the system says when the handler cannot be installed.
pub fn reset_on_signal() -> io::Result<Arc<AtomicBool>> {
    let raised = Arc::new(AtomicBool::new(false));
    flag::register(SIGUSR1, Arc::clone(&raised))?;
    Ok(raised)
}

/// Asks every part of the daemon to stop; cheap to clone and to look at.
#[derive(Clone, Debug, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// A flag that nobody has raised.
    pub fn new() -> Self {
        Self::default()
    }

    /// Asks to stop.
    pub fn raise(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether somebody asked.
    pub fn is_raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Raises the flag on SIGINT and SIGTERM from now on; the second of either kind ends the
    /// process with exit code 128 + signal, as a shell would report it.
    ///
    /// # Errors
    /// What the system says when the handlers cannot be installed.
    pub fn raise_on_signals(&self) -> io::Result<()> {
        for signal in [SIGINT, SIGTERM] {
            // Order matters: the first signal must find the flag not raised yet.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&self.0))?;
            flag::register(signal, Arc::clone(&self.0))?;
        }
        Ok(())
    }
}
