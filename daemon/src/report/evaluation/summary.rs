//! The head of the page: what it is, what was found, in words and in the most important numbers.

use super::Report;
use crate::evaluation::dynamic::DynamicResult;
use crate::evaluation::dynamic::drift::Drift;
use crate::evaluation::dynamic::method::Method;
use crate::evaluation::dynamic::stairs::Stairs;
use crate::report::dynamic_report::{emphasis, length, name};
use crate::report::page::{cells, list, table};
use crate::report::scale::signed;
use crate::report::static_report::StaticReport;

pub(super) fn markup(report: &Report) -> String {
    let mut markup = head(report);
    let findings = [
        report.static_part.as_ref().map(of_static),
        report.dynamic.as_ref().map(of_double_integration),
        report.dynamic.as_ref().map(of_stairs),
        report.dynamic.as_ref().map(of_harmony),
    ];
    let findings: Vec<String> = findings.into_iter().flatten().collect();
    markup += "<h2 id=\"summary\">In short</h2>\n";
    markup += &list(&findings);
    if let Some(dynamic) = &report.dynamic {
        markup += &positions(dynamic);
    }
    markup + &contents(report)
}

fn head(report: &Report) -> String {
    let (seed, version) = (report.seed, report.version);
    let part = match (&report.static_part, &report.dynamic) {
        (Some(_), None) => "The static evaluation of ",
        (None, Some(_)) => "The dynamic evaluation of ",
        _ => "The evaluation of ",
    };
    format!(
        "<h1>The paper’s evaluation, and Lodestone’s</h1>\n\
         <p class=\"lead\">{part}Müller and Kranzlmüller, “Dynamic Sensor Matching based on Geomagnetic \
         Inertial Navigation” (WSCG 2022), repeated in a synthetic world, where the truth is known.</p>\n\
         <p class=\"note\">lodestoned {version}, seed {seed}. The same seed gives the same report, to the \
         byte. Colours of the axes as in the paper: <span class=\"roll\">roll (about forward) red</span>, \
         <span class=\"pitch\">pitch (about left) green</span>, <span class=\"yaw\">yaw (about up) \
         blue</span>. Body axes: x forward, y left, z up.</p>\n"
    )
}

/// `0.51 to 0.98` of positive figures.
fn range(values: impl Iterator<Item = f64> + Clone, decimals: usize) -> String {
    let (low, high) = (values.clone().fold(f64::INFINITY, f64::min), values.fold(0.0, f64::max));
    let (low, high) = (signed(low, decimals), signed(high, decimals));
    if low == high { low } else { format!("{low} to {high}") }
}

fn of_static(part: &StaticReport) -> String {
    let after = || part.places.iter().filter_map(|place| place.calibrated);
    let refused = part.places.len() - after().count();
    let told = match refused {
        0 => String::new(),
        refused => format!(" Refused, and said why: {refused} of {}.", part.places.len()),
    };
    if refused == part.places.len() {
        return format!("<b>Magnetometer.</b> No place could be calibrated.{told}");
    }
    let before = || part.places.iter().filter(|p| p.calibrated.is_some()).map(|p| p.uncalibrated);
    format!(
        "<b>Magnetometer.</b> Calibration brings σ of the field’s strength from {} µT to {} µT (the paper: \
         0.99 to 6.72, then 0.96 to 2.05), and what a heading is wrong by for good from {}° to {}°.{told}",
        range(before().map(|score| score.sigma_ut.mean), 2),
        range(after().map(|score| score.sigma_ut.mean), 2),
        range(before().map(|score| score.lasting_heading_rms_deg.mean), 1),
        range(after().map(|score| score.lasting_heading_rms_deg.mean), 1),
    )
}

fn median_at(drift: &Drift, method: Method, time_s: f64) -> f64 {
    drift.of_method(method).and_then(|drift| drift.median_at(time_s)).unwrap_or(f64::NAN)
}

fn of_double_integration(result: &DynamicResult) -> String {
    let chain = |drift: &Drift| {
        let methods = [Method::Raw, Method::OffsetCorrected, Method::LowPassed, Method::Lodestone];
        methods.map(|method| length(median_at(drift, method, 60.0))).join(" → ")
    };
    let holds = result.at_rest.order_holds(60.0) && result.in_motion.order_holds(60.0);
    let verdict = if holds { "holds" } else { "does not hold" };
    format!(
        "<b>Double integration.</b> The paper’s sentence {verdict} in numbers: position error after a minute, raw \
         → offset-corrected → low-pass → Lodestone (calibrated), is at rest {}, carried through a room {}. The \
         low-pass alone quietens the samples and leaves the drift.",
        chain(&result.at_rest),
        chain(&result.in_motion)
    )
}

