//! From samples at uneven times to increments on a constant time grid.
//!
//! A sample is taken for the mean over the interval that ends at its time stamp, as sensors with a
//! digital low-pass filter deliver it; over lost samples the values run straight. Their integrals
//! over each grid step are exact for that. Jitter of the samples therefore neither stretches nor
//! loses rotation, and the filter always advances by the same span.
//!
//! A step is complete when a sample at or after its end has come, so the grid adds less than one
//! sample interval of delay. [`Grid::remainder`] holds what lies beyond the last step.

use glam::DVec3;

use crate::frame::Body;
use crate::low_pass::LowPass;
use crate::quantity::Mag;
use crate::sample::ImuSample;
use crate::so3;
use crate::time::{SensorSpan, SensorTime};

/// Limits of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridParameters {
    /// Length of a step.
    pub step: SensorSpan,
    /// Usual distance between two samples; more than one and a half of it means samples are lost.
    pub sample_interval: SensorSpan,
    /// Longest distance that is bridged by interpolation; beyond, the grid starts anew.
    pub bridge_limit: SensorSpan,
    /// Whether steps end at whole multiples of a step on the clock, so that the grids of several sensors
    /// on one clock coincide; a first step that is not whole is left out. Default false.
    pub aligned: bool,
    /// Largest believable angular rate per axis, rad/s.
    pub max_rate_rad_s: f64,
    /// Largest believable specific force per axis, m/s².
    pub max_specific_force_m_s2: f64,
    /// Largest believable magnetic field per axis, µT.
    pub max_field_ut: f64,
}

impl GridParameters {
    /// A grid with steps and samples at one nominal rate, and limits wide enough for any IMU.
    pub fn at_rate(rate_hz: f64) -> Self {
        let interval = SensorSpan::from_secs_f64(1.0 / rate_hz);
        Self {
            step: interval,
            sample_interval: interval,
            bridge_limit: SensorSpan::from_nanos(100_000_000),
            aligned: false,
            max_rate_rad_s: 100.0,
            max_specific_force_m_s2: 1000.0,
            max_field_ut: 5000.0,
        }
    }
}

/// An angle and a velocity gained over a span, in the body frame at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Length, s.
    pub span_s: f64,
    /// Integral of the angular rate, rad.
    pub angle: DVec3,
    /// Integral of the specific force, m/s.
    pub velocity: DVec3,
}

impl Increment {
    /// Nothing gained over no time.
    pub const ZERO: Self = Self { span_s: 0.0, angle: DVec3::ZERO, velocity: DVec3::ZERO };

    fn add(&mut self, span_s: f64, rate: DVec3, force: DVec3) {
        self.span_s += span_s;
        self.angle += rate * span_s;
        self.velocity += force * span_s;
    }
}

/// One step of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The step's end.
    pub time: SensorTime,
    /// What was gained since the step before.
    pub increment: Increment,
    /// The magnetic field that arrived during the step, turned to the body frame at its end.
    pub mag: Option<Mag<Body>>,
    /// Samples were lost within this step; it rests on interpolation.
    pub bridged: bool,
    /// A sensor was at the end of its range.
    pub saturated: bool,
}

/// Why a sample was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// A value is NaN or infinite.
    #[error("a value is not finite")]
    NotFinite,
    /// A value is finite but no sensor can measure it, or the time stamp is the clock's very last.
    #[error("a value is larger than any sensor measures")]
    OutOfRange,
    /// The time stamp is that of the sample before.
    #[error("the time stamp repeats")]
    Duplicate,
    /// The time stamp lies before that of the sample before.
    #[error("the time stamp runs backwards")]
    OutOfOrder,
}

/// What taking a sample meant for the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accepted {
    /// The grid begins here.
    First,
    /// The sample continues the stream; `lost` samples are missing before it and were bridged.
    Continued {
        /// Number of missing samples.
        lost: u64,
    },
    /// Too long a gap to bridge: the grid begins anew here.
    Gap {
        /// Length of the gap.
        span: SensorSpan,
        /// Number of missing samples.
        lost: u64,
    },
}

