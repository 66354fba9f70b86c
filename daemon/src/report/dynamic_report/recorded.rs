//! Real recordings with a truth.

use super::super::page::{cells, figure, list, panel, paragraph, table};
use super::super::plot::{Axis, Mark, Plot};
use super::super::scale::{Scale, signed};
use super::super::svg::Escaped;
use super::format::length;
use crate::evaluation::dynamic::recorded::{OrientationScore, PositionScore, Recorded};

/// Most points of a line.
const MOST_POINTS: usize = 700;

pub(super) fn markup(recordings: &[Recorded]) -> String {
    let intro = paragraph(
        "Recordings of real sensors, through the same lane with the defaults of a configuration. The truth beside \
         the samples serves the score alone.",
    );
    let charts: String = recordings.iter().map(chart).collect();
    let caption = "<b>Errors of real recordings.</b> Orientation: error of heading (blue) and inclination (red), \
                   where the recording says that it is scored. Walks: calculated position (red dots) and true way \
                   (line), seen from above, start and direction laid on the truth’s.";
    intro + &scores(recordings) + &figure("panels", &charts, caption) + &list(&notes())
}

fn notes() -> [String; 1] {
    ["Orientation is scored as in BROAD (Laidig et al. 2021): q<sub>ours</sub> q*<sub>true</sub>, split into its \
      part about the vertical and the rest. Poses before the alignment are not scored here."
        .into()]
}

const HEAD: &str = "<tr><th class=\"text\">Recording</th><th>length, s</th><th>total RMS, °</th><th \
    class=\"yaw\">heading RMS, °</th><th class=\"roll\">inclination RMS, °</th><th>position RMS</th><th>at the \
    end</th><th>way</th></tr>\n";

fn scores(recordings: &[Recorded]) -> String {
    let rows = recordings.iter().map(|recorded| {
        let orientation = recorded.orientation.as_ref().map_or_else(dashes, |score| {
            [score.total_deg, score.heading_deg, score.inclination_deg].map(|deg| signed(deg, 2))
        });
        let position = recorded
            .position
            .as_ref()
            .map_or_else(dashes, |score| [score.rms_m, score.end_m, score.way_m].map(length));
        let cells = cells("td", "", orientation.iter().chain(&position));
        format!(
            "<tr><th scope=\"row\">{}</th><td>{}</td>{cells}</tr>\n",
            Escaped(&recorded.name),
            signed(recorded.duration_s, 0)
        )
    });
    table(HEAD, &rows.collect::<String>())
}

fn dashes() -> [String; 3] {
    ["–", "–", "–"].map(String::from)
}

fn chart(recorded: &Recorded) -> String {
    let name = Escaped(&recorded.name).to_string();
    let orientation = recorded.orientation.as_ref().map(|score| angles(&recorded.name, score));
    let position = recorded.position.as_ref().map(|score| way(&recorded.name, score));
    orientation.or(position).map_or_else(String::new, |chart| panel(&name, &chart))
}

fn angles(name: &str, score: &OrientationScore) -> String {
    let thinned: Vec<_> =
        score.drawn.iter().step_by(score.drawn.len().div_ceil(MOST_POINTS).max(1)).collect();
    let x = Axis::new("time, s", Scale::around(thinned.iter().map(|p| p.0)), 5);
    let y = Axis::new("error, °", Scale::around(thinned.iter().flat_map(|p| [p.1, p.2])), 6);
    let legend = [(Mark::Line, "yaw", "heading"), (Mark::Line, "roll", "inclination")];
    let mut plot = Plot::with_legend(name, (380.0, 300.0), 52.0, (&x, &y), &legend);
    plot.line("yaw", thinned.iter().map(|p| (p.0, p.1)));
    plot.line("roll", thinned.iter().map(|p| (p.0, p.2)));
    plot.finish()
}

fn way(name: &str, score: &PositionScore) -> String {
    let thinned: Vec<_> =
        score.drawn.iter().step_by(score.drawn.len().div_ceil(MOST_POINTS).max(1)).collect();
    let all = || thinned.iter().flat_map(|(ours, truth)| [*ours, *truth]);
    let wide = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    };
    let (x, y) = (wide(&mut all().map(|p| p.x)), wide(&mut all().map(|p| p.y)));
    let middle = (0.5 * (x.0 + x.1), 0.5 * (y.0 + y.1));
    let reach = 0.55 * (x.1 - x.0).max(y.1 - y.0).max(0.1);
    let mut plot = Plot::alike(name, 380.0, ("x, m", "y, m"), (middle, reach));
    plot.dots("calculated", thinned.iter().map(|(ours, _)| (ours.x, ours.y)));
    plot.line("ink", thinned.iter().map(|(_, truth)| (truth.x, truth.y)));
    plot.finish()
}
