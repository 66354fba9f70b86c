//! What a check found.

use std::fmt::Write;

use serde::Serialize;

/// How good it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Verdict {
    /// As it should be.
    Ok,
    /// It cannot be told here; no reason to worry.
    Unknown,
    /// It works; poses could be more in time, or more sure to come.
    Better,
    /// It does not work, or not as configured.
    Bad,
}

/// One check: what was found, what it means, what to change.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Finding {
    /// Name of the check.
    pub(super) check: &'static str,
    pub(super) verdict: Verdict,
    /// What is there.
    pub(super) found: String,
    /// What follows from it.
    pub(super) means: Option<String>,
    /// The command or line that changes it.
    pub(super) change: Option<String>,
}

impl Finding {
    /// As it should be.
    pub(super) fn ok(check: &'static str, found: impl Into<String>) -> Self {
        Self { check, verdict: Verdict::Ok, found: found.into(), means: None, change: None }
    }

    /// It cannot be told, and why.
    pub(super) fn unknown(check: &'static str, why: impl Into<String>) -> Self {
        Self { verdict: Verdict::Unknown, ..Self::ok(check, why) }
    }

    /// It works, but could be better.
    pub(super) fn better(check: &'static str, found: impl Into<String>) -> Self {
        Self { verdict: Verdict::Better, ..Self::ok(check, found) }
    }

    /// It does not work.
    pub(super) fn bad(check: &'static str, found: impl Into<String>) -> Self {
        Self { verdict: Verdict::Bad, ..Self::ok(check, found) }
    }

    /// Says what follows from it.
    pub(super) fn means(mut self, means: impl Into<String>) -> Self {
        self.means = Some(means.into());
        self
    }

    /// Says how to change it.
    pub(super) fn change(mut self, change: impl Into<String>) -> Self {
        self.change = Some(change.into());
        self
    }

    /// Lines for people.
    pub(super) fn to_text(&self) -> String {
        let verdict = match self.verdict {
            Verdict::Ok => "ok",
            Verdict::Unknown => "unknown",
            Verdict::Better => "better",
            Verdict::Bad => "BAD",
        };
        let mut text = format!("{verdict:<8} {:<15} {}", self.check, self.found);
        for (what, said) in [("means", &self.means), ("change", &self.change)] {
            if let Some(said) = said {
                // Writing to a string does not fail.
                let _ = write!(text, "\n{:<8} {what:>15} {said}", "");
            }
        }
        text
    }
}
