//! What whoever turns the camera sees: how far it has come, and what is missing.

use std::io::Stdout;
use std::time::Duration;

use lodestone_calibration::Progress;
use rustix::termios::isatty;

use crate::console::{Screen, terminal_size};
use crate::logging::LogLines;

/// Between two lines in a log, s.
const LOG_EVERY_S: u64 = 5;
/// Width of the bar, characters.
const BAR: usize = 40;

/// A block redrawn in a terminal, or lines in the log.
pub enum Guidance {
    /// Redrawn in place, log lines above it.
    Block(Screen<Stdout>, LogLines, String),
    /// A line now and then; the second is when the last one was written, s.
    Log(String, Option<u64>),
}

impl Guidance {
    /// The block if standard output is a terminal that can move its cursor and is not `taken`,
    /// else the log.
    pub fn choose(taken: bool) -> Self {
        let dumb = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
        if !taken && !dumb && isatty(rustix::stdio::stdout()) {
            Self::Block(Screen::new(std::io::stdout()), LogLines::default(), String::new())
        } else {
            Self::Log(String::new(), None)
        }
    }

    /// Where log lines must go so that they do not break the block.
    pub fn log_lines(&self) -> Option<&LogLines> {
        match self {
            Self::Block(_, lines, _) if isatty(rustix::stdio::stderr()) => Some(lines),
            _ => None,
        }
    }

    /// Says what is calibrated.
    pub(super) fn begin(&mut self, serial: u64, source: &str) {
        let text = format!("camera {serial}, {source}");
        tracing::info!("calibrating {text}: turn it through the circle, tilting it to every side");
        match self {
            Self::Block(_, _, title) | Self::Log(title, _) => *title = text,
        }
    }

    /// Shows the progress.
    pub(super) fn show(&mut self, progress: &Progress, elapsed: Duration) {
        match self {
            Self::Block(screen, lines, title) => {
                screen.draw(&lines.take(), &block(title, progress), terminal_size());
            }
            Self::Log(title, last_s) => {
                let now_s = elapsed.as_secs();
                if last_s.is_none_or(|last| now_s >= last + LOG_EVERY_S) {
                    *last_s = Some(now_s);
                    tracing::info!("{title}: {}; {}", figures(progress), still_missing(progress));
                }
            }
        }
    }

    /// Leaves the block where it is.
    pub(super) fn finish(&mut self) {
        if let Self::Block(screen, lines, _) = self {
            screen.finish(&lines.take());
        }
    }
}

/// The lines of the block.
fn block(title: &str, progress: &Progress) -> Vec<String> {
    let full = (progress.ratio.clamp(0.0, 1.0) * BAR as f64) as usize;
    let bar = format!("{}{}", "#".repeat(full), ".".repeat(BAR - full));
    vec![
        format!("{title}; ctrl-c ends with what is there"),
        format!("[{bar}] {:.0} %", 100.0 * progress.ratio),
        figures(progress),
        still_missing(progress),
    ]
}

fn figures(progress: &Progress) -> String {
    let c = &progress.coverage;
    let sigma = progress.heading_sigma_deg;
    let sigma = sigma.map_or("unknown".into(), |sigma| format!("{sigma:.2}°"));
    format!(
        "{:.0} s, {:.0}° of the circle, {:.1} turns, tilt {:.1}°; expected heading σ {sigma}",
        c.duration_s, c.circle_deg, c.turns, c.tilt_deg
    )
}

fn still_missing(progress: &Progress) -> String {
    if progress.is_complete() {
        return "complete".into();
    }
    if progress.missing.is_empty() {
        return "good enough to be used; go on to make it better".into();
    }
    let missing: Vec<_> = progress.missing.iter().map(ToString::to_string).collect();
    missing.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodestone_calibration::{Coverage, Missing};

    fn progress(missing: Vec<Missing>, ratio: f64) -> Progress {
        let coverage = Coverage { duration_s: 20.0, circle_deg: 140.0, ..Coverage::default() };
        Progress { coverage, heading_sigma_deg: None, missing, ratio }
    }

    #[test]
    fn the_block_says_how_far_and_what_is_missing() {
        let missing = Missing::Circle { seen_deg: 140.0, needed_deg: 300.0 };
        let lines = block("camera 7", &progress(vec![missing], 0.25));
        assert_eq!(lines[1], format!("[{}{}] 25 %", "#".repeat(10), ".".repeat(30)));
        assert!(lines[2].contains("140° of the circle") && lines[2].contains("σ unknown"));
        assert_eq!(lines[3], "turn through a whole circle: only 140° seen, 300° needed");
    }

    #[test]
    fn between_good_enough_and_complete_it_says_so() {
        assert!(block("camera 7", &progress(Vec::new(), 0.6))[3].starts_with("good enough"));
        assert_eq!(block("camera 7", &progress(Vec::new(), 1.0))[3], "complete");
    }
}
