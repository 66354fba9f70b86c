//! Double integration: how far the position is off after some time.

use super::super::page::{beside, cells, figure, panel, paragraph, table};
use super::super::plot::{Axis, Plot};
use super::super::scale::{Scale, Tick};
use super::Context;
use super::format::{length, lengths};
use super::method::{class, emphasis, legend_of_all, name};
use crate::evaluation::dynamic::DynamicResult;
use crate::evaluation::dynamic::drift::{Drift, MethodDrift, TABLE_S};
use crate::evaluation::dynamic::method::Method;

/// Methods whose spread is drawn; more bands would hide each other.
const WITH_BAND: [Method; 3] = [Method::Raw, Method::OffsetCorrected, Method::LodestoneCalibrated];

pub(super) fn markup(result: &DynamicResult, context: &Context) -> String {
    let (rest, motion) = (&result.at_rest, &result.in_motion);
    let scale = scale(&[rest, motion]);
    let charts = chart("At rest", rest, scale) + &chart("Carried through a room", motion, scale);
    let caption = format!(
        "<b>Position error over time</b> after ten seconds of rest, both axes logarithmic. Left: the camera \
         goes on standing. Right: it is carried through a room and put down now and then. Lines: median; \
         bands: eight of ten runs. {}",
        context.repeat(result.runs)
    );
    paragraph(
        "“The double integrated acceleration after time leads to major position deviations. Adjusting \
         the offset reduces the deviation error but does not eliminate it. By implementing a Kalman and \
         low-pass filter, we are able to improve the noise and following position behaviour.”",
    ) + &legend_of_all()
        + &figure("pair", &charts, &caption)
        + "<h3>At rest</h3>\n"
        + &numbers(rest)
        + "<h3>Carried through a room</h3>\n"
        + &numbers(motion)
        + &compared(result)
}

/// The decades of both scenes, so that their axes agree; a few micrometres are nothing.
fn scale(drifts: &[&Drift]) -> Scale {
    let points = drifts.iter().flat_map(|d| &d.methods).flat_map(|m| &m.curve);
    let values = points.flat_map(|p| [p.error_m.low, p.error_m.high]);
    Scale::decades(values.map(|error| error.max(LEAST_M)))
}

/// The lower end of the axis, m.
const LEAST_M: f64 = 3.0e-6;

fn chart(heading: &str, drift: &Drift, y: Scale) -> String {
    let x = Axis {
        label: "time since the rest, s".into(),
        scale: Scale::Log(0.25, 60.0),
        ticks: [0.3, 1.0, 3.0, 10.0, 30.0, 60.0]
            .map(|value: f64| Tick { value, label: value.to_string() })
            .to_vec(),
    };
    let y = Axis::new("position error, m", y, 0);
    let mut plot = Plot::new(heading, (520.0, 400.0), 56.0, &x, &y);
    for drift in drift.methods.iter().filter(|m| WITH_BAND.contains(&m.method)) {
        let band = drift
            .curve
            .iter()
            .map(|p| (p.time_s, p.error_m.low.max(LEAST_M), p.error_m.high.max(LEAST_M)));
        plot.band(class(drift.method), &band.collect::<Vec<_>>());
    }
    for drift in &drift.methods {
        let line = drift.curve.iter().map(|p| (p.time_s, p.error_m.median.max(LEAST_M)));
        plot.line(class(drift.method), line);
    }
    panel(heading, &plot.finish())
}

fn numbers(drift: &Drift) -> String {
    let times = cells("th", "", TABLE_S.map(|time_s| format!("after {time_s} s")));
    let head = format!("<tr><th class=\"text\">Position error</th>{times}</tr>\n");
    let rows: String = drift.methods.iter().map(row).collect();
    table(&head, &rows)
}

fn row(drift: &MethodDrift) -> String {
    let best = emphasis(drift.method);
    let cells = cells("td", best, drift.table.iter().map(|p| lengths(&p.error_m)));
    format!("<tr><th scope=\"row\">{}</th>{cells}</tr>\n", name(drift.method))
}

fn compared(result: &DynamicResult) -> String {
    let at = |drift: &Drift, method, time_s| {
        let found = drift.of_method(method).and_then(|drift| drift.median_at(time_s));
        found.map_or_else(|| "–".to_owned(), length)
    };
    let row = |drift: &Drift| {
        [Method::Raw, Method::OffsetCorrected, Method::LowPassed, Method::LodestoneCalibrated]
            .map(|method| at(drift, method, 60.0))
            .join(" → ")
    };
    beside(
        "States the three steps in words, without numbers, and only announces the filters.",
        &format!(
            "After a minute, raw → offset-corrected → low-pass → Lodestone, calibrated: at rest {}, carried {}.",
            row(&result.at_rest),
            row(&result.in_motion)
        ),
        &format!(
            "{} The low-pass alone improves the noise and not the position. For the first seconds in motion the \
             filter is no better than the offset-corrected integration: a tilt and an accelerometer’s offset \
             cannot be told apart until the camera has turned or stood.",
            if result.at_rest.order_holds(60.0) && result.in_motion.order_holds(60.0) {
                "The paper’s order holds."
            } else {
                "In these runs the paper’s order does not hold."
            }
        ),
        "Integrating twice is itself a low-pass; what drifts is what lasts. An offset of the gyroscope tilts \
         gravity, and the error grows with t³; what is left of an accelerometer’s offset grows with t². The \
         filter estimates both with their uncertainty, levels by gravity, and takes each standstill that it \
         finds for what it is. It is given no position. \
         (A synthetic tripod stands without the least vibration; a real one is not good to micrometres.)",
    )
}
