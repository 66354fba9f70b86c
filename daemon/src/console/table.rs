//! The live table, as text.

use lodestone_schema::{LaneState, Status, Validity};

use crate::service::overview::LaneView;
use crate::status_board::LaneStatus;

/// Column titles and whether a column reads from the left.
const COLUMNS: [(&str, bool); 11] = [
    ("camera", true),
    ("state", true),
    ("Hz", false),
    ("p50/p99 µs", false),
    ("heading °", false),
    ("roll/pitch °", false),
    ("position x y z m", false),
    ("motion", true),
    ("field", true),
    ("dropped", false),
    ("errors", false),
];

/// The table's lines: a title, a line for each lane, an explanation.
pub fn render(views: &[LaneView]) -> Vec<String> {
    let titles = COLUMNS.map(|(title, _)| title.to_owned());
    let rows: Vec<_> = core::iter::once(titles).chain(views.iter().map(row)).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max();
    let widths: [usize; COLUMNS.len()] = core::array::from_fn(|column| width(column).unwrap_or(0));
    let mut lines: Vec<_> = rows.iter().map(|row| align(row, &widths)).collect();
    lines.push("± is one standard deviation; heading is clockwise from north; ctrl-c stops".into());
    lines
}

type Row = [String; COLUMNS.len()];

fn align(row: &Row, widths: &[usize; COLUMNS.len()]) -> String {
    let cells = row.iter().zip(widths).zip(COLUMNS);
    let cells =
        cells.map(
            |((cell, &width), (_, from_left))| {
                if from_left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            },
        );
    cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
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
        position(status),
        motion(status).into(),
        field(status).into(),
        dropped.to_string(),
        errors.to_string(),
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

    fn view(name: &str) -> LaneView {
        LaneView {
            name: name.into(),
            state: LaneState::Searching,
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

    #[test]
    fn what_is_unknown_is_a_dash_and_never_zero() {
        let lines = render(&[view("front")]);
        let cells: Vec<_> = lines[1].split_whitespace().collect();
        assert_eq!(cells, ["front", "searching", "-", "-/-", "-", "-", "-", "-", "-", "0", "0"]);
    }

    #[test]
    fn a_running_lane_shows_its_values_and_brackets_what_is_not_valid() {
        let line = &render(&[running()])[1];
        for shown in ["running", "400.0", "21.4/-", "90.0 ± 0.0", "still", "disturbed", " 7 "] {
            assert!(line.contains(shown), "{shown:?} in {line:?}");
        }
        assert!(line.contains("(1.00 -2.00 0.50 ± 2.00)"), "{line:?}");
    }

    #[test]
    fn columns_stand_under_their_titles() {
        let lines = render(&[view("a"), running()]);
        let at = |line: &str, text: &str| {
            line.chars().count() - {
                let byte = line.find(text).unwrap();
                line[byte..].chars().count()
            }
        };
        assert_eq!(at(&lines[0], "state"), at(&lines[1], "searching"));
        assert_eq!(at(&lines[0], "state"), at(&lines[2], "running"));
    }
}
