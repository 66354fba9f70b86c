//! One place: the sphere before and after, what is left of |B|, the heading's error, and what was
//! assumed.

use glam::DVec3;
use lodestone_config::model::{Synthetic, TrajectoryKind};

use super::super::page::{definitions, figure, paragraph, section};
use super::super::plot::{Axis, Mark, Plot};
use super::super::scale::{Scale, signed};
use super::super::svg::{Escaped, Px, dots};
use super::{spread, title};
use crate::evaluation::static_places::{Found, PlaceResult, Verdict};
use crate::evaluation::trace::{FieldReading, Trace};

/// Most dots in one chart; more could not be told apart.
const MOST_DOTS: usize = 800;
/// Most dots of one colour in a small picture.
const MOST_SMALL_DOTS: usize = 260;

/// How far from a plane a reading counts as near it, in parts of the earth's field.
const NEAR: f64 = 0.2;

/// A plane of the body frame, seen along the axis about which a turn would move in it.
struct Plane {
    class: &'static str,
    name: &'static str,
    axes: (usize, usize),
    labels: (&'static str, &'static str),
}

const PLANES: [Plane; 3] = [
    Plane {
        class: "roll",
        name: "along the roll axis",
        axes: (1, 2),
        labels: ("B left (y), µT", "B up (z), µT"),
    },
    Plane {
        class: "pitch",
        name: "along the pitch axis",
        axes: (0, 2),
        labels: ("B forward (x), µT", "B up (z), µT"),
    },
    Plane {
        class: "yaw",
        name: "along the yaw axis",
        axes: (0, 1),
        labels: ("B forward (x), µT", "B left (y), µT"),
    },
];

impl Plane {
    /// The readings as seen in this plane, with the class of each cloud. Where they fill the whole
    /// sphere they are pale but for those near the plane, which a turn about its axis draws as a
    /// circle.
    fn clouds(&self, result: &PlaceResult, trace: &Trace, most: usize) -> [(String, Points); 2] {
        let (a, b) = self.axes;
        let along = 3 - a - b;
        let whole_sphere = turned_by_hand(result);
        let near = |r: &FieldReading| {
            !whole_sphere || r.body_ut[along].abs() < NEAR * result.earth_field_ut
        };
        let (near, far): (Vec<_>, Vec<_>) = thinned(trace, most).partition(|r| near(r));
        let points = |readings: Vec<&FieldReading>| -> Points {
            readings.iter().map(|r| (r.body_ut[a], r.body_ut[b])).collect()
        };
        [
            (format!("far {}", self.class), points(far)),
            (format!("near {}", self.class), points(near)),
        ]
    }
}

fn turned_by_hand(result: &PlaceResult) -> bool {
    result.place.synthetic().trajectory == TrajectoryKind::Tumble
}

/// Where dots lie, µT.
type Points = Vec<(f64, f64)>;

/// The anchor of a place's section. Names of cameras hold nothing that an attribute could not.
pub(super) fn anchor(result: &PlaceResult) -> String {
    format!("place-{}", Escaped(&result.name))
}

/// The place's whole section.
pub(super) fn section_of(result: &PlaceResult) -> String {
    let body = paragraph(&movement(result))
        + &verdict(result)
        + &spheres(result)
        + &errors(result)
        + &assumptions(result);
    section(&anchor(result), title(result), &body)
}

/// The field within the circle of the earth's, all three planes laid over each other.
pub(super) fn thumbnail(result: &PlaceResult, calibrated: bool) -> String {
    const SIDE: f64 = 84.0;
    let figures = &result.figures;
    let trace = if calibrated { figures.calibrated.as_ref() } else { Some(&figures.uncalibrated) };
    let Some(trace) = trace else { return "–".into() };
    let half = 0.5 * SIDE;
    let unit = half / reach(result);
    let clouds: Vec<String> = PLANES
        .iter()
        .flat_map(|plane| plane.clouds(result, trace, MOST_SMALL_DOTS))
        .map(|(class, points)| {
            let points = points.into_iter().map(|(x, y)| (half + unit * x, half - unit * y));
            format!("<path class=\"dots {class}\" d=\"{}\"/>", dots(points))
        })
        .collect();
    let radius = Px(unit * result.earth_field_ut);
    let state = if calibrated { "calibrated" } else { "uncalibrated" };
    format!(
        "<svg role=\"img\" viewBox=\"0 0 {SIDE} {SIDE}\" width=\"{SIDE}\" height=\"{SIDE}\"><title>{}, \
         {state}</title><circle class=\"ring\" cx=\"{half}\" cy=\"{half}\" r=\"{radius}\"/>\
         <path class=\"grid\" d=\"M{half} 0V{SIDE}M0 {half}H{SIDE}\"/>{}</svg>",
        Escaped(title(result)),
        clouds.concat(),
    )
}

