//! The live table, as text.

use lodestone_schema::{LaneState, Status, Validity};

use crate::service::overview::LaneView;
use crate::status_board::LaneStatus;

/// Column titles, whether a column reads from the left, and its usual width, so that columns do
/// not move with every digit.
const COLUMNS: [(&str, bool, usize); 11] = [
    ("camera", true, 6),
    ("state", true, 9),
    ("Hz", false, 6),
    ("p50/p99 µs", false, 12),
    ("heading °", false, 13),
    ("roll/pitch °", false, 12),
    ("motion", true, 6),
    ("field", true, 9),
    ("dropped", false, 7),
    ("errors", false, 6),
    ("position x y z m", false, 26),
];

const GAP: &str = "  ";

/// At most 80 columns wide.
const LEGEND: &str =
    "± one sigma; heading clockwise from north; (bracketed: not valid); ctrl-c stops";

/// The table's lines: titles, a line for each lane, an explanation.
///
/// Columns that do not fit into the terminal's `width` follow in further blocks below, each of
/// which begins with the camera.
pub fn render(views: &[LaneView], width: usize) -> Vec<String> {
    let titles = COLUMNS.map(|(title, ..)| title.to_owned());
    let rows: Vec<_> = core::iter::once(titles).chain(views.iter().map(row)).collect();
    let widest = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: Widths =
        core::array::from_fn(|column| COLUMNS[column].2.max(widest(column).unwrap_or_default()));
    let blocks = blocks(&widths, width);
    let lines = blocks.iter().flat_map(|block| rows.iter().map(|row| align(row, &widths, block)));
    lines.chain([LEGEND.to_owned()]).collect()
}

type Row = [String; COLUMNS.len()];
type Widths = [usize; COLUMNS.len()];

/// Which columns stand in which block.
fn blocks(widths: &Widths, width: usize) -> Vec<Vec<usize>> {
    let mut blocks = vec![vec![0]];
    let mut used = widths[0];
    for (column, wide) in widths.iter().enumerate().skip(1) {
        if used + GAP.len() + wide > width && blocks.last().is_some_and(|block| block.len() > 1) {
            blocks.push(vec![0]);
            used = widths[0];
        }
        used += GAP.len() + wide;
        if let Some(block) = blocks.last_mut() {
            block.push(column);
        }
    }
    blocks
}

fn align(row: &Row, widths: &Widths, block: &[usize]) -> String {
    let cells = block.iter().map(|&column| {
        let (cell, width) = (&row[column], widths[column]);
        if COLUMNS[column].1 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
    });
    cells.collect::<Vec<_>>().join(GAP).trim_end().to_owned()
}

fn row(view: &LaneView) -> Row {
    let (health, status) = (&view.health, &view.status);
    let dropped = health.ring_dropped + health.samples_lost;
    let errors = health.invalid + health.out_of_order + health.duplicates + health.publish_errors;
    [
        view.name.clone(),
        state_word(view.state).into(),
        number(health.pose_rate_hz, 1),
        format!("{}/{}", micros(health.latency_p50_s), micros(health.latency_p99_s)),
        heading(status),
        tilt(status),
        motion(status).into(),
        field(status).into(),
        dropped.to_string(),
        errors.to_string(),
        position(status),
    ]
}

/// A word for what a lane is doing.
pub(super) const fn state_word(state: LaneState) -> &'static str {
    match state {
        LaneState::Searching => "searching",
        LaneState::Aligning => "aligning",
        LaneState::Running => "running",
        LaneState::Degraded => "degraded",
        LaneState::Lost => "lost",
        LaneState::Ended => "ended",
    }
}

/// A number, or a dash where it is unknown.
pub(super) fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "-".into() }
}

pub(super) fn micros(seconds: f64) -> String {
    number(seconds * 1e6, 1)
}

/// A value with its sigma; in brackets if the sigma is beyond its configured bound.
pub(super) fn heading(status: &LaneStatus) -> String {
    let value = number(status.heading_rad().to_degrees(), 1);
    let sigma = number(status.heading_sigma_rad().to_degrees(), 1);
    bracket(format!("{value} ± {sigma}"), status, Validity::HEADING)
}

