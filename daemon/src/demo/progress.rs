//! What a person sees while the demo runs: a line that is redrawn in a terminal, else a line for each phase.

use std::io::{self, Write};
use std::time::{Duration, Instant};

use rustix::termios::isatty;

/// Width of the bar, characters.
const BAR: usize = 30;
/// Between two redraws.
const REDRAW: Duration = Duration::from_millis(100);

/// Progress on standard error.
#[derive(Debug)]
pub struct Progress {
    redraws: bool,
    phase: String,
    drawn: Option<Instant>,
}

impl Progress {
    /// Redraws if standard error is a terminal that can.
    pub fn choose() -> Self {
        let dumb = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
        Self::new(isatty(rustix::stdio::stderr()) && !dumb)
    }

    const fn new(redraws: bool) -> Self {
        Self { redraws, phase: String::new(), drawn: None }
    }

    /// A new phase begins.
    pub fn phase(&mut self, phase: &str) {
        if self.phase == phase {
            return;
        }
        phase.clone_into(&mut self.phase);
        self.drawn = None;
        say(&if self.redraws { redrawn(phase) } else { format!("{phase}\n") });
    }

    /// How far the phase has come, 0 to 1, and a figure beside the bar.
    pub fn share(&mut self, share: f64, figure: &str) {
        let is_due = self.drawn.is_none_or(|drawn| drawn.elapsed() >= REDRAW || share >= 1.0);
        if self.redraws && is_due {
            self.drawn = Some(Instant::now());
            say(&redrawn(&format!("{}  {}  {figure}", self.phase, bar(share))));
        }
    }

    /// Leaves an empty line to go on from.
    pub fn finish(&mut self) {
        if self.redraws && !self.phase.is_empty() {
            say("\r\x1b[2K");
        }
        self.phase.clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

fn redrawn(line: &str) -> String {
    format!("\r\x1b[2K{line}")
}

fn bar(share: f64) -> String {
    let full = (share.clamp(0.0, 1.0) * BAR as f64).round() as usize;
    let percent = 100.0 * share.clamp(0.0, 1.0);
    format!("[{}{}] {percent:3.0} %", "#".repeat(full), ".".repeat(BAR - full))
}

/// A closed standard error changes nothing.
fn say(text: &str) {
    let mut out = io::stderr();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_fills() {
        assert_eq!(bar(0.0), format!("[{}]   0 %", ".".repeat(BAR)));
        assert_eq!(bar(0.5), format!("[{}{}]  50 %", "#".repeat(15), ".".repeat(15)));
        assert_eq!(bar(7.0), format!("[{}] 100 %", "#".repeat(BAR)));
    }
}
