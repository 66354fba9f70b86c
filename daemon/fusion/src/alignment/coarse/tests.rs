use std::vec::Vec;

use super::super::Alignment;
use super::*;
use crate::quantity::Mag;
use crate::testing::{Normal, attitudes};
use crate::time::SensorTime;

const DT: f64 = 0.0025;
const FIELD: DVec3 = DVec3::new(0.0, 20.0, -44.0);

/// A camera that turns at a constant rate and is pushed, in the world, by a constant acceleration.
struct Moving {
    orientation: DQuat,
    rate: DVec3,
    acceleration: DVec3,
    gyro_bias: DVec3,
    steps: i64,
}

impl Moving {
    fn step(&mut self) -> Step {
        let half = self.orientation * so3::exp(self.rate * (0.5 * DT));
        self.orientation = so3::renormalise(self.orientation * so3::exp(self.rate * DT));
        self.steps += 1;
        let body = self.orientation.conjugate();
        Step {
            time: SensorTime::from_nanos(self.steps * 2_500_000),
            increment: Increment {
                span_s: DT,
                angle: (self.rate + self.gyro_bias) * DT,
                velocity: half.conjugate() * (self.acceleration + DVec3::Z * 9.81) * DT,
            },
            mag: (self.steps % 8 == 0).then(|| Mag::new(body * FIELD)),
            bridged: false,
            saturated: false,
        }
    }

    /// The alignment, and how long it took.
    fn align(&mut self, p: &Parameters, seconds: f64) -> Option<(Aligned, f64)> {
        let mut alignment = Alignment::new();
        (0..(seconds / DT) as usize).find_map(|_| {
            alignment.push(&self.step(), p).map(|aligned| (aligned, self.steps as f64 * DT))
        })
    }

    fn error(&self, aligned: &Aligned) -> DVec3 {
        so3::log(self.orientation * aligned.state.orientation().quaternion().conjugate())
    }
}

fn turning(orientation: DQuat) -> Moving {
    let (acceleration, gyro_bias) = (DVec3::ZERO, DVec3::ZERO);
    Moving { orientation, rate: DVec3::new(0.7, -0.4, 0.9), acceleration, gyro_bias, steps: 0 }
}

#[test]
fn a_turning_camera_is_aligned_within_two_seconds() {
    for orientation in attitudes() {
        let mut camera = turning(orientation);
        let (aligned, after_s) = camera.align(&Parameters::default(), 3.0).unwrap();
        assert!(after_s <= 2.0, "{after_s} s");
        assert!(!aligned.at_rest);
        let error = camera.error(&aligned);
        assert!(error.length() < 1e-5, "{error} at {orientation}");
        assert!((aligned.field.unwrap() - FIELD).length() < 0.5);
    }
}

#[test]
fn its_covariance_covers_what_a_push_and_a_bias_do() {
    // Given cameras that are pushed and whose gyroscopes are biased as the parameters expect, when
    // they are aligned in motion, then the errors are those that the covariance expects.
    let p = Parameters::default();
    let mut random = Normal::seeded(5);
    let push = p.alignment.motion_speed_sigma_m_s / 1.8;
    let nees: Vec<f64> = (0..200)
        .map(|_| {
            let mut camera = turning(so3::exp(random.vector(1.5)));
            camera.acceleration = random.vector(push);
            camera.acceleration.z = 0.0;
            camera.gyro_bias = random.vector(p.noise.gyro_bias_sigma);
            let (aligned, _) = camera.align(&p, 3.0).unwrap();
            let error = camera.error(&aligned);
            let covariance = aligned.state.covariance.block(ORIENTATION, ORIENTATION);
            error.dot(covariance.inverse() * error) / 3.0
        })
        .collect();
    let mean = nees.iter().sum::<f64>() / nees.len() as f64;
    assert!((0.4..1.3).contains(&mean), "{mean}");
}

#[test]
fn a_tilt_and_the_heading_that_follows_from_it_are_one_error() {
    let mut camera = turning(DQuat::IDENTITY);
    camera.acceleration = DVec3::new(0.6, 0.0, 0.0);
    let (aligned, _) = camera.align(&Parameters::default(), 3.0).unwrap();
    let error = camera.error(&aligned);
    assert!(error.z.abs() > 0.1, "an eastward push turns the heading where the field dips");
    let p = aligned.state.covariance.block(ORIENTATION, ORIENTATION);
    let expected = p.z_axis.y / p.y_axis.y * error.y;
    assert!((expected - error.z).abs() < 0.02, "{expected} of {}", error.z);
}

#[test]
fn a_force_that_cannot_be_gravity_aligns_nothing() {
    let mut camera = turning(DQuat::IDENTITY);
    camera.acceleration = DVec3::Z * 4.0;
    assert!(camera.align(&Parameters::default(), 10.0).is_none());
}

#[test]
fn where_it_is_not_allowed_it_waits_for_rest() {
    let mut p = Parameters::default();
    p.alignment.motion_s = None;
    assert!(turning(DQuat::IDENTITY).align(&p, 10.0).is_none());
}
