//! Messages for people: tracing to standard error, or above the live table.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use iceoryx2::prelude::{LogLevel, set_log_level_from_env_or};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::prelude::*;

/// What is logged when neither `--log` nor `RUST_LOG` says otherwise.
pub const DEFAULT_FILTER: &str = "info";

/// Lines kept for a console that does not come to print them.
const MOST_LINES: usize = 1000;

/// Why logging could not be set up.
#[derive(Debug, thiserror::Error)]
pub enum LoggingError {
    /// The filter cannot be read.
    #[error(
        "cannot read the log filter {filter:?} ({origin}): {what}; for example: info, or lodestone_daemon=debug,warn"
    )]
    Filter {
        /// What was given.
        filter: String,
        /// Where: `--log` or `RUST_LOG`.
        origin: &'static str,
        /// What is wrong with it.
        what: String,
    },
}

/// Log lines on their way to the console; shared by cloning.
#[derive(Clone, Debug, Default)]
pub struct LogLines(Arc<Mutex<Lines>>);

#[derive(Debug, Default)]
struct Lines {
    text: VecDeque<String>,
    lost: u64,
}

impl LogLines {
    /// Takes the lines that came since the last time; tells of those that found no room.
    pub fn take(&self) -> Vec<String> {
        let mut lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut taken: Vec<_> = lines.text.drain(..).collect();
        if lines.lost > 0 {
            taken.insert(0, format!("({} log lines lost)", lines.lost));
            lines.lost = 0;
        }
        taken
    }

    fn add(&self, line: String) {
        let mut lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if lines.text.len() == MOST_LINES {
            lines.text.pop_front();
            lines.lost += 1;
        }
        lines.text.push_back(line);
    }
}

/// One event's text, handed over whole when it is complete.
#[derive(Debug)]
pub struct LineWriter {
    lines: LogLines,
    text: Vec<u8>,
}

impl Write for LineWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.text.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for LineWriter {
    fn drop(&mut self) {
        let text = String::from_utf8_lossy(&self.text);
        text.lines().for_each(|line| self.lines.add(line.into()));
    }
}

impl<'a> MakeWriter<'a> for LogLines {
    type Writer = LineWriter;

    fn make_writer(&'a self) -> LineWriter {
        LineWriter { lines: self.clone(), text: Vec::new() }
    }
}

/// Sets up logging for the whole process: through `lines` if given, else to standard error.
///
/// The filter is `--log`, else `RUST_LOG`, else [`DEFAULT_FILTER`]. iceoryx2 is heard from
/// warnings up (`IOX2_LOG_LEVEL` changes that).
///
/// # Errors
/// [`LoggingError`] quotes a filter that cannot be read.
pub fn init(filter: Option<&str>, lines: Option<&LogLines>) -> Result<(), LoggingError> {
    let filter = choose_filter(filter)?;
    set_log_level_from_env_or(LogLevel::Warn);
    let colour = lines.is_some() || rustix::termios::isatty(rustix::stdio::stderr());
    let builder = tracing_subscriber::fmt()
        .with_max_level(LevelFilter::TRACE)
        .with_target(false)
        .with_ansi(colour && std::env::var_os("NO_COLOR").is_none());
    // A second call in one process keeps the first logger.
    let _ = match lines {
        Some(lines) => builder.with_writer(lines.clone()).finish().with(filter).try_init(),
        None => builder.with_writer(io::stderr).finish().with(filter).try_init(),
    };
    Ok(())
}

fn choose_filter(option: Option<&str>) -> Result<Targets, LoggingError> {
    let environment = std::env::var("RUST_LOG").ok().filter(|text| !text.is_empty());
    let (filter, origin) = match (option, &environment) {
        (Some(text), _) => (text, "--log"),
        (None, Some(text)) => (text.as_str(), "RUST_LOG"),
        (None, None) => (DEFAULT_FILTER, "default"),
    };
    filter.parse::<Targets>().map_err(|e| LoggingError::Filter {
        filter: filter.into(),
        origin,
        what: e.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_arrives_as_whole_lines_in_order() {
        let lines = LogLines::default();
        let mut writer = lines.make_writer();
        writer.write_all(b"first ").unwrap();
        writer.write_all(b"half\nsecond\n").unwrap();
        assert!(lines.take().is_empty());
        drop(writer);
        assert_eq!(lines.take(), ["first half", "second"]);
        assert!(lines.take().is_empty());
    }

    #[test]
    fn a_flood_keeps_the_newest_lines_and_says_how_many_went() {
        let lines = LogLines::default();
        (0..MOST_LINES + 3).for_each(|n| lines.add(n.to_string()));
        let taken = lines.take();
        assert_eq!(taken.len(), MOST_LINES + 1);
        assert_eq!(taken[0], "(3 log lines lost)");
        assert_eq!(taken[1], "3");
    }

    #[test]
    fn a_filter_that_cannot_be_read_is_quoted() {
        let error = choose_filter(Some("lodestone=loud")).unwrap_err();
        assert!(error.to_string().contains("lodestone=loud"), "{error}");
        assert!(error.to_string().contains("--log"), "{error}");
    }
}
