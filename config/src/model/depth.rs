//! A synthetic depth camera.

use serde::{Deserialize, Serialize};

/// What the depth source of a synthetic camera sees of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Depth {
    /// Points in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Clouds per second.
    pub rate_hz: f64,
    /// Horizontal field of view, degrees.
    pub field_of_view_deg: f64,
    /// Standard deviation of depth over the square of depth, 1/m.
    pub sigma_per_m: f64,
    /// Least depth, m.
    pub min_m: f64,
    /// Greatest depth, m.
    pub max_m: f64,
    /// Time from the first row to the last, s; 0: all at once, without point times.
    pub rolling_shutter_s: f64,
    /// Probability that a point has no depth.
    pub drop_probability: f64,
    /// Least angle between ray and surface at which there is depth, degrees.
    pub grazing_deg: f64,
    /// Seed of noise and of lost points.
    pub seed: u64,
}

impl Default for Depth {
    /// 100,000 points at 15 Hz with the noise of a ZED 2.
    ///
    /// Stereo gives `σ_z = z² σ_d / (f b)` (Gallup et al., "Variable Baseline/Resolution Stereo", CVPR
    /// 2008). With the ZED 2's baseline b = 0.12 m, its focal length f = 528 px at 720 rows and
    /// `σ_d` = 0.2 px that is 0.0032 z²; its data sheet's errors, 1 % at 3 m and 5 % at 15 m, are both
    /// 0.0033 z². Its range begins at 0.3 m and ends at 20 m.
    fn default() -> Self {
        Self {
            width: 400,
            height: 250,
            rate_hz: 15.0,
            field_of_view_deg: 90.0,
            sigma_per_m: 0.0032,
            min_m: 0.3,
            max_m: 20.0,
            rolling_shutter_s: 0.01,
            drop_probability: 0.01,
            grazing_deg: 8.0,
            seed: 0,
        }
    }
}
