//! The report of `lodestoned evaluate`.

use serde::Serialize;

use super::page::page;
use super::static_report::{StaticReport, text_table};
use crate::evaluation::dynamic::DynamicResult;

/// Everything that an evaluation found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the daemon.
    pub version: &'static str,
    /// Seed of the evaluation.
    pub seed: u64,
    /// The static part, if it was evaluated.
    #[serde(rename = "static")]
    pub static_part: Option<StaticReport>,
    /// The dynamic part, if it was evaluated.
    pub dynamic: Option<DynamicResult>,
}

impl Report {
    /// A report of what was evaluated.
    pub const fn new(
        seed: u64,
        static_part: Option<StaticReport>,
        dynamic: Option<DynamicResult>,
    ) -> Self {
        Self { version: env!("CARGO_PKG_VERSION"), seed, static_part, dynamic }
    }

    /// The whole page.
    pub fn html(&self) -> String {
        let body = self.static_part.as_ref().map(StaticReport::sections).unwrap_or_default();
        page("Lodestone: evaluation", &body)
    }

    /// The tables for a terminal.
    pub fn text(&self) -> String {
        self.static_part.as_ref().map(|part| text_table(&part.places)).unwrap_or_default()
    }
}
