//! The table as a picture: σ before and after, ours above the paper's.

use super::super::page::figure;
use super::super::plot::{Axis, Mark, Plot};
use super::super::scale::Scale;
use super::title;
use crate::evaluation::static_places::PlaceResult;

/// How far ours lies above, and the paper's below, the middle of a row.
const APART: f64 = 0.17;

/// Both charts with their caption.
pub(super) fn figure_of(places: &[PlaceResult]) -> String {
    let names: Vec<String> = places.iter().map(|result| title(result).to_owned()).collect();
    let rows = Axis::rows(&names);
    let charts = sigma_chart(places, &rows) + &epsilon_chart(places, &rows);
    figure(
        "wide",
        &charts,
        "<b>The same as a picture.</b> Left: σ on a logarithmic axis; each line runs from \
         uncalibrated (pale) to calibrated (full). Right: ε, the part that calibration took away. \
         Upper circles ours, lower diamonds the paper’s.",
    )
}

fn height(places: &[PlaceResult]) -> f64 {
    80.0 + 42.0 * places.len() as f64
}

fn sigma_chart(places: &[PlaceResult], rows: &Axis) -> String {
    let paper = places.iter().filter_map(|p| p.paper).flat_map(|p| [p.sigma_nc_ut, p.sigma_c_ut]);
    let ours = places.iter().flat_map(|p| {
        [Some(p.uncalibrated.sigma_ut.mean), p.calibrated.map(|score| score.sigma_ut.mean)]
    });
    let scale = Scale::decades(paper.chain(ours.flatten()));
    let x = Axis::new("σ of the field’s strength, µT", scale, 5);
    let legend = [(Mark::Dot, "ours", "ours"), (Mark::Diamond, "paper", "paper")];
    let size = (640.0, height(places));
    let mut plot =
        Plot::with_legend("σ before and after calibration", size, 96.0, (&x, rows), &legend);
    for (row, result) in places.iter().enumerate() {
        let row = row as f64;
        let after = result.calibrated.map(|score| score.sigma_ut.mean);
        let before = result.uncalibrated.sigma_ut.mean;
        pair(&mut plot, (Mark::Dot, "ours"), row - APART, (before, after));
        if let Some(paper) = result.paper {
            let values = (paper.sigma_nc_ut, Some(paper.sigma_c_ut));
            pair(&mut plot, (Mark::Diamond, "paper"), row + APART, values);
        }
    }
    plot.finish()
}

fn pair(
    plot: &mut Plot,
    (mark, class): (Mark, &str),
    row: f64,
    (before, after): (f64, Option<f64>),
) {
    let faint = format!("{class} faint");
    if let Some(after) = after {
        plot.line(&faint, [(before, row), (after, row)].into_iter());
        plot.mark(mark, class, (after, row));
    }
    plot.mark(mark, &faint, (before, row));
}

fn epsilon_chart(places: &[PlaceResult], rows: &Axis) -> String {
    let ours = places.iter().filter_map(|p| p.epsilon_percent).map(|epsilon| epsilon.mean);
    let lowest = ours.clone().fold(0.0, f64::min);
    let scale = Scale::Linear((1.1 * lowest).min(-5.0), 100.0);
    let x = Axis::new("ε, %", scale, 5);
    let blank: Vec<String> = places.iter().map(|_| String::new()).collect();
    let rows = Axis { ticks: Axis::rows(&blank).ticks, ..rows.clone() };
    let size = (430.0, height(places));
    let mut plot = Plot::with_legend("ε by place", size, 30.0, (&x, &rows), &[]);
    for (row, result) in places.iter().enumerate() {
        let row = row as f64;
        let mut bar = |mark, class, row, value| {
            plot.line(class, [(0.0, row), (value, row)].into_iter());
            plot.mark(mark, class, (value, row));
        };
        if let Some(epsilon) = result.epsilon_percent {
            bar(Mark::Dot, "ours", row - APART, epsilon.mean);
        }
        if let Some(paper) = result.paper {
            bar(Mark::Diamond, "paper", row + APART, paper.epsilon_percent);
        }
    }
    plot.finish()
}