/// A magnetometer reading with the turn that the open step had made when it was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PendingMag {
    field: DVec3,
    angle: DVec3,
}

/// The stretch between two samples, partly consumed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Segment {
    from: SensorTime,
    to: SensorTime,
    rate: [DVec3; 2],
    force: [DVec3; 2],
    consumed_to: SensorTime,
    mag: Option<DVec3>,
    bridged: bool,
    saturated: bool,
}

/// The step that is being filled.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OpenStep {
    increment: Increment,
    bridged: bool,
    saturated: bool,
}

impl OpenStep {
    const NEW: Self = Self { increment: Increment::ZERO, bridged: false, saturated: false };

    /// Takes what lies up to a time of the rest of a stretch.
    fn consume(&mut self, segment: &mut Segment, to: SensorTime) {
        let from = segment.consumed_to;
        if from == to {
            // Used up: what is known of this line says nothing of the step that begins at its end.
            return;
        }
        let mut rate = segment.rate[1];
        let mut force = segment.force[1];
        if segment.bridged {
            // The mean of a straight line over a span is its value in the middle.
            let into_s = |time: SensorTime| (time - segment.from).as_secs_f64();
            let middle = 0.5 * (into_s(from) + into_s(to)) / into_s(segment.to);
            rate = segment.rate[0] + (rate - segment.rate[0]) * middle;
            force = segment.force[0] + (force - segment.force[0]) * middle;
        }
        self.increment.add((to - from).as_secs_f64(), rate, force);
        self.bridged |= segment.bridged;
        self.saturated |= segment.saturated;
        segment.consumed_to = to;
    }
}

/// The state of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    parameters: GridParameters,
    last: Option<ImuSample>,
    segment: Option<Segment>,
    step_end: SensorTime,
    /// The open step did not begin at its begin.
    partial: bool,
    open: OpenStep,
    pending_mag: Option<PendingMag>,
    low_pass: Option<LowPass>,
}

impl Grid {
    /// An empty grid.
    pub const fn new(parameters: GridParameters) -> Self {
        Self {
            parameters,
            last: None,
            segment: None,
            step_end: SensorTime::from_nanos(0),
            partial: false,
            open: OpenStep::NEW,
            pending_mag: None,
            low_pass: None,
        }
    }

    /// The same grid with a low-pass on the samples that it takes.
    #[must_use]
    pub const fn with_low_pass(self, low_pass: Option<LowPass>) -> Self {
        Self { low_pass, ..self }
    }

    /// Takes the next sample. Afterwards call [`Grid::next_step`] until it gives nothing.
    ///
    /// # Errors
    /// [`Refusal`] if the sample cannot be used; the grid is as before.
    pub fn push(&mut self, sample: ImuSample) -> Result<Accepted, Refusal> {
        self.screen(&sample)?;
        let Some(last) = self.last else {
            self.begin(sample);
            return Ok(Accepted::First);
        };
        let span = sample.time - last.time;
        if span.as_nanos() == 0 {
            return Err(Refusal::Duplicate);
        }
        if span.as_nanos() < 0 {
            return Err(Refusal::OutOfOrder);
        }
        let lost = self.missing_within(span);
        if span > self.parameters.bridge_limit {
            self.begin(sample);
            return Ok(Accepted::Gap { span, lost });
        }
        let sample = self.low_pass.as_mut().map_or(sample, |filter| filter.filter(&sample, lost));
        self.segment = Some(Segment {
            from: last.time,
            to: sample.time,
            rate: [last.gyro.vector, sample.gyro.vector],
            force: [last.accel.vector, sample.accel.vector],
            consumed_to: last.time,
            mag: sample.mag.map(|m| m.vector),
            bridged: lost > 0,
            saturated: last.saturated || sample.saturated,
        });
        self.last = Some(sample);
        Ok(Accepted::Continued { lost })
    }