/// Half the side of every picture of this place's sphere, µT.
fn reach(result: &PlaceResult) -> f64 {
    let figures = &result.figures;
    let traces = [Some(&figures.uncalibrated), figures.calibrated.as_ref()];
    let readings = traces.into_iter().flatten().flat_map(|trace| &trace.0);
    let largest = readings.map(|r| r.body_ut.abs().max_element());
    1.06 * largest.fold(result.earth_field_ut, f64::max)
}

/// At most `most` readings, evenly taken.
fn thinned(trace: &Trace, most: usize) -> impl Iterator<Item = &FieldReading> {
    trace.0.iter().step_by(trace.0.len().div_ceil(most).max(1))
}

fn movement(result: &PlaceResult) -> String {
    let synthetic = result.place.synthetic();
    let how = match synthetic.trajectory {
        TrajectoryKind::Tumble => {
            "The camera can be lifted: it is turned through all attitudes by hand.".into()
        }
        TrajectoryKind::Circles => format!(
            "The camera stays in its car, which nobody can turn over: it makes two circles to each \
             side on ground that slopes by {}°. That is all the tilt there is, so the dots do not fill the sphere.",
            signed(synthetic.tilt_deg, 1)
        ),
        _ => "The camera moves as its scenario says; that is no movement to calibrate with.".into(),
    };
    let (from, seconds) = (Escaped(&result.scenario), signed(synthetic.duration_s, 0));
    format!("{how} {seconds} s for each recording. Scenario: <code>{from}</code>.")
}

fn verdict(result: &PlaceResult) -> String {
    match &result.calibration {
        Verdict::Refused(why) => paragraph(&format!(
            "<span class=\"warn\">Calibration refused.</span> {}.",
            Escaped(why)
        )),
        Verdict::Accepted(found) => accepted(result, found),
    }
}

fn accepted(result: &PlaceResult, found: &Found) -> String {
    let Some(after) = result.calibrated else { return String::new() };
    let before = result.uncalibrated;
    definitions(&[
        (
            "heading, RMS error",
            format!(
                "{}° → {}°, reading by reading",
                spread(before.heading_rms_deg, 2),
                spread(after.heading_rms_deg, 2)
            ),
        ),
        (
            "of it lasting",
            format!(
                "{}° → {}°: what is left without noise and with all motors and devices off, such as their \
                 mean field during calibration; expected by the calibration {}° (1σ)",
                spread(before.lasting_heading_rms_deg, 2),
                spread(after.lasting_heading_rms_deg, 2),
                signed(found.heading_sigma_deg, 2)
            ),
        ),
        (
            "σ of |B| at rest",
            format!(
                "{} → {} µT: what changes in time, and no calibration can take away",
                signed(before.rest_sigma_ut, 2),
                signed(after.rest_sigma_ut, 2)
            ),
        ),
        (
            "hard iron found",
            format!(
                "{} µT, {} µT from the configured one",
                vector(found.hard_iron_ut, 1),
                signed(found.hard_iron_error_ut, 1)
            ),
        ),
        ("soft iron found", format!("C = {}", found.soft_iron.map(|row| vector(row, 3)).join(" "))),
    ])
}

/// The paper's figure of the calibration, of one place.
pub(super) fn spheres(result: &PlaceResult) -> String {
    let reach = reach(result);
    let row = |name: &str, trace: &Trace| {
        let panels: String =
            PLANES.iter().map(|plane| sphere(result, plane, reach, trace)).collect();
        format!("<p class=\"row-name\">{name}</p>\n{panels}")
    };
    let mut panels = row("Uncalibrated", &result.figures.uncalibrated);
    if let Some(calibrated) = &result.figures.calibrated {
        panels += &row("Calibrated, on a recording that the calibration has not seen", calibrated);
    }
    let seen = if turned_by_hand(result) {
        "Full colour: readings near the plane of the picture, which lie on the circle itself; pale: the \
         others."
    } else {
        "In a car they are rings on its lower side, where the field points, as far apart as the ground \
         slopes."
    };
    figure(
        "panels",
        &panels,
        &format!(
            "<b>The paper’s figure “Calibration of the Magnetic Field Sensor”.</b> The measured field in \
             body axes, seen along the <span class=\"roll\">roll</span>, <span \
             class=\"pitch\">pitch</span> and <span class=\"yaw\">yaw</span> axis. Dashed: the earth’s \
             field at this place. Calibrated readings lie on a sphere of that radius about the origin. \
             {seen}"
        ),
    )
}

fn sphere(result: &PlaceResult, plane: &Plane, reach: f64, trace: &Trace) -> String {
    let name = format!("{}, {}", title(result), plane.name);
    let mut plot = Plot::square(&name, 340.0, plane.labels, reach);
    plot.ring("", result.earth_field_ut);
    for (class, points) in plane.clouds(result, trace, MOST_DOTS) {
        plot.dots(&class, points.into_iter());
    }
    plot.finish()
}

