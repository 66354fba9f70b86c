//! The table in the terminal.

use std::fmt::Write;

use super::headings::{HeadingError, RelativeError};
use super::outcome::{Outcome, Row, Target};
use super::score::Distances;

/// Everything that was measured, for people.
pub fn text(outcome: &Outcome) -> String {
    let mut text = String::from(
        "distance of points from the surfaces they show, m\n\
         \x20                                points    in the world, as it is     one common motion taken out\n\
         \x20                              millions    RMSE  median    95 %      RMSE  median    95 %\n",
    );
    for row in &outcome.clouds {
        let _ = writeln!(text, "{}", cloud(row));
    }
    text.push_str(&left_out(outcome));
    text.push_str("\nheading, °                          by itself  published σ   after ICP   without magnetometer\n");
    for error in &outcome.headings {
        let _ = writeln!(text, "{}", heading(error));
    }
    if let Some(errors) = &outcome.relative {
        let of = |error: Option<RelativeError>| known(error.map(|e| e.heading_deg));
        let (own, refined, without) =
            (of(Some(errors.own)), of(errors.refined), of(errors.without_magnetometer));
        let _ = writeln!(
            text,
            "{:32} {own:>12} {:>12} {refined:>11} {without:>22}",
            "rear against front", ""
        );
        let _ = writeln!(text, "{}", relative("by Lodestone", &errors.own));
        if let Some(refined) = &errors.refined {
            let _ = writeln!(text, "{}", relative("after ICP", refined));
        }
    }
    text.push_str(&calibrations(outcome));
    for line in outcome.targets.iter().map(target) {
        let _ = writeln!(text, "{line}");
    }
    text
}

fn cloud(row: &Row) -> String {
    let millions = row.merge.points as f64 / 1e6;
    let figures = row.score.map_or_else(
        || "nothing was merged".into(),
        |score| {
            format!("{}  {}", distances(&score.in_world), distances(&score.without_common_motion))
        },
    );
    format!("{:32} {millions:6.2}  {figures}", row.merge.variant.words())
}

fn distances(of: &Distances) -> String {
    format!("{:7.4} {:7.4} {:7.4} ", of.rmse_m, of.median_m, of.p95_m)
}

fn left_out(outcome: &Outcome) -> String {
    let most =
        outcome.clouds.iter().filter_map(|row| Some(row.score?.left_out)).fold(0.0, f64::max);
    format!(
        "where the toy car goes points are left out, at most {:.1} % of a cloud; merged for {} s, after {} s to settle\n",
        100.0 * most,
        outcome.merged_s,
        outcome.settled_s
    )
}

fn heading(error: &HeadingError) -> String {
    format!(
        "{:32} {:>12} {:>12} {:>11} {:>22}",
        format!("{} against the truth", error.camera),
        degrees(error.own_deg),
        format!("± {:.2}", error.own_sigma_deg),
        known(error.refined_deg),
        known(error.without_magnetometer_deg),
    )
}

fn known(value: Option<f64>) -> String {
    value.map_or("unknown".into(), degrees)
}

fn degrees(value: f64) -> String {
    format!("{value:+.2}")
}

fn relative(words: &str, error: &RelativeError) -> String {
    format!(
        "rear as seen from front, {words}: turned wrong by {:.2}°, placed wrong by {:.3} m",
        error.angle_deg, error.place_m
    )
}

fn calibrations(outcome: &Outcome) -> String {
    let each = outcome
        .calibration
        .iter()
        .map(|expected| format!("{} ± {:.2}°", expected.camera, expected.heading_sigma_deg));
    let each: Vec<String> = each.collect();
    let icp = &outcome.refinement;
    let refused = icp.last_refusal.as_ref().map_or(String::new(), |why| format!(" (last: {why})"));
    format!(
        "calibrations expect a heading of {}; ICP: {} registrations, {} refused{refused}\n\n",
        each.join(", "),
        icp.accepted,
        icp.refused
    )
}

/// One line of what was to be reached.
pub fn target(target: &Target) -> String {
    let measured = target.measured.map_or("not measured".into(), |m| format!("{m:.2}"));
    let Target { what, unit, allowed, .. } = target;
    let met = if target.met { "yes" } else { "no" };
    format!("{what} {measured} {unit} (allowed: {allowed} {unit}): {met}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_is_answered_by_yes_or_no_with_its_numbers() {
        let heading = Target {
            what: "headings differ by",
            unit: "°",
            measured: Some(0.614),
            allowed: 0.5,
            met: false,
        };
        assert_eq!(target(&heading), "headings differ by 0.61 ° (allowed: 0.5 °): no");
        let unknown = Target { measured: None, ..heading };
        assert!(target(&unknown).contains("not measured") && target(&unknown).ends_with("no"));
    }

    #[test]
    fn what_is_unknown_is_said_so_and_signs_are_shown() {
        assert_eq!(
            [known(None), known(Some(-0.1)), known(Some(12.3))],
            ["unknown", "-0.10", "+12.30"]
        );
    }
}
