//! What the paper's figures show: angular rate integrated once, acceleration twice, and no filter.
//!
//! All variants start from the same attitude, which the rest gives: up is where the mean acceleration
//! points, north where the mean field does (the paper's one-time initialisation). From there
//! `R ← R Exp(ω Δt)` and `a = R f + g`, integrated by trapezoid: the paper's eqs.
//! `GyroscopeOrientation`, `ResultingAcceleration` and `PositionResultV1` as far as they can be used.

use glam::{DMat3, DQuat, DVec3};
use lodestone_fusion::{Accel, Gyro, ImuSample, LowPass, Rotation, so3};

use super::run::Heard;
use super::track::{Track, TrackPoint};

/// Strength of gravity, m/s², as the paper has it.
const GRAVITY_M_S2: f64 = 9.81;

/// Cut-off of the low-pass, Hz: above what a walker does, below what is only noise.
pub const LOW_PASS_HZ: f64 = 10.0;

/// What is done to the samples before they are integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preparation {
    /// Nothing.
    Raw,
    /// What the rest showed beside gravity is taken off.
    Offset,
    /// The same, and a low-pass of second order.
    OffsetAndLowPass,
}

/// Means over the rest, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rest {
    /// Specific force, m/s².
    accel: DVec3,
    /// Angular rate, rad/s.
    gyro: DVec3,
    /// Field, µT; `None` without a magnetometer.
    mag: Option<DVec3>,
}

impl Rest {
    fn of(samples: &[ImuSample]) -> Self {
        let count = samples.len().max(1) as f64;
        let mean =
            |value: fn(&ImuSample) -> DVec3| samples.iter().map(value).sum::<DVec3>() / count;
        let fields: Vec<DVec3> = samples.iter().filter_map(|s| Some(s.mag?.vector)).collect();
        Self {
            accel: mean(|s| s.accel.vector),
            gyro: mean(|s| s.gyro.vector),
            mag: (!fields.is_empty()).then(|| fields.iter().sum::<DVec3>() / fields.len() as f64),
        }
    }

    /// Body to world: gravity and field (Black 1964, TRIAD). Without a field the camera looks east.
    fn attitude(&self) -> DQuat {
        let up = self.accel.normalize_or(DVec3::Z);
        let ahead = up.cross(DVec3::X).cross(up);
        let east = self.mag.map_or(ahead, |mag| mag.cross(up));
        let east = east.normalize_or(up.any_orthonormal_vector());
        let body_from_world = DMat3::from_cols(east, up.cross(east), up);
        DQuat::from_mat3(&body_from_world.transpose()).normalize()
    }

    /// What the sensors show beside gravity: offsets of gyroscope and accelerometer.
    fn offsets(&self) -> (DVec3, DVec3) {
        let gravity = self.accel.normalize_or(DVec3::Z) * GRAVITY_M_S2;
        (self.gyro, self.accel - gravity)
    }
}

/// Integrates from the end of the rest, with positions from there.
pub fn integrate(heard: &Heard, preparation: Preparation) -> Track {
    let rest = Rest::of(&heard.samples[..heard.begin]);
    let samples = prepared(heard, &rest, preparation);
    let mut strapdown = Strapdown::at_rest(rest.attitude());
    let mut asked = heard.instants.iter().copied().peekable();
    let mut track = Vec::with_capacity(heard.instants.len());
    for k in heard.begin..samples.len() {
        if k > heard.begin {
            strapdown.advance(&samples[k - 1], &samples[k]);
        }
        if asked.next_if_eq(&k).is_some() {
            track.push(TrackPoint {
                time_s: heard.time_s(k),
                position_m: strapdown.position,
                // A product of unit quaternions, each renormalised, is never zero.
                orientation: Rotation::from_quaternion(strapdown.attitude)
                    .unwrap_or(Rotation::IDENTITY),
            });
        }
    }
    Track(track)
}

/// The samples as they are integrated.
fn prepared(heard: &Heard, rest: &Rest, preparation: Preparation) -> Vec<ImuSample> {
    let (gyro, accel) = match preparation {
        Preparation::Raw => (DVec3::ZERO, DVec3::ZERO),
        _ => rest.offsets(),
    };
    let without_offset = |sample: &ImuSample| ImuSample {
        gyro: Gyro::new(sample.gyro.vector - gyro),
        accel: Accel::new(sample.accel.vector - accel),
        ..*sample
    };
    let mut samples: Vec<ImuSample> = heard.samples.iter().map(without_offset).collect();
    if preparation == Preparation::OffsetAndLowPass {
        low_pass(&mut samples, heard.rate_hz);
    }
    samples
}

/// Filters samples in place; those that are too far apart for the cut-off stay as they are.
pub(super) fn low_pass(samples: &mut [ImuSample], rate_hz: f64) {
    let Some(mut filter) = LowPass::new(LOW_PASS_HZ, rate_hz) else { return };
    let mut before = None;
    for sample in samples {
        let span_s = before.map_or(0.0, |before| (sample.time - before).as_secs_f64());
        let missing = ((span_s * rate_hz).round() - 1.0).max(0.0) as u64;
        before = Some(sample.time);
        *sample = filter.filter(sample, missing);
    }
}

/// Attitude, velocity and position in W.
struct Strapdown {
    attitude: DQuat,
    velocity: DVec3,
    position: DVec3,
}

impl Strapdown {
    const fn at_rest(attitude: DQuat) -> Self {
        Self { attitude, velocity: DVec3::ZERO, position: DVec3::ZERO }
    }

