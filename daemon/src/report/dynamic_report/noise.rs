//! The paper's figure "Sensory Ground Truth": acceleration left, angular velocity right.

use super::super::page::{beside, cells, figure, paragraph, table};
use super::super::plot::{Axis, Mark, Plot};
use super::super::scale::{Scale, signed};
use super::Context;
use crate::evaluation::dynamic::noise::{AtRest, Noise};

/// The axes in the paper's colours.
const AXES: [(&str, &str); 3] =
    [("roll", "roll, forward (x)"), ("pitch", "pitch, left (y)"), ("yaw", "yaw, up (z)")];

pub(super) fn markup(noise: &Noise, context: &Context) -> String {
    let charts = chart("acceleration", "m/s²", &noise.acceleration)
        + &chart("angular velocity", "rad/s", &noise.angular_velocity);
    let caption = format!(
        "<b>The paper’s figure “Sensory Ground Truth”.</b> Left acceleration without gravity, right angular \
         velocity, of a camera that stands; the first four seconds of the first run. White line: the \
         mean of the whole recording. {}",
        context.repeat(1)
    );
    paragraph(
        "“In resting state, the linear acceleration and angular velocity exhibit noise and offset \
         behaviours in all directions.”",
    ) + &figure("pair", &charts, &caption)
        + &numbers(noise)
        + &compared(noise)
}

fn chart(name: &str, unit: &str, sensor: &AtRest) -> String {
    let points = &sensor.drawn;
    let end = points.last().map_or(1.0, |(time_s, _)| *time_s);
    let x = Axis::new("time, s", Scale::Linear(0.0, end.ceil()), 4);
    let values = points.iter().flat_map(|(_, value)| value.to_array());
    let y = Axis::new(&format!("{name}, {unit}"), Scale::around(values), 6);
    let legend = AXES.map(|(class, name)| (Mark::Line, class, name));
    let mut plot = Plot::with_legend(name, (520.0, 320.0), 70.0, (&x, &y), &legend);
    for (axis, (class, _)) in AXES.iter().enumerate() {
        let line = points.iter().map(|(time_s, value)| (*time_s, value[axis]));
        plot.line(&format!("thin {class}"), line);
    }
    for offset in sensor.offset {
        plot.line("mean", [(0.0, offset), (end, offset)].into_iter());
    }
    plot.finish()
}

const HEAD: &str = "<tr><th class=\"text\">Sensor</th><th class=\"text\">axis</th><th>offset</th><th>σ of a \
    sample</th><th>σ after the low-pass</th><th>offset / σ</th><th class=\"text\">unit</th></tr>\n";

fn numbers(noise: &Noise) -> String {
    let rows = rows("acceleration", "m/s²", 4, &noise.acceleration)
        + &rows("angular velocity", "rad/s", 5, &noise.angular_velocity);
    table(HEAD, &rows)
}

fn rows(name: &str, unit: &str, decimals: usize, sensor: &AtRest) -> String {
    let row = |(axis, (class, label)): (usize, &(&str, &str))| {
        let (offset, sigma) = (sensor.offset[axis], sensor.sigma[axis]);
        let numbers = [
            signed(offset, decimals),
            signed(sigma, decimals),
            signed(sensor.sigma_low_passed[axis], decimals),
            signed(offset.abs() / sigma, 2),
        ];
        let cells = cells("td", "", numbers);
        format!(
            "<tr><td class=\"text\">{name}</td><td class=\"text {class}\">{label}</td>{cells}\
             <td class=\"text\">{unit}</td></tr>\n"
        )
    };
    AXES.iter().enumerate().map(row).collect()
}

fn compared(noise: &Noise) -> String {
    let mean = |values: [f64; 3]| values.iter().sum::<f64>() / 3.0;
    let quieter = mean(noise.acceleration.sigma) / mean(noise.acceleration.sigma_low_passed);
    beside(
        "Two diagrams, acceleration and angular velocity of a resting ZED 2, noise about an offset in all \
         directions. It prints no values.",
        &format!(
            "The same picture from a simulated ZED 2 over {} s. A low-pass of {} Hz makes the noise {} times \
             smaller and leaves the offset.",
            signed(noise.duration_s, 0),
            signed(noise.low_pass_hz, 0),
            signed(quieter, 1)
        ),
        "The amplitudes are those that the maker states for the ZED 2, not those of the paper’s camera. \
         Gravity is taken off by the true attitude.",
        "The synthetic sensor is white noise, a bias at switch-on that is drawn for each run, its random \
         walk, and the device’s quantisation. So this figure tests the simulation; it says nothing new of a \
         real camera.",
    )
}
