//! Lines to standard output, and remarks to standard error.

use std::fmt::Display;
use std::io::{self, StdoutLock, Write};

use serde::Serialize;

use super::failure::Failure;

/// Standard output, flushed after each line so that whoever reads a pipe is not kept waiting.
pub(super) struct Output {
    out: StdoutLock<'static>,
}

impl Output {
    pub(super) fn new() -> Self {
        Self { out: io::stdout().lock() }
    }

    pub(super) fn line(&mut self, text: &str) -> Result<(), Failure> {
        writeln!(self.out, "{text}")?;
        Ok(self.out.flush()?)
    }

    pub(super) fn json(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        let text = serde_json::to_string(value).map_err(|e| Failure::Other(e.to_string()))?;
        self.line(&text)
    }

    /// Text as it is, for the terminal.
    pub(super) fn raw(&mut self, text: &str) -> Result<(), Failure> {
        self.out.write_all(text.as_bytes())?;
        Ok(self.out.flush()?)
    }
}

/// Says something on standard error. A reader that is gone is no reason to fail, or to panic as
/// `eprintln!` does.
pub(super) fn remark(text: impl Display) {
    let _ = writeln!(io::stderr(), "lodestone: {text}");
}
