//! Samples made ready for the fit: in order, finite, with the interval that each one closes.

use glam::DVec3;

use crate::Sample;

/// An interval that is longer than this many usual ones is a gap.
const GAP_INTERVALS: f64 = 3.5;

/// One usable sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// Since the first usable sample, s.
    pub(crate) time_s: f64,
    /// Since the sample before, s.
    pub(crate) dt_s: f64,
    pub(crate) gyro: DVec3,
    pub(crate) accel: DVec3,
    pub(crate) mag: Option<DVec3>,
    /// Away from the reference, K; 0 without a temperature.
    pub(crate) warmer_k: f64,
}

/// All usable samples of a recording.
#[derive(Clone, Debug)]
pub(crate) struct Stream {
    pub(crate) steps: Vec<Step>,
    /// Median interval, s.
    pub(crate) interval_s: f64,
    /// Lowest, highest and mean temperature, °C, where there was any.
    pub(crate) temperature_c: Option<[f64; 3]>,
}

impl Stream {
    /// Takes what is finite and in order.
    pub(crate) fn new(samples: &[Sample]) -> Self {
        let mut steps: Vec<Step> = Vec::with_capacity(samples.len());
        let mut usable = samples.iter().filter(|sample| sample.is_finite()).peekable();
        let first_ns = usable.peek().map_or(0, |sample| sample.time_ns);
        let temperature_c = temperatures(samples);
        let reference_c = temperature_c.map_or(0.0, |t| t[2]);
        let mut last_c = reference_c;
        for sample in usable {
            last_c = sample.temperature_c.unwrap_or(last_c);
            let time_s = sample.time_ns.saturating_sub(first_ns) as f64 * 1e-9;
            let before_s = steps.last().map_or(time_s, |step| step.time_s);
            if steps.is_empty() || time_s > before_s {
                steps.push(Step {
                    time_s,
                    dt_s: time_s - before_s,
                    gyro: sample.gyro_rad_s,
                    accel: sample.accel_m_s2,
                    mag: sample.mag_ut,
                    warmer_k: last_c - reference_c,
                });
            }
        }
        let interval_s = median_interval(&steps);
        Self { steps, interval_s, temperature_c }
    }

    /// From the first to the last usable sample, s.
    pub(crate) fn duration_s(&self) -> f64 {
        self.steps.last().map_or(0.0, |step| step.time_s)
    }

    /// Readings of the magnetometer.
    pub(crate) fn mag_readings(&self) -> usize {
        self.steps.iter().filter(|step| step.mag.is_some()).count()
    }

    /// Whether samples are missing before a step.
    pub(crate) fn is_gap(&self, step: &Step) -> bool {
        step.dt_s > GAP_INTERVALS * self.interval_s
    }
}

fn temperatures(samples: &[Sample]) -> Option<[f64; 3]> {
    let known = || samples.iter().filter(|s| s.is_finite()).filter_map(|s| s.temperature_c);
    let count = known().count();
    let mean = known().sum::<f64>() / count as f64;
    let (low, high) = known().fold((f64::MAX, f64::MIN), |(l, h), t| (l.min(t), h.max(t)));
    (count > 0).then_some([low, high, mean])
}

fn median_interval(steps: &[Step]) -> f64 {
    let mut intervals: Vec<f64> = steps.iter().skip(1).map(|step| step.dt_s).collect();
    if intervals.is_empty() {
        return 0.0;
    }
    let middle = intervals.len() / 2;
    *intervals.select_nth_unstable_by(middle, f64::total_cmp).1
}
