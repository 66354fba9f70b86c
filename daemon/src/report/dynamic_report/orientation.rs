//! Orientation on the stairs: errors over time, the swing of a flight, and its spectrum.

use super::super::page::{figure, panel};
use super::super::plot::{Axis, Mark, Plot};
use super::super::scale::Scale;
use super::Context;
use crate::evaluation::dynamic::DynamicResult;
use crate::evaluation::dynamic::harmonic::spectrum;
use crate::evaluation::dynamic::method::Method;
use crate::evaluation::dynamic::stairs::{Drawn, FLIGHT_S, flight};
use crate::evaluation::dynamic::track::{PoseError, Track};

/// The axes in the paper's colours.
const AXES: [(&str, &str); 3] = [("roll", "roll"), ("pitch", "pitch"), ("yaw", "yaw")];
/// Columns of the figure of errors.
const SHOWN: [(Method, &str); 3] = [
    (Method::Raw, "Raw"),
    (Method::OffsetCorrected, "Offset-corrected"),
    (Method::Lodestone, "Lodestone"),
];

fn legend() -> [(Mark, &'static str, &'static str); 3] {
    AXES.map(|(class, name)| (Mark::Line, class, name))
}

fn track_of(walk: &Drawn, method: Method) -> Option<&Track> {
    walk.tracks.get(Method::ALL.iter().position(|m| *m == method)?)
}

/// Errors over time, side by side on one scale.
pub(super) fn errors(result: &DynamicResult, context: &Context) -> String {
    let walk = &result.stairs.drawn;
    let all: Vec<(&str, Vec<PoseError>)> = SHOWN
        .iter()
        .filter_map(|(method, name)| Some((*name, track_of(walk, *method)?.errors(&walk.truth))))
        .collect();
    // The raw drift would make the others flat lines: it may leave the picture.
    let kept = all.iter().skip(1).flat_map(|(_, errors)| errors);
    let largest = kept.flat_map(|e| e.roll_pitch_yaw_deg).fold(0.5, |most, e| e.abs().max(most));
    let y = Axis::new("error, °", Scale::Linear(-1.15 * largest, 1.15 * largest), 6);
    let end_s = walk.truth.0.last().map_or(60.0, |p| p.time_s);
    let x = Axis::new("time since the rest, s", Scale::Linear(0.0, end_s), 6);
    let charts = all.iter().map(|(name, errors)| {
        let title = format!("orientation error, {name}");
        let mut plot = Plot::with_legend(&title, (380.0, 280.0), 52.0, (&x, &y), &legend());
        for (axis, (class, _)) in AXES.iter().enumerate() {
            let thinned = errors.iter().step_by(4);
            plot.line(class, thinned.map(|e| (e.time_s, e.roll_pitch_yaw_deg[axis])));
        }
        panel(name, &plot.finish())
    });
    let caption = format!(
        "<b>Orientation error on the stairs</b>: estimated less true roll, pitch and yaw, all on one scale; \
         the raw integral may leave it. {}",
        context.repeat(1)
    );
    figure("panels", &charts.collect::<String>(), &caption)
}

/// The swing on the first flight and its spectrum.
pub(super) fn swing(result: &DynamicResult, context: &Context) -> String {
    let walk = &result.stairs.drawn;
    let Some(ours) = track_of(walk, Method::Lodestone) else { return String::new() };
    let charts = angles(ours, &walk.truth) + &spectra(ours, &walk.truth);
    let caption = format!(
        "<b>Is it harmonic?</b> Left: roll, pitch and yaw of Lodestone on the first flight, from {} s to {} s \
         after the rest, each about its mean, over the truth (wide and grey, hardly to be seen where both \
         agree). Right: amplitude over frequency of the same, without its slow trend; dashed the truth. \
         {}",
        FLIGHT_S.0,
        FLIGHT_S.1,
        context.repeat(1)
    );
    figure("pair", &charts, &caption)
}

fn angles(ours: &Track, truth: &Track) -> String {
    let ((times, ours), (_, truth)) = (flight(ours), flight(truth));
    let about_mean = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        values.iter().map(|v| v - mean).collect::<Vec<f64>>()
    };
    let (ours, truth) = (ours.map(|v| about_mean(&v)), truth.map(|v| about_mean(&v)));
    let x = Axis::new("time since the rest, s", Scale::Linear(FLIGHT_S.0, FLIGHT_S.1), 6);
    let values = ours.iter().chain(&truth).flatten().copied();
    let y = Axis::new("angle about its mean, °", Scale::around(values), 6);
    let mut entries = legend().to_vec();
    entries.push((Mark::Line, "before broad", "truth"));
    let name = "roll, pitch and yaw on the first flight";
    let mut plot = Plot::with_legend(name, (520.0, 320.0), 56.0, (&x, &y), &entries);
    for (axis, (class, _)) in AXES.iter().enumerate() {
        let line = |values: &[f64]| {
            times.iter().copied().zip(values.iter().copied()).collect::<Vec<_>>().into_iter()
        };
        plot.line("before broad", line(&truth[axis]));
        plot.line(class, line(&ours[axis]));
    }
    plot.finish()
}

fn spectra(ours: &Track, truth: &Track) -> String {
    let frequencies: Vec<f64> = (2..=80).map(|k| 0.04 * f64::from(k)).collect();
    let of = |track: &Track| {
        let (times, angles) = flight(track);
        angles.map(|values| spectrum(&times, &values, &frequencies))
    };
    let (ours, truth) = (of(ours), of(truth));
    let x = Axis::new("frequency, Hz", Scale::Linear(0.0, 3.2), 6);
    let highest = ours.iter().chain(&truth).flatten().fold(0.1, |most, p| p.1.max(most));
    let y = Axis::new("amplitude, °", Scale::Linear(0.0, 1.08 * highest), 6);
    let mut entries = legend().to_vec();
    entries.push((Mark::Line, "ink dashed", "truth"));
    let name = "spectrum of roll, pitch and yaw";
    let mut plot = Plot::with_legend(name, (520.0, 320.0), 56.0, (&x, &y), &entries);
    for (axis, (class, _)) in AXES.iter().enumerate() {
        plot.line(class, ours[axis].iter().copied());
        plot.line("ink dashed", truth[axis].iter().copied());
    }
    plot.finish()
}
