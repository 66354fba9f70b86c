//! What a person sees of a running daemon: a live table in a terminal, else lines in the log.

mod journal;
mod screen;
mod table;

pub use journal::Journal;
pub use screen::Screen;
pub use table::render;

use rustix::termios::isatty;

use crate::logging::LogLines;
use crate::service::overview::LaneView;

/// One of the two ways to show the lanes.
pub enum Console {
    /// Redrawn in place, log lines above it.
    Table(Screen<std::io::Stdout>, LogLines),
    /// A line for each lane now and then, and for each change of state.
    Log(Journal),
}

impl Console {
    /// The table if standard output is a terminal that can move its cursor, else the log.
    ///
    /// Give [`Console::log_lines`] to [`crate::logging::init`].
    pub fn choose() -> Self {
        let dumb = std::env::var_os("TERM").is_none_or(|term| term.is_empty() || term == "dumb");
        if isatty(rustix::stdio::stdout()) && !dumb {
            Self::Table(Screen::new(std::io::stdout()), LogLines::default())
        } else {
            Self::Log(Journal::default())
        }
    }

    /// Where log lines must go so that they do not break the table; `None` for standard error,
    /// also where that is not the terminal.
    pub fn log_lines(&self) -> Option<&LogLines> {
        match self {
            Self::Table(_, lines) if isatty(rustix::stdio::stderr()) => Some(lines),
            _ => None,
        }
    }

    /// Shows the lanes.
    pub fn show(&mut self, views: &[LaneView]) {
        match self {
            Self::Table(screen, lines) => {
                let size = terminal_size();
                screen.draw(&lines.take(), &render(views, size.0), size);
            }
            Self::Log(journal) => journal.note(views, std::time::Instant::now()),
        }
    }
}

impl Drop for Console {
    /// The last log lines, and the cursor below the table.
    fn drop(&mut self) {
        if let Self::Table(screen, lines) = self {
            screen.finish(&lines.take());
        }
    }
}

/// Columns and rows of the terminal; very many where it does not tell.
pub(crate) fn terminal_size() -> (usize, usize) {
    let known = |count: u16| if count == 0 { 1000 } else { usize::from(count) };
    let size = rustix::termios::tcgetwinsize(rustix::stdio::stdout());
    size.map_or((1000, 1000), |size| (known(size.ws_col), known(size.ws_row)))
}
