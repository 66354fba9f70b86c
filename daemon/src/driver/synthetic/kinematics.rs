//! From a trajectory to what an inertial sensor in it feels.

use std::sync::Arc;

use glam::DVec3;
use lodestone_fusion::{Body, Rotation, World};

use super::trajectory::{PoseJet, Trajectory};

/// Gravity (with the centrifugal part), m/s²; the paper's value, see maths.md.
const GRAVITY_M_S2: f64 = 9.81;
/// Rotation of the earth against inertial space, rad/s (WGS 84).
const EARTH_RATE_RAD_S: f64 = 7.292_115e-5;

/// The exact motion of a body at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    /// Position in W, m.
    pub(crate) position: DVec3,
    /// Velocity in W, m/s.
    pub(crate) velocity: DVec3,
    /// Acceleration in W, m/s².
    pub(crate) acceleration: DVec3,
    /// Body to world.
    pub(crate) orientation: Rotation<World, Body>,
    /// Angular rate of the body against W, in the body frame, rad/s.
    pub(crate) rate: DVec3,
}

impl Motion {
    fn of(pose: &PoseJet, origin: DVec3) -> Self {
        let [x, y, z] = pose.position;
        Self {
            position: DVec3::new(x.value, y.value, z.value) - origin,
            velocity: DVec3::new(x.first, y.first, z.first),
            acceleration: DVec3::new(x.second, y.second, z.second),
            orientation: Rotation::from_yaw_pitch_roll(
                pose.yaw.value,
                pose.pitch.value,
                pose.roll.value,
            ),
            rate: body_rate(pose),
        }
    }
}

impl Motion {
    /// The motion of a seat on a body whose motion this is, with the body's angular acceleration,
    /// rad/s².
    fn of_seat(&self, seat: &Seat, swing: DVec3) -> Self {
        let turning = self.rate.cross(seat.position);
        let arm = |v: DVec3| self.orientation.apply(v);
        Self {
            position: self.position + arm(seat.position),
            velocity: self.velocity + arm(turning),
            acceleration: self.acceleration
                + arm(swing.cross(seat.position) + self.rate.cross(turning)),
            orientation: self.orientation * seat.rotation,
            rate: seat.rotation.inverse().apply(self.rate),
        }
    }
}

/// Angular rate in the body frame from the rates of the ZYX Euler angles, rad/s (Titterton and
/// Weston, Strapdown Inertial Navigation Technology, 2nd edition, §3.6.3.3, inverted).
fn body_rate(pose: &PoseJet) -> DVec3 {
    let (sin_pitch, cos_pitch) = pose.pitch.value.sin_cos();
    let (sin_roll, cos_roll) = pose.roll.value.sin_cos();
    let (yaw, pitch, roll) = (pose.yaw.first, pose.pitch.first, pose.roll.first);
    DVec3::new(
        roll - yaw * sin_pitch,
        pitch * cos_roll + yaw * cos_pitch * sin_roll,
        yaw * cos_pitch * cos_roll - pitch * sin_roll,
    )
}

/// Where a camera sits on the body that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seat {
    /// Position of the IMU in the body's axes, m.
    pub(crate) position: DVec3,
    /// Camera's axes to the body's.
    pub(crate) rotation: Rotation<Body, Body>,
}

/// Half the span over which the angular acceleration is taken, s.
const SWING_S: f64 = 1e-4;

/// A trajectory that begins at a place in W, and where on what moves along it the camera sits.
#[derive(Clone)]
pub(crate) struct Mover {
    trajectory: Arc<dyn Trajectory>,
    /// The origin of W in the trajectory's own axes.
    origin: DVec3,
    seat: Option<Seat>,
}

impl Mover {
    /// Moves a trajectory so that it begins at the origin.
    pub(crate) fn new(trajectory: Arc<dyn Trajectory>) -> Self {
        let origin = Motion::of(&trajectory.pose(0.0), DVec3::ZERO).position;
        Self { trajectory, origin, seat: None }
    }

    /// The same, beginning elsewhere in W, m.
    pub(crate) fn beginning_at(self, place: DVec3) -> Self {
        Self { origin: self.origin + self.at(0.0).position - place, ..self }
    }

    /// The same for a camera on the moving body.
    pub(crate) fn seated(self, seat: Seat) -> Self {
        Self { seat: Some(seat), ..self }
    }

    /// The moving body itself.
    pub(crate) fn unseated(self) -> Self {
        Self { seat: None, ..self }
    }

    /// The motion at a time since the beginning, s.
    pub(crate) fn at(&self, time_s: f64) -> Motion {
        let of_body = |time_s: f64| Motion::of(&self.trajectory.pose(time_s), self.origin);
        let body = of_body(time_s);
        let Some(seat) = &self.seat else { return body };
        let (before, after) = (of_body(time_s - SWING_S).rate, of_body(time_s + SWING_S).rate);
        body.of_seat(seat, (after - before) / (2.0 * SWING_S))
    }
}

/// The rotating earth below W. W is flat: its axes stay those of its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Earth {
    /// Rotation of the earth in W, rad/s.
    pub(crate) rate: DVec3,
    /// Gravity in W, m/s².
    pub(crate) gravity: DVec3,
}