    /// The next completed step, if there is one.
    pub fn next_step(&mut self) -> Option<Step> {
        let segment = self.segment.as_mut()?;
        self.open.consume(segment, segment.to.min(self.step_end));
        if segment.to <= self.step_end
            && let Some(field) = segment.mag.take()
        {
            self.pending_mag = Some(PendingMag { field, angle: self.open.increment.angle });
        }
        if segment.to < self.step_end {
            self.segment = None;
            return None;
        }
        if core::mem::take(&mut self.partial) {
            self.close_step();
            return self.next_step();
        }
        Some(self.close_step())
    }

    /// What was gained between the end of the last step and the last sample.
    pub const fn remainder(&self) -> Increment {
        self.open.increment
    }

    /// The latest sample taken.
    pub const fn last_sample(&self) -> Option<&ImuSample> {
        self.last.as_ref()
    }

    /// Forgets everything; the next sample begins a new grid.
    pub fn reset(&mut self) {
        if let Some(filter) = &mut self.low_pass {
            filter.reset();
        }
        *self = Self::new(self.parameters).with_low_pass(self.low_pass);
    }

    fn screen(&self, sample: &ImuSample) -> Result<(), Refusal> {
        let within = |v: DVec3, limit: f64| v.abs().max_element() <= limit;
        let mag = sample.mag.map_or(DVec3::ZERO, |m| m.vector);
        let all = [sample.gyro.vector, sample.accel.vector, mag];
        if !all.iter().all(|v| v.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let p = &self.parameters;
        let limits = [p.max_rate_rad_s, p.max_specific_force_m_s2, p.max_field_ut];
        let good = all.iter().zip(limits).all(|(v, limit)| within(*v, limit));
        // The next step must end on the clock too, or the grid would stand still there for ever.
        let on_clock = sample.time.as_nanos() <= i64::MAX - p.step.as_nanos();
        (good && on_clock).then_some(()).ok_or(Refusal::OutOfRange)
    }

    fn begin(&mut self, sample: ImuSample) {
        self.reset();
        let sample = self.low_pass.as_mut().map_or(sample, |filter| filter.filter(&sample, 0));
        self.step_end = sample.time + self.first_span(sample.time);
        self.partial = self.step_end - sample.time != self.parameters.step;
        self.pending_mag = sample.mag.map(|m| PendingMag { field: m.vector, angle: DVec3::ZERO });
        self.last = Some(sample);
    }

    /// From the grid's first sample to the end of its first step.
    fn first_span(&self, begin: SensorTime) -> SensorSpan {
        let step = self.parameters.step;
        if !self.parameters.aligned {
            return step;
        }
        let into = begin.as_nanos().rem_euclid(step.as_nanos().max(1));
        SensorSpan::from_nanos(step.as_nanos() - into)
    }

    fn missing_within(&self, span: SensorSpan) -> u64 {
        let interval = self.parameters.sample_interval.as_nanos().max(1);
        // Rounded, so that jitter below half an interval counts as nothing lost.
        let intervals = (span.as_nanos().saturating_add(interval / 2)) / interval;
        u64::try_from(intervals - 1).unwrap_or(0)
    }

    fn close_step(&mut self) -> Step {
        let open = core::mem::replace(&mut self.open, OpenStep::NEW);
        let turned = |m: PendingMag| so3::exp(m.angle - open.increment.angle) * m.field;
        let step = Step {
            time: self.step_end,
            increment: open.increment,
            mag: self.pending_mag.take().map(|m| Mag::new(turned(m))),
            bridged: open.bridged,
            saturated: open.saturated,
        };
        self.step_end = self.step_end + self.parameters.step;
        step
    }
}

#[cfg(test)]
mod tests;
