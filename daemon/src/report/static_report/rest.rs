//! Allan deviation of the inertial sensors at rest.

use super::super::page::{figure, paragraph};
use super::super::plot::{Axis, Mark, Plot};
use super::super::scale::{Scale, signed};
use super::super::svg::Escaped;
use crate::evaluation::allan::AllanPoint;
use crate::evaluation::rest::{AtRest, Rest};

const AXES: [(&str, &str); 3] = [("roll", "forward (x)"), ("pitch", "left (y)"), ("yaw", "up (z)")];

/// How a sensor is called, its unit, and the noise it was given.
struct Sensor<'a> {
    name: &'a str,
    unit: &'a str,
    at_rest: &'a AtRest,
    /// White noise density, unit/√Hz.
    density: f64,
    /// Random walk of the bias, unit/s/√Hz.
    walk: f64,
}

pub(super) fn markup(rest: &Rest) -> String {
    let noise = &rest.configured;
    let accelerometer = Sensor {
        name: "acceleration",
        unit: "m/s²",
        at_rest: &rest.accelerometer,
        density: noise.accel_density_m_s2_rthz,
        walk: noise.accel_bias_walk_m_s3_rthz,
    };
    let gyroscope = Sensor {
        name: "angular velocity",
        unit: "rad/s",
        at_rest: &rest.gyroscope,
        density: noise.gyro_density_rad_s_rthz,
        walk: noise.gyro_bias_walk_rad_s2_rthz,
    };
    let sensors = [&accelerometer, &gyroscope];
    let curves: String = sensors.map(allan).concat();
    intro(rest) + &figure("pair", &curves, ALLAN_CAPTION) + &table(&sensors)
}

const ALLAN_CAPTION: &str = "<b>Allan deviation</b> (overlapping estimator, \
    NIST SP 1065 and IEEE 952). White noise falls with slope −½, the random walk of the bias rises with \
    +½. Dashed: √(N²/τ + K²τ/3) of the noise that the synthetic sensors were given. The curves scatter at \
    their right ends, where only some nine averages fit into the recording. The paper shows no such \
    curve.";

fn intro(rest: &Rest) -> String {
    paragraph(&format!(
        "A camera at rest for {} s at “{}”. Noise is that of a ZED 2 as its vendor states it, quantised \
         as the device does; so these curves test the simulation, and say nothing new of a real ZED 2.",
        signed(rest.duration_s, 0),
        Escaped(&rest.place)
    ))
}

fn legend() -> [(Mark, &'static str, &'static str); 3] {
    AXES.map(|(class, name)| (Mark::Line, class, name))
}

fn allan(sensor: &Sensor<'_>) -> String {
    let curves = &sensor.at_rest.allan;
    let all = || curves.iter().flatten();
    let x = Axis::new("averaging time τ, s", Scale::decades(all().map(|p| p.tau_s)), 5);
    let label = format!("σ(τ), {}", sensor.unit);
    let y = Axis::new(&label, Scale::decades(all().map(|p| p.deviation)), 5);
    let name = format!("Allan deviation of {}", sensor.name);
    let mut entries = legend().to_vec();
    entries.push((Mark::Line, "ink dashed", "given"));
    let mut plot = Plot::with_legend(&name, (520.0, 360.0), 64.0, (&x, &y), &entries);
    for (curve, (class, _)) in curves.iter().zip(AXES) {
        plot.line(class, curve.iter().map(|p| (p.tau_s, p.deviation)));
    }
    let longest = curves.iter().max_by_key(|curve| curve.len()).map_or(&[][..], |curve| &curve[..]);
    let theory = |p: &AllanPoint| {
        let (white, walk) = (sensor.density, sensor.walk);
        (p.tau_s, (white * white / p.tau_s + walk * walk * p.tau_s / 3.0).sqrt())
    };
    plot.line("ink dashed", longest.iter().map(theory));
    plot.finish()
}

fn table(sensors: &[&Sensor<'_>; 2]) -> String {
    let rows: String =
        sensors.iter().flat_map(|sensor| [0, 1, 2].map(|axis| row(sensor, axis))).collect();
    format!(
        "<div class=\"scroll\">\n<table>\n<thead><tr><th class=\"text\">Sensor</th><th \
         class=\"text\">axis</th><th>mean</th><th>σ of a sample</th><th>σ(τ) lowest</th><th>at τ, \
         s</th><th class=\"text\">unit</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n"
    )
}

fn row(sensor: &Sensor<'_>, axis: usize) -> String {
    let (class, name) = AXES[axis];
    let shown = |value: Option<f64>| value.map_or_else(|| "–".into(), |v| signed(v, 5));
    let lowest =
        sensor.at_rest.allan[axis].iter().min_by(|a, b| a.deviation.total_cmp(&b.deviation));
    format!(
        "<tr><td class=\"text\">{}</td><td class=\"text {class}\">{name}</td><td>{}</td><td>{}</td>\
         <td>{}</td><td>{}</td><td class=\"text\">{}</td></tr>\n",
        sensor.name,
        shown(sensor.at_rest.mean[axis]),
        shown(sensor.at_rest.sigma[axis]),
        lowest.map_or_else(|| "–".into(), |p| signed(p.deviation, 6)),
        lowest.map_or_else(|| "–".into(), |p| signed(p.tau_s, 1)),
        sensor.unit,
    )
}
