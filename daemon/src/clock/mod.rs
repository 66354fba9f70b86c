//! Sensor time to host time.
//!
//! A sample taken at sensor time `t` arrives at `a = offset + (rate + drift)·t + delay` with a
//! delay that is never negative and now and then close to its least. So the clock's line is the
//! one that passes below all arrivals and as close to them as it can: the lower envelope of Moon,
//! Skelly and Towsley, "Estimation and removal of clock skew from network delay measurements"
//! (INFOCOM 1999). A burst of late arrivals lies above the line and does not move it.
//!
//! The least delay cannot be told from the offset and stays in it: a mapped time is the earliest
//! the sample could have arrived, not when it was taken.

mod envelope;
#[cfg(test)]
mod tests;
mod unix;

use envelope::{Envelope, Line};
use lodestone_fusion::{SensorSpan, SensorTime};
pub use unix::{UnixOffset, unix_offset_ns};

use crate::reading::HostTime;

/// Most that sensor and host may differ in rate, beside the nominal one; a larger slope is taken for
/// a change of delay. MEMS sensors state 1 to 2 %.
pub const MAX_DRIFT: f64 = 0.03;

/// How fast corrections are worked into mapped times, seconds per second.
pub const SLEW_RATE: f64 = 0.005;

/// Correction towards later times beyond which there is no point in slewing, ns.
const STEP_NS: f64 = 100e6;

/// Arrival this much before the line: no delay explains it, one of the clocks was set. ns.
const RESTART_BELOW_NS: f64 = 10e6;

/// Sensor time this much behind the newest: the sensor's clock was set. ns.
const RESTART_BACK_NS: i64 = 1_000_000_000;

/// Rounds in which the line is inverted: its slope is a few hundredths at most, and each round leaves that
/// part of the error before.
const INVERSE_ROUNDS: usize = 6;

/// Maps one sensor's clock to the host's, learning offset and drift from arrivals.
///
/// Calls no clock and allocates nothing. UNIX time plays no part, so setting it changes nothing.
#[derive(Clone, Debug)]
pub struct SensorClock {
    /// Host seconds per sensor second, drift aside.
    nominal_rate: f64,
    state: Option<State>,
    last_mapped: HostTime,
}

/// What was learnt since the last start.
#[derive(Clone, Debug)]
struct State {
    epoch: u32,
    /// Where both coordinates below are zero.
    origin: (SensorTime, HostTime),
    newest: (SensorTime, HostTime),
    envelope: Envelope,
    /// Where corrections go.
    target: Line,
    /// What maps now; follows the target.
    applied: Line,
}

impl Default for SensorClock {
    fn default() -> Self {
        Self::new(1.0)
    }
}

impl SensorClock {
    /// A clock of which nothing is known but the host seconds that pass in one sensor second: 1
    /// for a device, 1/n for a recording played n times as fast.
    pub fn new(nominal_rate: f64) -> Self {
        Self { nominal_rate, state: None, last_mapped: HostTime::from_nanos(i64::MIN) }
    }

    /// Learns from the arrival of a sample.
    ///
    /// Usable after the first one. A new `epoch`, a sensor time more than 1 s behind the newest
    /// and an arrival 10 ms before the earliest possible begin anew; mapped times still do not
    /// step back. A sample that is older than the newest by less teaches nothing.
    pub fn observe(&mut self, taken: SensorTime, arrival: HostTime, epoch: u32) {
        let nominal_rate = self.nominal_rate;
        match &mut self.state {
            Some(state) if state.epoch == epoch && !state.was_set_back(taken) => {
                state.observe(taken, arrival, nominal_rate);
            }
            state => *state = Some(State::new(taken, arrival, epoch, Line::default())),
        }
    }

    /// The host time of a sensor time; `None` before the first arrival.
    ///
    /// Never decreases from call to call, so calls go in order of time. For the newest sample and
    /// all before it, it is at most the newest arrival (as long as arrivals themselves do not go
    /// backwards); beyond, it extrapolates.
    pub fn host_time(&mut self, taken: SensorTime) -> Option<HostTime> {
        let state = self.state.as_ref()?;
        self.last_mapped = self.last_mapped.max(state.map(taken, self.nominal_rate));
        Some(self.last_mapped)
    }