    fn advance(&mut self, from: &ImuSample, to: &ImuSample) {
        let span_s = (to.time - from.time).as_secs_f64();
        let acceleration = |attitude: DQuat, sample: &ImuSample| {
            attitude * sample.accel.vector - DVec3::Z * GRAVITY_M_S2
        };
        let before = acceleration(self.attitude, from);
        let turn = 0.5 * (from.gyro.vector + to.gyro.vector) * span_s;
        self.attitude = so3::renormalise(self.attitude * so3::exp(turn));
        let velocity = self.velocity + 0.5 * (before + acceleration(self.attitude, to)) * span_s;
        self.position += 0.5 * (self.velocity + velocity) * span_s;
        self.velocity = velocity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::dynamic::run::Run;
    use crate::evaluation::dynamic::track::{distance_at, orientation_rms_deg};
    use crate::evaluation::dynamic::unit::Unit;
    use crate::evaluation::place::dynamic_scenes;
    use crate::service::signals::StopFlag;
    use lodestone_fusion::{Body, World};

    type Attitude = Rotation<World, Body>;

    /// A run whose sensors have the errors that are asked for.
    fn stairs(noise_scale: f64, gyro_bias: [f64; 3], accel_bias: [f64; 3]) -> Run {
        let mut scene = dynamic_scenes().unwrap().remove(2);
        scene.camera.imu_delay_s = 0.0;
        let synthetic = scene.camera.synthetic.as_mut().unwrap();
        synthetic.errors.noise_scale = noise_scale;
        synthetic.errors.quantise = false;
        synthetic.errors.mag_flicker_ut_rthz = 0.0;
        synthetic.distortion.hard_iron_ut = [0.0; 3];
        synthetic.transport = lodestone_config::model::Transport::default();
        let unit = Unit::with_biases(0, gyro_bias, accel_bias);
        Run::record(&scene, &unit, 1, &StopFlag::new()).unwrap()
    }

    #[test]
    fn perfect_sensors_find_the_way_up_and_down_but_for_the_earths_turn() {
        let run = stairs(0.0, [0.0; 3], [0.0; 3]);
        let errors = integrate(&run.heard, Preparation::Raw).errors(&run.truth);
        let rms = orientation_rms_deg(&errors).unwrap();
        assert!(rms.iter().all(|deg| *deg < 0.3), "{rms:?}");
        // The earth's 73 µrad/s, taken for a turn of the camera, tilts gravity: g Ω t³/6.
        let at_ten = distance_at(&errors, 10.0).unwrap();
        assert!(at_ten < 9.81 * 7.3e-5 * 1000.0 / 6.0 + 0.02, "{at_ten}");
        let errors = integrate(&run.heard, Preparation::Offset).errors(&run.truth);
        assert!(distance_at(&errors, 10.0).unwrap() < 0.05);
    }

    #[test]
    fn an_offset_is_taken_off_and_without_that_it_grows_as_theory_says() {
        let bias = 0.004;
        // Sensor y is left: a pitch rate, which throws gravity forward.
        let run = stairs(0.0, [0.0, bias, 0.0], [0.0; 3]);
        let raw = integrate(&run.heard, Preparation::Raw).errors(&run.truth);
        let corrected = integrate(&run.heard, Preparation::Offset).errors(&run.truth);
        let expected = 9.81 * bias * 5.0_f64.powi(3) / 6.0;
        let found = distance_at(&raw, 5.0).unwrap();
        assert!((found / expected - 1.0).abs() < 0.15, "{found} {expected}");
        assert!(distance_at(&corrected, 5.0).unwrap() < 0.05 * found);
    }

    #[test]
    fn a_low_pass_takes_noise_from_samples() {
        let run = stairs(1.0, [0.0; 3], [0.0; 3]);
        let rest = Rest::of(&run.heard.samples[..run.heard.begin]);
        let spread = |samples: &[ImuSample]| {
            let up = samples[400..run.heard.begin].iter().map(|s| s.accel.vector.z);
            crate::evaluation::statistics::standard_deviation(&up.collect::<Vec<_>>()).unwrap()
        };
        let before = spread(&prepared(&run.heard, &rest, Preparation::Offset));
        let after = spread(&prepared(&run.heard, &rest, Preparation::OffsetAndLowPass));
        // The noise bandwidth of this filter is 1.11 times its cut-off (Butterworth, second order).
        let expected = (1.11 * LOW_PASS_HZ / 200.0).sqrt();
        assert!((after / before / expected - 1.0).abs() < 0.2, "{after} {before} {expected}");
    }

    #[test]
    fn a_rest_gives_the_attitude() {
        let attitude: Attitude = Rotation::from_yaw_pitch_roll(2.0, 0.3, -0.4);
        let seen = |world: DVec3| attitude.inverse().apply(world);
        let mut rest = Rest {
            accel: seen(DVec3::Z * 9.9),
            gyro: DVec3::ZERO,
            mag: Some(seen(DVec3::new(0.0, 21.0, -43.0))),
        };
        let found =
            |rest: &Rest| -> Attitude { Rotation::from_quaternion(rest.attitude()).unwrap() };
        let product = found(&rest).quaternion().dot(attitude.quaternion());
        assert!((product.abs() - 1.0).abs() < 1e-12);
        rest.mag = None;
        let (yaw, pitch, roll) = found(&rest).to_yaw_pitch_roll();
        assert!(yaw.abs() < 1e-9 && (pitch - 0.3).abs() < 1e-9 && (roll + 0.4).abs() < 1e-9);
    }
}
