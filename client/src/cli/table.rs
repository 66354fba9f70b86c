//! The live table.

use std::io::{self, IsTerminal};

use super::json::heading;
use super::report::Report;
use super::status::{count, or_dash};

const TITLES: [&str; 10] = [
    "camera",
    "state",
    "poses/s",
    "p50 ms",
    "p99 ms",
    "heading",
    "position m",
    "± m",
    "lost",
    "dropped",
];

/// The table as lines, columns as wide as their content.
pub(super) fn lines(reports: &[Report]) -> Vec<String> {
    let mut rows = vec![TITLES.map(str::to_owned)];
    rows.extend(reports.iter().map(cells));
    let mut lines = aligned(&rows);
    for report in reports {
        lines.extend(report.problems.iter().map(|p| format!("  ! {}: {p}", report.camera)));
    }
    lines
}

/// A line per camera for logs: one look, no table to keep aligned.
pub(super) fn plain(report: &Report) -> String {
    let cells = cells(report);
    let named = TITLES.iter().zip(&cells).skip(1).map(|(title, cell)| format!("{title} {cell}"));
    let mut line = format!("{}: {}", report.camera, named.collect::<Vec<_>>().join(", "));
    for problem in &report.problems {
        line.push_str("; ");
        line.push_str(problem);
    }
    line
}

fn cells(r: &Report) -> [String; TITLES.len()] {
    let position =
        r.position_m.map_or_else(|| "unknown".into(), |[x, y, z]| format!("{x:.2} {y:.2} {z:.2}"));
    [
        r.camera.clone(),
        r.state.clone(),
        or_dash(r.pose_rate_hz, 1.0, 1),
        or_dash(r.latency_p50_s, 1e3, 3),
        or_dash(r.latency_p99_s, 1e3, 3),
        heading(r.heading_deg, r.heading_sigma_deg),
        position,
        or_dash(r.position_sigma_m, 1.0, 3),
        count(r.samples_lost),
        count(r.ring_dropped),
    ]
}

/// Rows as lines, columns as wide as their content.
pub(super) fn aligned<const N: usize>(rows: &[[String; N]]) -> Vec<String> {
    let width = |column: usize| {
        rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default()
    };
    let widths: [usize; N] = core::array::from_fn(width);
    rows.iter().map(|row| padded(row, &widths)).collect()
}

fn padded<const N: usize>(row: &[String; N], widths: &[usize; N]) -> String {
    let cells = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}"));
    cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
}

/// Lines that replace themselves in a terminal.
#[derive(Debug, Default)]
pub(super) struct Screen {
    drawn: usize,
}

impl Screen {
    /// The screen, if standard output is a terminal.
    pub(super) fn of_terminal() -> Option<Self> {
        io::stdout().is_terminal().then(Self::default)
    }

    /// Escape sequences and text that put these lines where the last ones were.
    ///
    /// Lines are cut to the terminal's size: a wrapped line would be counted as one.
    pub(super) fn replace(&mut self, lines: &[String]) -> String {
        let (columns, rows) = size();
        let mut text = String::from("\x1b[?25l");
        if self.drawn > 0 {
            let up = format!("\x1b[{}A", self.drawn);
            text.push_str(&up);
        }
        text.push_str("\r\x1b[J");
        let shown = lines.iter().take(rows.saturating_sub(1).max(1));
        self.drawn = shown.len();
        for line in shown {
            text.extend(line.chars().take(columns));
            text.push_str("\r\n");
        }
        text
    }

    /// Shows the cursor again.
    pub(super) const fn restore() -> &'static str {
        "\x1b[?25h"
    }
}

fn size() -> (usize, usize) {
    match rustix::termios::tcgetwinsize(io::stdout()) {
        Ok(size) if size.ws_col > 0 && size.ws_row > 0 => (size.ws_col.into(), size.ws_row.into()),
        _ => (80, 24),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn redrawing_goes_up_by_what_was_drawn() {
        let mut screen = Screen::default();
        let lines = ["one".to_owned(), "two".to_owned()];
        assert!(!screen.replace(&lines).contains("\x1b[2A"));
        assert!(screen.replace(&lines[..1]).contains("\x1b[2A"));
        assert!(screen.replace(&lines).contains("\x1b[1A"));
    }
}
