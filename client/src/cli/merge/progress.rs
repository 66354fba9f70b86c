//! What is said while merging, on standard error.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

use lodestone_client::{CloudMerger, MergeCounts};

const INTERVAL: Duration = Duration::from_secs(1);

/// One line a second; in a terminal it replaces the one before.
pub(super) struct Progress {
    begin: Instant,
    duration: Option<Duration>,
    next: Instant,
    is_terminal: bool,
    /// Clouds merged and lost when last shown, for each camera.
    before: Vec<(u64, u64)>,
}

impl Progress {
    pub(super) fn new(begin: Instant, duration: Option<Duration>) -> Self {
        let is_terminal = io::stderr().is_terminal();
        Self { begin, duration, next: begin + INTERVAL, is_terminal, before: Vec::new() }
    }

    pub(super) fn show_if_due(&mut self, merger: &CloudMerger) {
        let now = Instant::now();
        if now < self.next {
            return;
        }
        // One that is late is not made up for.
        self.next = now + INTERVAL;
        let line = self.line(merger);
        // Nobody to read it is no reason to stop.
        let _ = if self.is_terminal {
            write!(io::stderr(), "\r\x1b[K{}", cut(&line))
        } else {
            writeln!(io::stderr(), "lodestone: {line}")
        };
    }

    /// Leaves the last line standing.
    pub(super) fn end(&self) {
        if self.is_terminal {
            let _ = writeln!(io::stderr());
        }
    }

    fn line(&mut self, merger: &CloudMerger) -> String {
        let seconds = self.begin.elapsed().as_secs();
        let mut parts = vec![match self.duration {
            Some(duration) => format!("{seconds} of {} s", duration.as_secs()),
            None => format!("{seconds} s, ctrl-c ends"),
        }];
        self.before.resize(merger.cameras().len(), (0, 0));
        for (index, (camera, before)) in merger.cameras().zip(&mut self.before).enumerate() {
            let counts = merger.counts(index);
            parts.push(since(&camera.camera, counts, *before));
            *before = (counts.clouds, counts.lost);
        }
        parts.push(format!("{} voxels", merger.map().len()));
        parts.join("; ")
    }
}

/// What one camera did since it was last shown.
fn since(camera: &str, counts: MergeCounts, (clouds, lost): (u64, u64)) -> String {
    let new = counts.clouds - clouds;
    let mut parts = vec![format!("{camera} {} clouds (+{new})", counts.clouds)];
    let mut say = |count: u64, what: &str| {
        if count > 0 {
            parts.push(format!("{what} {count}"));
        }
    };
    say(counts.lost - lost, "BEHIND: lost");
    say(counts.without_pose, "without pose");
    parts.join(", ")
}

/// A line that wraps would not be replaced as one.
fn cut(line: &str) -> String {
    let columns = match rustix::termios::tcgetwinsize(io::stderr()) {
        Ok(size) if size.ws_col > 0 => size.ws_col.into(),
        _ => 80,
    };
    line.chars().take(columns).collect()
}