const BEFORE_AND_AFTER: [(Mark, &str, &str); 2] =
    [(Mark::Dot, "before", "uncalibrated"), (Mark::Dot, "ours", "calibrated")];

fn errors(result: &PlaceResult) -> String {
    let earth = result.earth_field_ut;
    let strength = Panel {
        name: "strength of the field over time",
        x: None,
        y: "|B| − |B earth|, µT",
        point: &|r: &FieldReading| (r.time_s, r.body_ut.length() - earth),
    };
    let heading = Panel {
        name: "error of the heading by heading",
        x: Some(Axis::every("true heading, ° from north", 0.0, 360.0, 4)),
        y: "heading error, °",
        point: &|r: &FieldReading| (r.heading_deg, r.heading_error_deg),
    };
    figure(
        "pair",
        &(panel(result, &strength) + &panel(result, &heading)),
        "<b>Residuals.</b> Left: what the strength of the field is off, over the recording. Right: the \
         error of a heading from single readings under the true tilt. σ knows the left picture alone; \
         a compass needs the right one.",
    )
}

/// A chart of every reading before and after.
struct Panel<'a> {
    name: &'a str,
    /// The axis of x; time if absent.
    x: Option<Axis>,
    y: &'a str,
    point: &'a dyn Fn(&FieldReading) -> (f64, f64),
}

fn panel(result: &PlaceResult, panel: &Panel<'_>) -> String {
    let before = &result.figures.uncalibrated;
    let after = result.figures.calibrated.as_ref();
    let all =
        || [Some(before), after].into_iter().flatten().flat_map(|trace| &trace.0).map(panel.point);
    let time = || Axis::new("time, s", Scale::around(all().map(|point| point.0)), 8);
    let x = panel.x.clone().unwrap_or_else(time);
    let y = Axis::new(panel.y, Scale::around(all().map(|point| point.1)), 6);
    let legend = if after.is_some() { &BEFORE_AND_AFTER[..] } else { &BEFORE_AND_AFTER[..1] };
    let name = format!("{}: {}", title(result), panel.name);
    let mut plot = Plot::with_legend(&name, (520.0, 300.0), 58.0, (&x, &y), legend);
    plot.dots("before", thinned(before, MOST_DOTS).map(panel.point));
    if let Some(after) = after {
        plot.dots("ours", thinned(after, MOST_DOTS).map(panel.point));
    }
    plot.finish()
}

fn assumptions(result: &PlaceResult) -> String {
    let synthetic = result.place.synthetic();
    let noise = result.place.camera.noise.unwrap_or_else(|| result.place.camera.model.noise());
    let mut pairs = vec![
        (
            "earth’s field",
            format!("{} µT (World Magnetic Model)", signed(result.earth_field_ut, 1)),
        ),
        (
            "hard iron",
            format!("{} µT in sensor axes", vector(synthetic.distortion.hard_iron_ut, 1)),
        ),
        ("soft iron", synthetic.distortion.soft_iron.map(|row| vector(row, 3)).join(" ")),
        (
            "noise",
            format!(
                "{} µT a reading, white; {} µT/√Hz at 1 Hz, 1/f",
                signed(noise.mag_sigma_ut * synthetic.errors.noise_scale, 2),
                signed(synthetic.errors.mag_flicker_ut_rthz * synthetic.errors.noise_scale, 2)
            ),
        ),
    ];
    pairs.extend(surroundings(&synthetic));
    format!("<h3>Assumed here</h3>\n{}", definitions(&pairs))
}

fn surroundings(synthetic: &Synthetic) -> Vec<(&'static str, String)> {
    let length = |field: [f64; 3]| signed(DVec3::from_array(field).length(), 2);
    let motors = synthetic.motor.iter().map(|motor| {
        let (field, idle) = (length(motor.field_ut), signed(motor.idle_hz, 1));
        let rise = signed(motor.hz_per_m_s, 1);
        ("motor", format!("{field} µT amplitude at {idle} Hz, and {rise} Hz more for each m/s"))
    });
    let instruments = synthetic.instrument.iter().map(|instrument| {
        let (field, on, off) =
            (length(instrument.field_ut), signed(instrument.on_s, 0), signed(instrument.off_s, 0));
        ("instrument", format!("{field} µT, {on} s on, {off} s off"))
    });
    let disturbances = synthetic.disturbance.iter().map(|disturbance| {
        let (field, hz) = (length(disturbance.field_ut), signed(disturbance.frequency_hz, 0));
        ("in the room", format!("{field} µT at {hz} Hz, fixed to the room"))
    });
    motors.chain(instruments).chain(disturbances).collect()
}

fn vector(vector: [f64; 3], decimals: usize) -> String {
    format!("({})", vector.map(|v| signed(v, decimals)).join(", "))
}
