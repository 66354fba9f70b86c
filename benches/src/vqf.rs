//! The peer: VQF for the same readings.
//!
//! VQF estimates orientation and gyroscope bias; the lane's filter also velocity, position,
//! accelerometer bias, their full covariance, and it runs on a constant time grid.

use lodestone_daemon::lane::Conditioner;
use lodestone_daemon::reading::Reading;
use vqf_rs::{Params, VQF};

use crate::readings::Load;

/// A VQF filter that takes a lane's readings.
pub struct VqfLane {
    conditioner: Conditioner,
    filter: VQF,
}

impl Clone for VqfLane {
    fn clone(&self) -> Self {
        let c = self.filter.coeffs();
        let params = Some(*self.filter.params());
        let mut filter = VQF::new(c.gyr_ts, Some(c.acc_ts), Some(c.mag_ts), params);
        *filter.state_mut() = *self.filter.state();
        Self { conditioner: self.conditioner.clone(), filter }
    }
}

impl VqfLane {
    /// A filter with VQF's default parameters at the load's rates.
    pub fn new(load: &Load) -> Self {
        let sample_s = load.rate_hz.recip();
        let fields = load.readings.iter().filter(|r| r.mag.is_some()).count().max(1);
        let field_s = sample_s * load.readings.len() as f64 / fields as f64;
        let filter = VQF::new(sample_s, None, Some(field_s), Some(Params::default()));
        Self { conditioner: load.settings.conditioner.clone(), filter }
    }

    /// Takes one reading; gives the orientation, body to world, as `w x y z`.
    pub fn take(&mut self, reading: &Reading) -> [f64; 4] {
        let sample = self.conditioner.condition(reading);
        let field = sample.mag.map(|m| m.vector.to_array());
        self.filter.update(sample.gyro.vector.to_array(), sample.accel.vector.to_array(), field);
        let q = self.filter.quat_9d();
        [q.0, q.1, q.2, q.3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lodestone_config::model::TrajectoryKind;
    use lodestone_daemon::lane::Core;

    /// A peer that got its samples in the wrong axes would cost the same and mean nothing.
    #[test]
    fn peer_and_lane_see_the_same_camera() {
        let load = Load::synthetic(TrajectoryKind::Walk, 20_000).expect("default world");
        let (mut core, mut peer) = (Core::new(&load.settings), VqfLane::new(&load));
        let mut theirs = [0.0; 4];
        for reading in &load.readings {
            core.take(reading, |_| {});
            theirs = peer.take(reading);
        }
        let ours = core.at_last_reading().expect("aligned").orientation.quaternion();
        let [w, x, y, z] = theirs;
        let between = ours.angle_between(glam::DQuat::from_xyzw(x, y, z, w));
        assert!(between.to_degrees() < 5.0, "{}°", between.to_degrees());
    }
}