impl Earth {
    /// The earth at a latitude; `true_north_rad` is the direction of true north from W's y axis,
    /// anticlockwise.
    pub(crate) fn at(latitude_deg: f64, true_north_rad: f64) -> Self {
        let (up, horizontal) = latitude_deg.to_radians().sin_cos();
        let (sin, cos) = true_north_rad.sin_cos();
        Self {
            rate: DVec3::new(-sin * horizontal, cos * horizontal, up) * EARTH_RATE_RAD_S,
            gravity: DVec3::new(0.0, 0.0, -GRAVITY_M_S2),
        }
    }

    /// What a gyroscope feels, in the body frame, rad/s: against inertial space.
    pub(crate) fn inertial_rate(&self, motion: &Motion) -> DVec3 {
        motion.rate + motion.orientation.inverse().apply(self.rate)
    }

    /// What an accelerometer feels, in the body frame, m/s²: f = Rᵀ(a − g + 2 Ω × v), which is
    /// maths.md, eq:ResultingAcceleration, solved for f.
    pub(crate) fn specific_force(&self, motion: &Motion) -> DVec3 {
        let coriolis = 2.0 * self.rate.cross(motion.velocity);
        let felt = motion.acceleration - self.gravity + coriolis;
        motion.orientation.inverse().apply(felt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::synthetic::jet::Jet;
    use proptest::prelude::*;

    fn pose(t: f64, w: [f64; 3]) -> PoseJet {
        let time = Jet::new(t, 1.0, 0.0);
        PoseJet {
            position: [(time * w[0]).sin(), (time * w[1]).sin(), time * time],
            yaw: time * w[0] * 2.0,
            pitch: (time * w[1]).sin() * 1.2,
            roll: (time * w[2]).sin() * 2.0,
        }
    }

    proptest! {
        #[test]
        fn the_body_rate_is_the_rotations_derivative(t in -2.0..2.0f64, w in [-2.0..2.0f64, -2.0..2.0, -2.0..2.0]) {
            const STEP: f64 = 1e-5;
            let at = |t: f64| Motion::of(&pose(t, w), DVec3::ZERO).orientation;
            let turned = (at(t - STEP).inverse() * at(t + STEP)).quaternion();
            let measured = turned.to_scaled_axis() / (2.0 * STEP);
            let exact = Motion::of(&pose(t, w), DVec3::ZERO).rate;
            prop_assert!((measured - exact).length() < 1e-5, "{measured} against {exact}");
        }

        #[test]
        fn gravity_is_felt_upward_at_rest(yaw in -3.0..3.0f64, pitch in -1.5..1.5f64, roll in -3.0..3.0f64) {
            let rest = PoseJet {
                position: [Jet::default(); 3],
                yaw: Jet::constant(yaw),
                pitch: Jet::constant(pitch),
                roll: Jet::constant(roll),
            };
            let motion = Motion::of(&rest, DVec3::ZERO);
            let felt = motion.orientation.apply(Earth::at(48.0, 0.0).specific_force(&motion));
            prop_assert!((felt - DVec3::new(0.0, 0.0, 9.81)).length() < 1e-12);
        }
    }

    #[test]
    fn a_seats_velocity_and_acceleration_are_its_positions_derivatives() {
        let seat = Seat {
            position: DVec3::new(0.3, -0.4, 0.2),
            rotation: Rotation::from_yaw_pitch_roll(1.0, 0.2, -0.3),
        };
        let at = |time_s: f64| {
            let rate = |t: f64| Motion::of(&pose(t, [0.7, 1.1, 0.5]), DVec3::ZERO).rate;
            let swing = (rate(time_s + 1e-4) - rate(time_s - 1e-4)) / 2e-4;
            Motion::of(&pose(time_s, [0.7, 1.1, 0.5]), DVec3::ZERO).of_seat(&seat, swing)
        };
        for time_s in [-1.0, 0.3, 1.7] {
            let (before, now, after) = (at(time_s - 1e-4), at(time_s), at(time_s + 1e-4));
            let velocity = (after.position - before.position) / 2e-4;
            let acceleration = (after.velocity - before.velocity) / 2e-4;
            assert!((velocity - now.velocity).length() < 1e-6);
            assert!((acceleration - now.acceleration).length() < 1e-5);
            let turned = (before.orientation.inverse() * after.orientation).quaternion();
            assert!((turned.to_scaled_axis() / 2e-4 - now.rate).length() < 1e-6);
        }
    }

    #[test]
    fn coriolis_at_80_km_h_in_garching_is_2_4_mm_s2() {
        // Northward, the horizontal part of the Coriolis acceleration points east.
        let velocity = DVec3::new(0.0, 80.0 / 3.6, 0.0);
        let motion = Motion { velocity, ..Motion::of(&pose(0.0, [0.0; 3]), DVec3::ZERO) };
        let still = Motion { velocity: DVec3::ZERO, ..motion };
        let earth = Earth::at(48.0, 0.0);
        let felt = earth.specific_force(&motion) - earth.specific_force(&still);
        assert!((motion.orientation.apply(felt).x + 2.4e-3).abs() < 0.05e-3, "{felt}");
    }

    #[test]
    fn the_earth_turns_about_true_north_in_either_world() {
        let (true_world, magnetic) = (Earth::at(48.0, 0.0), Earth::at(48.0, 0.07));
        assert!((true_world.rate.length() - EARTH_RATE_RAD_S).abs() < 1e-15);
        assert!((magnetic.rate.length() - EARTH_RATE_RAD_S).abs() < 1e-15);
        // Magnetic north lies east of true north, so true north lies west in its world.
        assert!(magnetic.rate.x < 0.0 && true_world.rate.x == 0.0);
    }
}
