//! How far each method has drifted after some time, over many runs.

use serde::Serialize;

use super::method::Method;
use super::track::{PoseError, distance_at};
use crate::evaluation::statistics::Quantiles;

/// Times of the table, s after the rest.
pub const TABLE_S: [f64; 5] = [1.0, 5.0, 10.0, 30.0, 60.0];

/// Position errors in one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Drift {
    /// Name of the scene.
    pub scene: String,
    /// Runs behind every figure.
    pub runs: u32,
    /// Each method's, in the order of [`Method::ALL`].
    pub methods: Vec<MethodDrift>,
}

/// Position errors of one method.
#[derive(Clone, Debug, Serialize)]
pub struct MethodDrift {
    /// The method.
    pub method: Method,
    /// At the times of the table.
    pub table: Vec<DriftPoint>,
    /// At times that lie evenly in ratio, for the figure.
    pub curve: Vec<DriftPoint>,
}

/// The position's error at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DriftPoint {
    /// Time since the end of the rest, s.
    pub time_s: f64,
    /// Length of the error over the runs, m.
    pub error_m: Quantiles,
}

impl Drift {
    /// The drift of one scene from the errors of its runs, each with one list for each method.
    pub fn of(scene: &str, runs: &[Vec<Vec<PoseError>>]) -> Self {
        let methods = Method::ALL.iter().enumerate();
        let of_method = |(index, &method): (usize, &Method)| {
            let errors: Vec<&[PoseError]> = runs.iter().map(|run| run[index].as_slice()).collect();
            MethodDrift {
                method,
                table: TABLE_S.iter().filter_map(|&at| point(&errors, at)).collect(),
                curve: curve_times().filter_map(|at| point(&errors, at)).collect(),
            }
        };
        Self {
            scene: scene.into(),
            runs: runs.len() as u32,
            methods: methods.map(of_method).collect(),
        }
    }

    /// Whether the paper's sentence holds after a time of the table: raw is worst, taking off the offset
    /// helps, and Lodestone's filter helps further.
    pub fn order_holds(&self, time_s: f64) -> bool {
        let at = |method| self.of_method(method).and_then(|drift| drift.median_at(time_s));
        let errors = [Method::Raw, Method::OffsetCorrected, Method::Lodestone].map(at);
        matches!(errors, [Some(raw), Some(corrected), Some(ours)] if raw > corrected && corrected > ours)
    }

    /// A method's drift.
    pub fn of_method(&self, method: Method) -> Option<&MethodDrift> {
        self.methods.iter().find(|drift| drift.method == method)
    }
}

impl MethodDrift {
    /// The median error at a time of the table, m.
    pub fn median_at(&self, time_s: f64) -> Option<f64> {
        let point = self.table.iter().find(|point| point.time_s.to_bits() == time_s.to_bits())?;
        Some(point.error_m.median)
    }
}

/// `None` unless every run is that long.
fn point(runs: &[&[PoseError]], time_s: f64) -> Option<DriftPoint> {
    let errors: Option<Vec<f64>> = runs.iter().map(|errors| distance_at(errors, time_s)).collect();
    Some(DriftPoint { time_s, error_m: Quantiles::of(errors?)? })
}

/// From a quarter of a second to a minute, 18 to the decade.
fn curve_times() -> impl Iterator<Item = f64> {
    const PER_DECADE: f64 = 18.0;
    let last = (60.0_f64 / 0.25).log10() * PER_DECADE;
    (0..=last.floor() as u32).map(|k| 0.25 * 10.0_f64.powf(f64::from(k) / PER_DECADE)).chain([60.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A run that is off by `slope` metres a second, the same for every method.
    fn run(slope: f64) -> Vec<Vec<PoseError>> {
        let error = |k: u32| PoseError {
            time_s: f64::from(k) * 0.025,
            position_m: DVec3::Y * slope * f64::from(k) * 0.025,
            roll_pitch_yaw_deg: [0.0; 3],
        };
        vec![(0..=2400).map(error).collect(); Method::ALL.len()]
    }

    #[test]
    fn each_time_has_the_median_of_its_runs() {
        let drift = Drift::of("a", &[run(1.0), run(3.0), run(20.0)]);
        let raw = drift.of_method(Method::Raw).unwrap();
        assert_eq!(raw.table.len(), TABLE_S.len());
        assert!((raw.median_at(10.0).unwrap() - 30.0).abs() < 1e-9);
        assert!(!drift.order_holds(10.0), "all are alike");
        assert!(raw.curve.windows(2).all(|w| w[0].time_s < w[1].time_s));
        assert!(raw.curve.iter().all(|p| (p.error_m.median / p.time_s - 3.0).abs() < 0.2));
    }

    #[test]
    fn a_time_that_not_all_runs_reach_has_no_figure() {
        let mut short = run(1.0);
        for errors in &mut short {
            errors.truncate(500);
        }
        let drift = Drift::of("a", &[run(1.0), short]);
        assert_eq!(drift.methods[0].table.len(), 3);
    }
}