fn tilt(status: &LaneStatus) -> String {
    let (roll, pitch) = status.roll_pitch_rad();
    let text = format!("{} {}", number(roll.to_degrees(), 1), number(pitch.to_degrees(), 1));
    bracket(text, status, Validity::TILT)
}

pub(super) fn position(status: &LaneStatus) -> String {
    let [x, y, z] = status.position_m.map(|axis| number(axis, 2));
    let sigma = number(status.position_sigma_m(), 2);
    bracket(format!("{x} {y} {z} ± {sigma}"), status, Validity::POSITION)
}

fn bracket(text: String, status: &LaneStatus, needed: Validity) -> String {
    let nothing_yet = status.time_ns == 0;
    match (nothing_yet, status.validity.contains(needed)) {
        (true, _) => "-".into(),
        (false, true) => text,
        (false, false) => format!("({text})"),
    }
}

const fn motion(status: &LaneStatus) -> &'static str {
    match (status.time_ns, status.status.contains(Status::STATIONARY)) {
        (0, _) => "-",
        (_, true) => "still",
        (_, false) => "moving",
    }
}

const fn field(status: &LaneStatus) -> &'static str {
    match (status.time_ns, status.status.contains(Status::MAGNETIC_DISTURBANCE)) {
        (0, _) => "-",
        (_, true) => "disturbed",
        (_, false) => "clean",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::publisher::blank_health;
    use lodestone_schema::AlignmentWait;

    fn view(name: &str) -> LaneView {
        LaneView {
            name: name.into(),
            state: LaneState::Searching,
            alignment_wait: AlignmentWait::None,
            health: blank_health(),
            status: LaneStatus::default(),
        }
    }

    fn running() -> LaneView {
        let mut view = view("front");
        view.state = LaneState::Running;
        view.health.pose_rate_hz = 400.02;
        view.health.latency_p50_s = 21.4e-6;
        view.health.ring_dropped = 7;
        view.status = LaneStatus {
            time_ns: 1,
            status: Status::STATIONARY | Status::MAGNETIC_DISTURBANCE,
            validity: Validity::TILT | Validity::HEADING,
            position_m: [1.0, -2.0, 0.5],
            position_variance_m2: [4.0; 3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            orientation_variance_rad2: [0.01_f64.to_radians().powi(2); 3],
            ..LaneStatus::default()
        };
        view
    }

    const WIDE: usize = 200;

    #[test]
    fn what_is_unknown_is_a_dash_and_never_zero() {
        let lines = render(&[view("front")], WIDE);
        let cells: Vec<_> = lines[1].split_whitespace().collect();
        assert_eq!(cells, ["front", "searching", "-", "-/-", "-", "-", "-", "-", "0", "0", "-"]);
    }

    #[test]
    fn a_running_lane_shows_its_values_and_brackets_what_is_not_valid() {
        let line = &render(&[running()], WIDE)[1];
        for shown in ["running", "400.0", "21.4/-", "90.0 ± 0.0", "still", "disturbed", " 7 "] {
            assert!(line.contains(shown), "{shown:?} in {line:?}");
        }
        assert!(line.contains("(1.00 -2.00 0.50 ± 2.00)"), "{line:?}");
    }

    #[test]
    fn columns_stand_under_their_titles() {
        let lines = render(&[view("a"), running()], WIDE);
        let at = |line: &str, text: &str| line[..line.find(text).unwrap()].chars().count();
        assert_eq!(at(&lines[0], "state"), at(&lines[1], "searching"));
        assert_eq!(at(&lines[0], "field"), at(&lines[2], "disturbed"));
    }

    #[test]
    fn a_narrow_terminal_shows_every_column_in_further_blocks() {
        let wide = render(&[running()], WIDE);
        for width in [20, 40, 80, 100] {
            let narrow = render(&[running()], width);
            assert!(narrow.len() > wide.len(), "{width}");
            let titles = narrow.join("\n");
            assert!(COLUMNS.iter().all(|(title, ..)| titles.contains(title)), "{titles}");
            let table = narrow.iter().take(narrow.len() - 1);
            let fits = |line: &String| line.chars().count() <= width.max(6 + 2 + 26);
            assert!(table.clone().all(fits), "{titles}");
        }
    }
}
