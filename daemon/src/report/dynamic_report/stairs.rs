//! The paper's figure "Trajectory Representation of Climb Stairs": red dots the calculated position,
//! black arrows the sensor's orientation.

use glam::{DMat3, DVec3};

use super::super::page::{figure, legend, panel};
use super::super::plot::{Mark, Plot, key};
use super::Context;
use super::format::length;
use super::projection::{VIEWS, View, along};
use crate::evaluation::dynamic::DynamicResult;
use crate::evaluation::dynamic::method::Method;
use crate::evaluation::dynamic::stairs::{Drawn, Stairs};
use crate::evaluation::dynamic::track::Track;

/// Side of a picture, px.
const SIDE_PX: f64 = 300.0;
/// From one dot to the next, and from one arrow to the next, instants.
const DOT_EVERY: usize = 8;
const ARROW_EVERY: usize = 40;
/// Length of an arrow, m.
const ARROW_M: f64 = 0.45;
/// What is seen around the true way, as a part of its size.
const AROUND: f64 = 0.3;

/// A column of the figure.
struct Column<'a> {
    name: &'static str,
    note: &'static str,
    walk: &'a Drawn,
    track: &'a Track,
}

pub(super) fn pictures(result: &DynamicResult, context: &Context) -> String {
    let columns = columns(result);
    let reach = VIEWS.iter().flat_map(|view| columns.iter().map(|c| frame(c, view).1));
    let reach = reach.fold(0.5, f64::max);
    let panels: String = VIEWS
        .iter()
        .flat_map(|view| columns.iter().map(move |column| picture(column, view, reach)))
        .collect();
    let caption = format!(
        "<b>The paper’s figure “Trajectory Representation of Climb Stairs”.</b> {} Two flights of twelve \
         steps up, a rest at the top, down on the other side. All pictures have one scale; the floor’s squares \
         are one metre. What runs out of a picture is not drawn any more. {}",
        "Red dots: calculated position, five a second. Black arrows: where the camera looks, one a second, \
         drawn at the calculated position. Thin line: the truth.",
        context.repeat(1)
    );
    keys() + &figure("quad", &panels, &caption)
}

fn keys() -> String {
    legend(&[
        (key(Mark::Dot, "roll"), "calculated position".into()),
        (key(Mark::Line, "ink"), "sensor orientation".into()),
        (key(Mark::Line, "truth"), "truth".into()),
    ])
}

impl<'a> Column<'a> {
    fn of(
        (name, note): (&'static str, &'static str),
        stairs: &'a Stairs,
        method: Method,
    ) -> Option<Self> {
        let index = Method::ALL.iter().position(|m| *m == method)?;
        let walk = &stairs.drawn;
        Some(Self { name, note, walk, track: walk.tracks.get(index)? })
    }

    /// When the calculated position is first further away than what is seen, s.
    fn leaves_at(&self, reach: f64) -> Option<f64> {
        let pairs = self.track.0.iter().zip(&self.walk.truth.0);
        let far = pairs.map(|(ours, truth)| (truth.time_s, ours.position_m - truth.position_m));
        far.into_iter().find(|(_, error)| error.length() > reach).map(|(time_s, _)| time_s)
    }

    fn end_error_m(&self) -> f64 {
        let ends = self.track.0.last().zip(self.walk.truth.0.last());
        ends.map_or(f64::NAN, |(ours, truth)| ours.position_m.distance(truth.position_m))
    }
}

fn columns(result: &DynamicResult) -> Vec<Column<'_>> {
    let (on, halting) = (&result.stairs, &result.stairs_halting);
    let calibrated = Method::LodestoneCalibrated;
    let alone = ("Lodestone on its own", "no standstill counts");
    let columns = [
        Column::of(("Raw", "samples integrated as they come"), on, Method::Raw),
        Column::of(("Offset-corrected", "mean of a rest taken off"), on, Method::OffsetCorrected),
        Column::of(alone, on, Method::LodestoneUnaided),
        Column::of(("Lodestone, calibrated", "halts on each landing"), halting, calibrated),
    ];
    columns.into_iter().flatten().collect()
}

/// Middle of the true way in a view, and how far the picture goes from there, m.
fn frame(column: &Column<'_>, view: &View) -> ((f64, f64), f64) {
    let turn = along(&column.walk.truth);
    let points = column.walk.truth.0.iter().map(|p| (view.project)(turn * p.position_m));
    let nothing = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    let (x, y) = points.fold((nothing, nothing), |(x, y), p| (wider(x, p.0), wider(y, p.1)));
    let half = 0.5 * (x.1 - x.0).max(y.1 - y.0);
    ((0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1)), half * (1.0 + 2.0 * AROUND))
}

fn picture(column: &Column<'_>, view: &View, reach: f64) -> String {
    let turn = along(&column.walk.truth);
    let place = |position: DVec3| (view.project)(turn * position);
    let name = format!("stairs, {}, {}", column.name, view.name);
    let around = (frame(column, view).0, reach);
    let mut plot = match view.labels {
        Some(labels) => Plot::alike(&name, SIDE_PX, labels, around),
        None => Plot::picture(&name, SIDE_PX, around),
    };
    if view.labels.is_none() {
        floor(&mut plot, column, turn);
    }
    plot.line("truth", column.walk.truth.0.iter().map(|p| place(p.position_m)));
    let arrows = column.track.0.iter().step_by(ARROW_EVERY).map(|p| {
        let ahead = p.orientation.apply(DVec3::X) * ARROW_M;
        [place(p.position_m), place(p.position_m + ahead)]
    });
    plot.arrows("ink arrow", arrows);
    let dots = column.track.0.iter().step_by(DOT_EVERY).map(|p| place(p.position_m));
    plot.dots("calculated", dots);
    panel(&heading(column, view, reach), &plot.finish())
}

fn heading(column: &Column<'_>, view: &View, reach: f64) -> String {
    if view.labels.is_some() {
        return format!("{}, {}", column.name, view.name);
    }
    let end = length(column.end_error_m());
    let left = column
        .leaves_at(reach)
        .map_or_else(String::new, |time_s| format!(", beyond {reach:.0} m after {time_s:.0} s"));
    format!("{}<small>{}; at the end {end} off{left}</small>", column.name, column.note)
}

/// The floor at the foot of the stairs in squares of one metre.
fn floor(plot: &mut Plot, column: &Column<'_>, turn: DMat3) {
    let points = column.walk.truth.0.iter().map(|p| turn * p.position_m);
    let low = points.clone().fold(DVec3::MAX, DVec3::min).floor();
    let high = points.fold(DVec3::MIN, DVec3::max).ceil();
    let (across, ahead) = ((low.y as i32)..=(high.y as i32), (low.x as i32)..=(high.x as i32));
    let mut line = |from: DVec3, to: DVec3| {
        let view = VIEWS[0].project;
        plot.line("floor", [view(from), view(to)].into_iter());
    };
    for y in across.map(f64::from) {
        line(DVec3::new(low.x, y, 0.0), DVec3::new(high.x, y, 0.0));
    }
    for x in ahead.map(f64::from) {
        line(DVec3::new(x, low.y, 0.0), DVec3::new(x, high.y, 0.0));
    }
}
