//! The pose shortly after the newest published one.

use glam::{DMat3, DQuat, DVec3};
use lodestone_schema::{Pose, Validity};

use crate::covariance::{bound_of_sum, cross_matrix, isotropic, matrix, triangle};
use crate::frame::{Body, Rotation, World};
use crate::limits::PredictionNoise;
use crate::pose::{CameraPose, Origin};

/// Standard gravity, m/s²; its local deviation (0.3 %) is part of the acceleration noise.
const GRAVITY_M_S2: DVec3 = DVec3::new(0.0, 0.0, -9.806_65);

/// The pose at a time after `pose`, with constant angular rate and constant world acceleration.
///
/// `q' = q ⊗ Exp(ω t)`, `a = R f + g`, `v' = v + a t`, `p' = p + v t + a t²/2`. What cannot be
/// predicted loses its validity: orientation without angular rate, velocity without specific force,
/// position without velocity. Covariances grow by what is not known (see [`PredictionNoise`]),
/// with unknown correlations between position, velocity and tilt bounded from above.
pub(crate) fn predict(pose: &CameraPose, time_ns: i64, noise: &PredictionNoise) -> CameraPose {
    let ahead_ns = time_ns.saturating_sub(pose.time_ns());
    if ahead_ns <= 0 {
        return *pose;
    }
    let t = ahead_ns as f64 * 1e-9;
    let mut message = Pose { time_ns, ..*pose.message() };
    message.sensor_time_ns = message.sensor_time_ns.saturating_add(ahead_ns);
    message.validity = predictable(pose).bits();
    turn(&mut message, pose, t, noise);
    advance(&mut message, pose, t, noise);
    CameraPose::derived(message, Origin::Predicted { ahead_ns })
}

fn predictable(pose: &CameraPose) -> Validity {
    let mut valid = pose.validity();
    let mut drop_unless = |needed: Validity, dropped: Validity| {
        if !valid.contains(needed) {
            valid.remove(dropped);
        }
    };
    let moved = Validity::VELOCITY | Validity::POSITION;
    // The attitude of the newest pose turns the specific force into the world.
    drop_unless(Validity::TILT | Validity::HEADING | Validity::SPECIFIC_FORCE, moved);
    drop_unless(Validity::VELOCITY, Validity::POSITION);
    drop_unless(Validity::ANGULAR_RATE, Validity::TILT | Validity::HEADING);
    valid
}

fn turn(message: &mut Pose, pose: &CameraPose, t: f64, noise: &PredictionNoise) {
    let (Some(from), Some(rate)) = (pose.orientation(), pose.angular_rate_rad_s()) else {
        return;
    };
    let turned = from.quaternion() * DQuat::from_scaled_axis(rate * t);
    message.orientation = turned.normalize().to_array();
    let grown = [noise.angular_rate_rad_s * t, noise.angular_acceleration_rad_s2 * t * t / 2.0];
    let added: DMat3 = grown.into_iter().map(isotropic).sum();
    message.orientation_covariance_rad2 =
        triangle(&(matrix(message.orientation_covariance_rad2) + added));
}

fn advance(message: &mut Pose, pose: &CameraPose, t: f64, noise: &PredictionNoise) {
    let (Some(attitude), Some(force), Some(velocity)) =
        (pose.orientation(), pose.specific_force_m_s2(), pose.velocity_m_s())
    else {
        return;
    };
    let acceleration = attitude.apply(force) + GRAVITY_M_S2;
    let position = DVec3::from_array(pose.message().position_m);
    message.velocity_m_s = (velocity + acceleration * t).to_array();
    message.position_m = (position + velocity * t + acceleration * (t * t / 2.0)).to_array();

    let unsure = acceleration_covariance(pose, attitude, force, noise);
    let velocity_p = matrix(pose.message().velocity_covariance_m2_s2);
    let position_p = matrix(pose.message().position_covariance_m2);
    let moved = bound_of_sum(&position_p, &velocity_p, t);
    let jerk = noise.jerk_m_s3;
    message.velocity_covariance_m2_s2 =
        triangle(&(bound_of_sum(&velocity_p, &unsure, t) + isotropic(jerk * t * t / 2.0)));
    message.position_covariance_m2 =
        triangle(&(bound_of_sum(&moved, &unsure, t * t / 2.0) + isotropic(jerk * t * t * t / 6.0)));
}

/// An error φ of the attitude tilts the specific force by `φ × R f`.
fn acceleration_covariance(
    pose: &CameraPose,
    attitude: Rotation<World, Body>,
    force: DVec3,
    noise: &PredictionNoise,
) -> DMat3 {
    let lever = cross_matrix(attitude.apply(force));
    let tilt = matrix(pose.message().orientation_covariance_rad2);
    lever * tilt * lever.transpose() + isotropic(noise.acceleration_m_s2)
}

#[cfg(test)]
mod tests;