fn of_stairs(result: &DynamicResult) -> String {
    let rms = |stairs: &Stairs, method| {
        stairs.of_method(method).map_or(f64::NAN, |score| score.rms_m.median)
    };
    format!(
        "<b>Stairs.</b> Position error (RMS of the walk, median): raw {}, offset-corrected {}, Lodestone {} \
         with one rest at the top, calibrated {}, and {} if the walker halts on each landing. It drifts from one standstill to \
         the next, as everything inertial does.",
        length(rms(&result.stairs, Method::Raw)),
        length(rms(&result.stairs, Method::OffsetCorrected)),
        length(rms(&result.stairs, Method::Lodestone)),
        length(rms(&result.stairs, Method::LodestoneCalibrated)),
        length(rms(&result.stairs_halting, Method::LodestoneCalibrated)),
    )
}

fn of_harmony(result: &DynamicResult) -> String {
    let stairs = &result.stairs;
    let Some(ours) = stairs.of_method(Method::Lodestone) else { return String::new() };
    let rms = ours.orientation_rms_deg.map(|q| signed(q.median, 2));
    format!(
        "<b>Orientation.</b> The walker’s swing, which the paper expected and did not find: the stride explains \
         {} % of Lodestone’s roll on a flight, and {} % of the true one. RMS errors of roll, pitch and yaw are \
         {}°, {}° and {}°.",
        signed(100.0 * ours.explained[0].median, 1),
        signed(100.0 * stairs.true_explained[0].median, 1),
        rms[0],
        rms[1],
        rms[2]
    )
}

/// The most important numbers as a table.
fn positions(result: &DynamicResult) -> String {
    let head = cells("th", "", Method::ALL.map(name));
    let row = |label: &str, figure: &dyn Fn(Method) -> f64| {
        let cell = |method| cells("td", emphasis(method), [length(figure(method))]);
        let cells = Method::ALL.map(cell).concat();
        format!("<tr><th scope=\"row\">{label}</th>{cells}</tr>\n")
    };
    let rms = |stairs: &Stairs, method| {
        stairs.of_method(method).map_or(f64::NAN, |score| score.rms_m.median)
    };
    let rows = [
        row("at rest, after 10 s", &|m| median_at(&result.at_rest, m, 10.0)),
        row("at rest, after 60 s", &|m| median_at(&result.at_rest, m, 60.0)),
        row("carried, after 10 s", &|m| median_at(&result.in_motion, m, 10.0)),
        row("carried, after 60 s", &|m| median_at(&result.in_motion, m, 60.0)),
        row("stairs, RMS", &|m| rms(&result.stairs, m)),
        row("stairs with halts, RMS", &|m| rms(&result.stairs_halting, m)),
    ];
    let head = format!("<tr><th class=\"text\">Position error, median</th>{head}</tr>\n");
    table(&head, &rows.concat())
}

fn contents(report: &Report) -> String {
    let statics = [("calibration", "Calibration"), ("stability", "Stability of the magnetometer")];
    let dynamic = [
        ("noise", "Sensory ground truth"),
        ("drift", "Double integration"),
        ("stairs", "Climbing stairs"),
        ("harmonic", "Is the swing harmonic?"),
    ];
    let appendix = [("places", "Place by place"), ("rest", "Allan deviation")];
    let statics_there = report.static_part.is_some();
    let mut all: Vec<(&str, &str)> = Vec::new();
    all.extend(statics.iter().filter(|_| statics_there));
    all.extend(dynamic.iter().filter(|_| report.dynamic.is_some()));
    if report.dynamic.as_ref().is_some_and(|dynamic| !dynamic.recordings.is_empty()) {
        all.push(("recordings", "Real recordings"));
    }
    all.extend(appendix.iter().filter(|_| statics_there));
    all.push(("method", "Method"));
    let links: Vec<String> =
        all.iter().map(|(id, text)| format!("<a href=\"#{id}\">{text}</a>")).collect();
    format!("<nav>{}</nav>\n", links.join(" "))
}
