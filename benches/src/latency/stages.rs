//! The stages of one pose, and their quantiles.

use std::str::FromStr;

use lodestone_schema::Pose;

use crate::ledger::quantile;

/// Names of the stages, in order; the last is the whole way.
pub const STAGES: [&str; 5] = [
    "arrival -> step start",
    "step start -> step end",
    "step end -> published",
    "published -> seen",
    "arrival -> seen",
];

/// One pose's stages, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stages(pub [i64; 5]);

impl Stages {
    /// The stages of a pose that was seen at a time on `CLOCK_MONOTONIC`, ns.
    pub const fn of(pose: &Pose, seen_ns: i64) -> Self {
        Self([
            pose.step_start_time_ns - pose.arrival_time_ns,
            pose.step_end_time_ns - pose.step_start_time_ns,
            pose.published_time_ns - pose.step_end_time_ns,
            seen_ns - pose.published_time_ns,
            seen_ns - pose.arrival_time_ns,
        ])
    }
}

impl std::fmt::Display for Stages {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c, d, e] = self.0;
        write!(out, "{a} {b} {c} {d} {e}")
    }
}

impl FromStr for Stages {
    type Err = String;

    fn from_str(line: &str) -> Result<Self, String> {
        let numbers: Result<Vec<i64>, _> = line.split(' ').map(str::parse).collect();
        let numbers = numbers.map_err(|e| format!("{line:?}: {e}"))?;
        let stages =
            numbers.try_into().map_err(|_| format!("{line:?}: not {} numbers", STAGES.len()))?;
        Ok(Self(stages))
    }
}

/// Median, 99th percentile and largest, µs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantiles {
    /// Median.
    pub p50_us: f64,
    /// 99th percentile.
    pub p99_us: f64,
    /// Largest.
    pub max_us: f64,
}

impl Quantiles {
    /// Of one stage over many poses.
    pub fn of(poses: &[Stages], stage: usize) -> Self {
        let us: Vec<f64> = poses.iter().map(|s| s.0[stage] as f64 * 1e-3).collect();
        let at = |p| quantile(&us, p);
        Self { p50_us: at(0.5), p99_us: at(0.99), max_us: at(1.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_survive_the_way_through_text() {
        let stages = Stages([1, -2, 3, 4, 500]);
        assert_eq!(stages.to_string().parse(), Ok(stages));
        assert!("1 2 3".parse::<Stages>().is_err());
    }
}
