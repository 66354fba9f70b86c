//! The pose between two published ones.

use glam::{DQuat, DVec3};
use lodestone_schema::{Pose, Status, Validity};

use crate::covariance;
use crate::pose::{CameraPose, Origin};

/// What a pose claims; the other status bits warn.
const CLAIMS: Status = Status::INITIALISED.union(Status::STATIONARY).union(Status::CALIBRATED);

/// The pose at a time from `a` to `b`, which are neighbours of one history.
///
/// Orientation turns at a constant rate along the shorter arc (slerp). Position is the cubic
/// Hermite curve through both positions with both velocities, or a straight line where a velocity
/// is unknown; velocity, rates, forces and covariances are mixed linearly. A field is valid if it
/// is in both; a warning counts if it is in either, a claim (initialised, stationary, calibrated)
/// if it is in both.
pub(crate) fn between(a: &CameraPose, b: &CameraPose, time_ns: i64) -> CameraPose {
    if time_ns <= a.time_ns() {
        return *a;
    }
    if time_ns >= b.time_ns() {
        return *b;
    }
    let span_ns = b.time_ns() - a.time_ns();
    let s = (time_ns - a.time_ns()) as f64 / span_ns as f64;
    let (from, to) = (a.message(), b.message());
    let mut message = Pose {
        status: status(a, b).bits(),
        validity: (a.validity() & b.validity()).bits(),
        sensor_time_ns: mix_time(from.sensor_time_ns, to.sensor_time_ns, s),
        time_ns,
        // It could not be known before its later neighbour was.
        arrival_time_ns: to.arrival_time_ns,
        ring_time_ns: to.ring_time_ns,
        step_start_time_ns: to.step_start_time_ns,
        step_end_time_ns: to.step_end_time_ns,
        published_time_ns: to.published_time_ns,
        unix_offset_ns: to.unix_offset_ns,
        ..*from
    };
    mix_fields(&mut message, from, to, s);
    message.position_m = position(a, b, s, span_ns as f64 * 1e-9);
    message.orientation = orientation(from, to, s);
    CameraPose::derived(message, Origin::Interpolated)
}

fn mix_fields(message: &mut Pose, a: &Pose, b: &Pose, s: f64) {
    message.velocity_m_s = mix(a.velocity_m_s, b.velocity_m_s, s);
    message.angular_rate_rad_s = mix(a.angular_rate_rad_s, b.angular_rate_rad_s, s);
    message.specific_force_m_s2 = mix(a.specific_force_m_s2, b.specific_force_m_s2, s);
    message.position_covariance_m2 =
        covariance::mix(&a.position_covariance_m2, &b.position_covariance_m2, s);
    message.velocity_covariance_m2_s2 =
        covariance::mix(&a.velocity_covariance_m2_s2, &b.velocity_covariance_m2_s2, s);
    message.orientation_covariance_rad2 =
        covariance::mix(&a.orientation_covariance_rad2, &b.orientation_covariance_rad2, s);
}

fn status(a: &CameraPose, b: &CameraPose) -> Status {
    let (a, b) = (a.status(), b.status());
    (a | b).difference(CLAIMS) | (a & b & CLAIMS)
}

fn mix(a: [f64; 3], b: [f64; 3], s: f64) -> [f64; 3] {
    core::array::from_fn(|i| a[i] * (1.0 - s) + b[i] * s)
}

fn mix_time(a: i64, b: i64, s: f64) -> i64 {
    a.saturating_add((b.saturating_sub(a) as f64 * s).round() as i64)
}

/// Cubic Hermite basis over the unit interval, with velocities scaled by the span.
fn position(a: &CameraPose, b: &CameraPose, s: f64, span_s: f64) -> [f64; 3] {
    let (from, to) = (a.message().position_m, b.message().position_m);
    let (Some(v0), Some(v1)) = (a.velocity_m_s(), b.velocity_m_s()) else {
        return mix(from, to, s);
    };
    let (s2, s3) = (s * s, s * s * s);
    let place = DVec3::from_array(from) * (2.0 * s3 - 3.0 * s2 + 1.0)
        + DVec3::from_array(to) * (3.0 * s2 - 2.0 * s3);
    let bend = v0 * (s3 - 2.0 * s2 + s) + v1 * (s3 - s2);
    (place + bend * span_s).to_array()
}

fn orientation(a: &Pose, b: &Pose, s: f64) -> [f64; 4] {
    let valid = |m: &Pose| Validity::from_bits_truncate(m.validity).contains(Validity::TILT);
    if !(valid(a) && valid(b)) {
        return [f64::NAN; 4];
    }
    slerp(DQuat::from_array(a.orientation), DQuat::from_array(b.orientation), s).to_array()
}

/// `a ⊗ (a* ⊗ b)^s` along the shorter arc.
///
/// `DQuat::slerp` works with an approximate arc cosine, whose error shows in f64.
pub(crate) fn slerp(a: DQuat, b: DQuat, s: f64) -> DQuat {
    let step = a.conjugate() * b;
    let step = if step.w < 0.0 { -step } else { step };
    let axis_part = step.xyz();
    let sine = axis_part.length();
    let half_angle = sine.atan2(step.w);
    // The quotient of two sines tends to s as the angle vanishes.
    let scale = if sine < 1e-12 { s } else { (half_angle * s).sin() / sine };
    let part = DQuat::from_vec4((axis_part * scale).extend((half_angle * s).cos()));
    (a * part).normalize()
}

#[cfg(test)]
mod tests;