    /// The sensor time of a host time, by the line as it is now; `None` before the first arrival.
    ///
    /// The opposite of [`SensorClock::host_time`] but for what that one does to keep its times in order.
    pub fn sensor_time(&self, at: HostTime) -> Option<SensorTime> {
        let state = self.state.as_ref()?;
        let mut taken = state.newest.0;
        for _ in 0..INVERSE_ROUNDS {
            let ahead_ns = at.as_nanos().saturating_sub(state.line(taken, self.nominal_rate));
            let span_s = ahead_ns as f64 * 1e-9 / self.nominal_rate;
            taken = taken + SensorSpan::from_secs_f64(span_s);
        }
        Some(taken)
    }

    /// Host seconds per sensor second over the nominal ones, minus one; 0 until it is known.
    pub fn drift(&self) -> f64 {
        self.state.as_ref().map_or(0.0, |state| state.target.slope / self.nominal_rate)
    }

    /// Mapped time minus what the envelope says now, s: the correction still to be slewed.
    pub fn pending_correction_s(&self) -> f64 {
        self.state.as_ref().map_or(0.0, |state| {
            let x = state.applied.x;
            (state.applied.y - state.target.at(x)) * 1e-9
        })
    }
}

impl State {
    fn new(taken: SensorTime, arrival: HostTime, epoch: u32, drift: Line) -> Self {
        let line = Line { x: 0.0, y: 0.0, slope: drift.slope };
        let mut envelope = Envelope::default();
        envelope.add(0.0, 0.0, line);
        let at = (taken, arrival);
        Self { epoch, origin: at, newest: at, envelope, target: line, applied: line }
    }

    fn was_set_back(&self, taken: SensorTime) -> bool {
        (taken - self.newest.0).as_nanos() < -RESTART_BACK_NS
    }

    fn observe(&mut self, taken: SensorTime, arrival: HostTime, nominal_rate: f64) {
        if taken < self.newest.0 {
            return;
        }
        let x = self.x(taken);
        let y = self.nominal(taken, nominal_rate).nanos_until(arrival);
        if y < self.target.at(x) - RESTART_BELOW_NS {
            *self = Self::new(taken, arrival, self.epoch, self.target);
            return;
        }
        self.newest = (taken, arrival);
        if let Some(line) = self.envelope.add(x, y, self.target) {
            // A slope that no clock has comes from delays: the one known before is kept.
            let possible = line.slope.abs() <= MAX_DRIFT * nominal_rate;
            let kept = self.target.slope;
            self.target = if possible { line } else { self.envelope.line_of_slope(kept) };
        }
        self.target.lower_to(x, y);
        self.slew(x, nominal_rate);
        self.applied.lower_to(x, y);
    }

    /// Moves the applied line to `x` and towards the target.
    fn slew(&mut self, x: f64, nominal_rate: f64) {
        let carried = self.applied.at(x);
        let correction = self.target.at(x) - carried;
        let most = SLEW_RATE * nominal_rate * (x - self.applied.x);
        let step = if correction > STEP_NS { correction } else { correction.clamp(-most, most) };
        self.applied = Line { x, y: carried + step, slope: self.target.slope };
    }

    /// Where the applied line puts a sensor time, ns of the host.
    fn line(&self, taken: SensorTime, nominal_rate: f64) -> i64 {
        let nominal = self.nominal(taken, nominal_rate).as_nanos();
        nominal.saturating_add(self.applied.at(self.x(taken)).round() as i64)
    }

    fn map(&self, taken: SensorTime, nominal_rate: f64) -> HostTime {
        let mapped = HostTime::from_nanos(self.line(taken, nominal_rate));
        if taken <= self.newest.0 { mapped.min(self.newest.1) } else { mapped }
    }

    /// ns of sensor time since the origin.
    fn x(&self, taken: SensorTime) -> f64 {
        (taken - self.origin.0).as_nanos() as f64
    }

    /// Where the nominal rate alone would put a sensor time; exact for a rate of 1.
    fn nominal(&self, taken: SensorTime, nominal_rate: f64) -> HostTime {
        let span = (taken - self.origin.0).as_nanos();
        #[allow(clippy::float_cmp, reason = "a device's rate is set to 1, not computed")]
        let scaled =
            if nominal_rate == 1.0 { span } else { (span as f64 * nominal_rate).round() as i64 };
        HostTime::from_nanos(self.origin.1.as_nanos().saturating_add(scaled))
    }
}

impl HostTime {
    fn nanos_until(self, later: Self) -> f64 {
        later.as_nanos().saturating_sub(self.as_nanos()) as f64
    }
}
