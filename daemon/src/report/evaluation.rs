//! The report of `lodestoned evaluate`: static and dynamic part on one page, in the paper's order.

mod summary;

use serde::Serialize;

use super::dynamic_report;
use super::page::{page, section};
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
        let mut body = summary::markup(self);
        if let Some(part) = &self.static_part {
            body += &part.sections();
        }
        if let Some(part) = &self.dynamic {
            body += &dynamic_report::sections(part, self.seed);
        }
        if let Some(part) = &self.static_part {
            body += &part.appendix();
        }
        body += &self.method();
        page("Lodestone: evaluation", &body)
    }

    fn method(&self) -> String {
        let statics = self
            .static_part
            .as_ref()
            .map(|part| format!("<h3>Static part</h3>\n{}", part.method()));
        let dynamic = self
            .dynamic
            .as_ref()
            .map(|_| format!("<h3>Dynamic part</h3>\n{}", dynamic_report::method_notes()));
        let body = statics.unwrap_or_default()
            + &dynamic.unwrap_or_default()
            + "<p class=\"note\">All numbers of this page are in <code>report.json</code> beside it.</p>\n";
        section("method", "Method", &body)
    }

    /// The tables for a terminal.
    pub fn text(&self) -> String {
        let statics = self.static_part.as_ref().map(|part| text_table(&part.places));
        let dynamic = self.dynamic.as_ref().map(dynamic_report::tables);
        [statics, dynamic].into_iter().flatten().collect::<Vec<_>>().join("\n")
    }
}
