//! The recording cut at knots, each piece with its gyroscope integrated from the knot on.

use std::ops::Range;

use glam::{DMat3, DVec3};
use lodestone_fusion::so3;

use super::parameters::{Globals, Knot, SCALE};
use crate::stream::{Step, Stream};

/// Between knots, s. Within, the gyroscope's noise is neglected; it enters from knot to knot.
const KNOT_SPACING_S: f64 = 1.0;
/// Readings of this long are averaged, each turned on its own, s.
const BIN_S: f64 = 0.1;

/// From one knot to the next one.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    /// Samples, the first one at the knot.
    pub(crate) samples: Range<usize>,
    /// The same, in short groups.
    pub(crate) bins: Vec<Range<usize>>,
    /// Mean temperature above the reference, K.
    pub(crate) warmer_k: f64,
    /// To the next knot, s; 0 for the last one.
    pub(crate) duration_s: f64,
    /// Of that, without samples, s.
    pub(crate) gap_s: f64,
}

/// Cuts a stream: a knot each second, and on both sides of each gap.
pub(crate) fn cut(stream: &Stream) -> Vec<Segment> {
    let steps = &stream.steps;
    let mut segments = Vec::new();
    let mut start = 0;
    for i in 1..=steps.len() {
        let ends = i == steps.len()
            || steps[i].time_s - steps[start].time_s >= KNOT_SPACING_S
            || stream.is_gap(&steps[i])
            || i + 1 < steps.len() && stream.is_gap(&steps[i + 1]);
        if ends {
            segments.push(segment(stream, start..i));
            start = i;
        }
    }
    segments
}

fn segment(stream: &Stream, samples: Range<usize>) -> Segment {
    let steps = &stream.steps;
    let begin_s = steps[samples.start].time_s;
    let next = steps.get(samples.end);
    let gap = next.filter(|next| stream.is_gap(next));
    Segment {
        bins: bins(steps, samples.clone()),
        warmer_k: mean(&steps[samples.clone()], |step| step.warmer_k),
        duration_s: next.map_or(0.0, |next| next.time_s - begin_s),
        gap_s: gap.map_or(0.0, |next| next.dt_s),
        samples,
    }
}

fn bins(steps: &[Step], samples: Range<usize>) -> Vec<Range<usize>> {
    let mut bins = Vec::new();
    let mut start = samples.start;
    for i in samples.start + 1..=samples.end {
        if i == samples.end || steps[i].time_s - steps[start].time_s >= BIN_S - 1e-9 {
            bins.push(start..i);
            start = i;
        }
    }
    bins
}

fn mean(steps: &[Step], value: impl Fn(&Step) -> f64) -> f64 {
    steps.iter().map(value).sum::<f64>() / steps.len() as f64
}

/// Rotation since a knot, and how it answers to what is estimated: `ΔR Exp(J δ)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn {
    /// Sensor now to sensor at the knot, `ΔR`.
    pub(crate) rotation: DMat3,
    /// `J` for the bias.
    pub(crate) by_bias: DMat3,
    /// `J` for the errors of scale.
    pub(crate) by_scale: DMat3,
    /// Rate now, corrected, rad/s.
    pub(crate) rate: DVec3,
}

/// Integrates the gyroscope with one bias and scale.
pub(crate) struct Integrator {
    turn: Turn,
    bias: DVec3,
    scale: DVec3,
}

impl Integrator {
    /// At a knot.
    pub(crate) fn new(globals: &Globals, knot: &Knot, segment: &Segment) -> Self {
        let turn = Turn {
            rotation: DMat3::IDENTITY,
            by_bias: DMat3::ZERO,
            by_scale: DMat3::ZERO,
            rate: DVec3::ZERO,
        };
        let bias = globals.gyro_bias(segment.warmer_k) + knot.bias;
        Self { turn, bias, scale: globals.vector(SCALE) }
    }

    /// The rotation to the knot's own sample.
    pub(crate) fn at_knot(&mut self, step: &Step) -> &Turn {
        self.turn.rate = self.corrected(step.gyro);
        &self.turn
    }

    /// Goes on by one interval (Forster et al., TRO 2017, eqs. 35 and 44, with the sign of Lodestone's
    /// bias).
    pub(crate) fn step(&mut self, step: &Step) -> &Turn {
        let rate = self.corrected(step.gyro);
        let angle = rate * step.dt_s;
        let part = DMat3::from_quat(so3::exp(angle));
        let back = part.transpose();
        let right = right_jacobian(angle) * step.dt_s;
        let turn = &mut self.turn;
        turn.rotation *= part;
        turn.by_bias = back * turn.by_bias - right;
        turn.by_scale = back * turn.by_scale + right * DMat3::from_diagonal(step.gyro);
        turn.rate = rate;
        &self.turn
    }

    fn corrected(&self, gyro: DVec3) -> DVec3 {
        gyro + gyro * self.scale - self.bias
    }
}

/// `Exp(θ + δ) = Exp(θ) Exp(J δ)` (Solà, eq. 143), to the fourth order: an interval turns little.
fn right_jacobian(angle: DVec3) -> DMat3 {
    let cross = so3::skew(angle);
    DMat3::IDENTITY - cross * 0.5 + cross * cross * (1.0 / 6.0)
        - cross * cross * cross * (1.0 / 24.0)
}
