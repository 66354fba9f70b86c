//! What is said of a camera's registrations.

use lodestone_client::{RefineReport, Refusals};
use serde::Serialize;

use super::refine::{AidReport, Refining};

/// What became of one camera's registrations, as JSON.
#[derive(Debug, Serialize)]
pub(super) struct RefineLine {
    accepted: u64,
    refused: u64,
    refused_too_few_points: u64,
    refused_no_overlap: u64,
    refused_degenerate: u64,
    refused_contradicts_prior: u64,
    refused_other: u64,
    last_refusal: Option<String>,
    clouds_held: u64,
    clouds_unrefined: u64,
    /// Turn about the world's axes, east, north, up.
    turn_rad: Option<[f64; 3]>,
    shift_m: Option<[f64; 3]>,
    overlap: Option<f64>,
    rmse_before_m: Option<f64>,
    rmse_after_m: Option<f64>,
    fixes_offered: Option<u64>,
    fixes_failed: Option<u64>,
    last_failure: Option<String>,
}

impl RefineLine {
    /// `None` for the anchor.
    pub(super) fn new(refining: &Refining, camera: usize) -> Option<Self> {
        let (report, aid) = (refining.report(camera)?, refining.aid_report(camera));
        let RefineReport { accepted, refused, held, unrefined, last, correction, .. } = report;
        let Refusals { too_few_points, no_overlap, degenerate, contradicts_prior, other } =
            *refused;
        Some(Self {
            accepted: *accepted,
            refused: refused.total(),
            refused_too_few_points: too_few_points,
            refused_no_overlap: no_overlap,
            refused_degenerate: degenerate,
            refused_contradicts_prior: contradicts_prior,
            refused_other: other,
            last_refusal: report.last_refusal.as_ref().map(ToString::to_string),
            clouds_held: *held,
            clouds_unrefined: *unrefined,
            turn_rad: correction.map(|(turn, _)| turn.to_array()),
            shift_m: correction.map(|(_, shift)| shift.to_array()),
            overlap: last.map(|last| last.overlap),
            rmse_before_m: last.map(|last| last.rmse_before_m),
            rmse_after_m: last.map(|last| last.rmse_after_m),
            fixes_offered: aid.as_ref().map(|aid| aid.offered),
            fixes_failed: aid.as_ref().map(|aid| aid.failed),
            last_failure: aid.and_then(|AidReport { last_failure, .. }| last_failure),
        })
    }

    /// For people.
    pub(super) fn sentence(&self, camera: &str) -> String {
        let mut parts =
            vec![format!("{} registrations accepted, {} refused", self.accepted, self.refused)];
        let [turn_deg, shift_cm] =
            [self.turn_rad.map(norm).map(f64::to_degrees), self.shift_m.map(norm).map(|m| m * 1e2)];
        if let (Some(turn), Some(shift)) = (turn_deg, shift_cm) {
            parts.push(format!("turned by {turn:.2}° and moved by {shift:.1} cm"));
        }
        if let (Some(before), Some(after)) = (self.rmse_before_m, self.rmse_after_m) {
            parts.push(format!(
                "off by {:.1} cm before, {:.1} cm after",
                before * 1e2,
                after * 1e2
            ));
        }
        if self.clouds_held + self.clouds_unrefined > 0 {
            let (held, unrefined) = (self.clouds_held, self.clouds_unrefined);
            parts.push(format!(
                "{held} clouds left out before the first, {unrefined} merged without"
            ));
        }
        if let Some(offered) = self.fixes_offered {
            parts.push(format!("{offered} offered to the daemon"));
        }
        format!("{camera}: {}", parts.join("; "))
    }

    pub(super) fn problems(&self) -> Vec<String> {
        let refused = self.last_refusal.as_ref().filter(|_| self.refused > 0);
        let refused = refused
            .map(|why| format!("registration refused {} times, the last: {why}", self.refused));
        let failed = self.fixes_failed.filter(|failed| *failed > 0);
        let because = self.last_failure.as_deref().unwrap_or_default();
        let failed =
            failed.map(|failed| format!("{failed} fixes not handed over, the last: {because}"));
        refused.into_iter().chain(failed).collect()
    }
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
