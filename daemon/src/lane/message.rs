//! From the estimator's terms to messages and rows.

use glam::{DMat3, DVec3};
use lodestone_config::model::ValidityBounds;
use lodestone_fusion::{
    self as fusion, AidKind, Estimate, HeadingOrigin, ImuSample, PositionOrigin, SensorTime,
    Waiting,
};
use lodestone_schema::{
    AidFlags, AlignmentWait, CalibratedSample, HeadingSource, Pose, PositionSource, SampleFlags,
    Status, Validity,
};

use super::{Phase, StepOutput};
use crate::poses_csv::PoseRow;

/// Variance of an angle of which nothing is known, rad²: that of a uniform one over a whole turn.
const UNKNOWN_ANGLE_VARIANCE: f64 = core::f64::consts::PI * core::f64::consts::PI / 3.0;

/// The status bits of a step.
pub fn status_of(step: &StepOutput, calibrated: bool) -> Status {
    let mut status = step.rig;
    status.set(Status::CALIBRATED, calibrated);
    status.set(Status::BRIDGED, step.bridged);
    status.set(Status::SATURATED, step.saturated);
    status.set(Status::DEGRADED, step.degraded);
    if let Some(estimate) = &step.estimate {
        status |= Status::INITIALISED;
        status.set(Status::STATIONARY, estimate.at_rest);
        status.set(Status::MAGNETIC_DISTURBANCE, estimate.magnetic_disturbance);
        status.set(Status::FIELD_UNLIKE_EARTH, step.field_unlike_earth);
        status.set(Status::POSITION_JUMPED, step.position_jumped);
        status.set(Status::GIMBAL_LOCK, estimate.orientation.is_gimbal_locked());
    }
    status
}

/// Why there is no pose yet.
pub const fn wait_of(phase: Phase) -> AlignmentWait {
    match phase {
        Phase::Running => AlignmentWait::None,
        Phase::Aligning(Waiting::Collecting) => AlignmentWait::Collecting,
        Phase::Aligning(Waiting::Turning(_)) => AlignmentWait::Turning,
        Phase::Aligning(Waiting::Shaking(_)) => AlignmentWait::Shaking,
        Phase::Aligning(Waiting::NotGravity(_)) => AlignmentWait::NotGravity,
        Phase::Aligning(Waiting::ConstantTurn(_)) => AlignmentWait::SteadyTurn,
    }
}

/// The validity bits of an estimate: a value is valid while its standard deviation is within its
/// bound, and never once a sensor clipped or a gap spoilt it beyond that.
pub fn validity_of(estimate: &Estimate, bounds: &ValidityBounds) -> Validity {
    let sigma = Sigmas::of(estimate);
    let heading_known = estimate.heading_origin != HeadingOrigin::Arbitrary;
    let mut validity = Validity::ANGULAR_RATE | Validity::SPECIFIC_FORCE;
    validity.set(Validity::TILT, sigma.tilt_rad < bounds.tilt_sigma_deg.to_radians());
    validity.set(
        Validity::HEADING,
        heading_known && sigma.heading_rad < bounds.heading_sigma_deg.to_radians(),
    );
    validity.set(Validity::VELOCITY, sigma.velocity_m_s < bounds.velocity_sigma_m_s);
    validity.set(Validity::POSITION, sigma.position_m < bounds.position_sigma_m);
    validity
}

/// Writes a step into a pose message; what the step does not know becomes `NaN`.
pub fn fill_pose(pose: &mut Pose, step: &StepOutput, bounds: &ValidityBounds, calibrated: bool) {
    pose.sensor_time_ns = step.time.as_nanos();
    pose.status = status_of(step, calibrated).bits();
    let Some(estimate) = &step.estimate else {
        forget(pose);
        return;
    };
    pose.world_epoch = step.world.epoch;
    pose.validity = validity_of(estimate, bounds).bits();
    pose.heading_source = heading_source(estimate).code();
    pose.position_source = position_source(estimate).code();
    pose.aids_used = aid_bits(estimate.aids.used);
    pose.aids_refused = aid_bits(estimate.aids.refused);
    pose.position_m = estimate.position.into();
    pose.velocity_m_s = estimate.velocity.into();
    pose.orientation = estimate.orientation.quaternion().to_array();
    pose.angular_rate_rad_s = estimate.angular_rate.into();
    pose.specific_force_m_s2 = estimate.specific_force.into();
    pose.position_covariance_m2 = upper_triangle(estimate.position_covariance);
    pose.velocity_covariance_m2_s2 = upper_triangle(estimate.velocity_covariance);
    pose.orientation_covariance_rad2 = upper_triangle(orientation_covariance(estimate));
    if step.world.epoch == 0 || !estimate.is_position_known() {
        forget_position(pose);
    }
}

/// There is no world yet, or nobody has said where in it the camera stands.
fn forget_position(pose: &mut Pose) {
    const UNKNOWN: [f64; 6] = [f64::INFINITY, 0.0, 0.0, f64::INFINITY, 0.0, f64::INFINITY];
    pose.validity &= !Validity::POSITION.bits();
    pose.position_source = PositionSource::None.code();
    pose.position_m = [f64::NAN; 3];
    pose.position_covariance_m2 = UNKNOWN;
}

/// Turns a pose into one of which nothing is known but its times.
pub(super) fn forget(pose: &mut Pose) {
    pose.validity = 0;
    pose.heading_source = HeadingSource::None.code();
    pose.position_source = PositionSource::None.code();
    (pose.aids_used, pose.aids_refused) = (0, 0);
    pose.position_m = [f64::NAN; 3];
    pose.velocity_m_s = [f64::NAN; 3];
    pose.orientation = [f64::NAN; 4];
    pose.angular_rate_rad_s = [f64::NAN; 3];
    pose.specific_force_m_s2 = [f64::NAN; 3];
    pose.position_covariance_m2 = [f64::NAN; 6];
    pose.velocity_covariance_m2_s2 = [f64::NAN; 6];
    pose.orientation_covariance_rad2 = [f64::NAN; 6];
}

/// The calibrated sample as a message; its times on the host's clock are the caller's to add.
pub fn sample_message(
    sample: &ImuSample,
    temperature_c: Option<f32>,
    calibrated: bool,
) -> CalibratedSample {
    let mut flags = SampleFlags::empty();
    flags.set(SampleFlags::MAGNETOMETER, sample.mag.is_some());
    flags.set(SampleFlags::TEMPERATURE, temperature_c.is_some());
    flags.set(SampleFlags::CALIBRATED, calibrated);
    flags.set(SampleFlags::SATURATED, sample.saturated);
    CalibratedSample {
        sequence: 0,
        camera_id: 0,
        flags: flags.bits(),
        sensor_time_ns: sample.time.as_nanos(),
        time_ns: 0,
        arrival_time_ns: 0,
        angular_rate_rad_s: sample.gyro.vector.into(),
        specific_force_m_s2: sample.accel.vector.into(),
        magnetic_field_ut: sample.mag.map_or([f64::NAN; 3], |m| m.vector.into()),
        temperature_c: temperature_c.map_or(f64::NAN, f64::from),
    }
}

/// One row of a replay: the pose at a recording's row.
pub fn pose_row(
    time: SensorTime,
    estimate: Option<&Estimate>,
    status: Status,
    bounds: &ValidityBounds,
) -> PoseRow {
    let sigma = estimate.map(Sigmas::of);
    let heading_known = estimate.is_some_and(|e| e.heading_origin != HeadingOrigin::Arbitrary);
    PoseRow {
        time,
        position_m: estimate.map(|e| e.position),
        orientation: estimate.map(|e| e.orientation),
        velocity_m_s: estimate.map(|e| e.velocity),
        heading_sigma_deg: sigma.filter(|_| heading_known).map(|s| s.heading_rad.to_degrees()),
        tilt_sigma_deg: sigma.map(|s| s.tilt_rad.to_degrees()),
        velocity_sigma_m_s: sigma.map(|s| s.velocity_m_s),
        position_sigma_m: sigma.map(|s| s.position_m),
        status,
        validity: estimate.map_or(Validity::empty(), |e| validity_of(e, bounds)),
        heading_source: estimate.map_or(HeadingSource::None, heading_source),
        position_source: estimate.map_or(PositionSource::None, position_source),
    }
}

/// Standard deviations of an estimate, of the worst axis where there are several.
#[derive(Clone, Copy, Debug)]
struct Sigmas {
    tilt_rad: f64,
    heading_rad: f64,
    velocity_m_s: f64,
    position_m: f64,
}

impl Sigmas {
    fn of(estimate: &Estimate) -> Self {
        let orientation = diagonal(orientation_covariance(estimate));
        Self {
            tilt_rad: orientation.x.max(orientation.y).sqrt(),
            heading_rad: orientation.z.sqrt(),
            velocity_m_s: diagonal(estimate.velocity_covariance).max_element().sqrt(),
            position_m: diagonal(estimate.position_covariance).max_element().sqrt(),
        }
    }
}

/// Without a magnetometer the heading is anything.
fn orientation_covariance(estimate: &Estimate) -> DMat3 {
    let mut covariance = estimate.orientation_covariance;
    if estimate.heading_origin == HeadingOrigin::Arbitrary {
        covariance.z_axis.z = covariance.z_axis.z.max(UNKNOWN_ANGLE_VARIANCE);
    }
    covariance
}

const fn heading_source(estimate: &Estimate) -> HeadingSource {
    match estimate.heading_origin {
        HeadingOrigin::Arbitrary => HeadingSource::None,
        HeadingOrigin::Magnetometer => HeadingSource::Magnetometer,
        HeadingOrigin::Held => HeadingSource::GyroscopeHeld,
        HeadingOrigin::InitialOnly => HeadingSource::InitialOnly,
        HeadingOrigin::PoseFix => HeadingSource::AidingPose,
    }
}

const fn position_source(estimate: &Estimate) -> PositionSource {
    match estimate.position_origin {
        PositionOrigin::Unaided => PositionSource::Inertial,
        PositionOrigin::Standstill => PositionSource::Standstill,
        PositionOrigin::Speed => PositionSource::AidingSpeed,
        PositionOrigin::PositionFix => PositionSource::AidingPosition,
        PositionOrigin::PoseFix => PositionSource::AidingPose,
        PositionOrigin::NonHolonomic => PositionSource::NonHolonomic,
        PositionOrigin::Gradient => PositionSource::MagneticGradient,
    }
}

/// The bits of a set of aids.
fn aid_bits(aids: fusion::AidFlags) -> u8 {
    const BITS: [(AidKind, AidFlags); 7] = [
        (AidKind::Standstill, AidFlags::STANDSTILL),
        (AidKind::Speed, AidFlags::SPEED),
        (AidKind::Velocity, AidFlags::SPEED),
        (AidKind::NonHolonomic, AidFlags::NON_HOLONOMIC),
        (AidKind::PositionFix, AidFlags::POSITION_FIX),
        (AidKind::PoseFix, AidFlags::POSE_FIX),
        (AidKind::Gradient, AidFlags::GRADIENT),
    ];
    let there = BITS.into_iter().filter(|(kind, _)| aids.contains(*kind));
    there.fold(AidFlags::empty(), |bits, (_, bit)| bits | bit).bits()
}

const fn upper_triangle(m: DMat3) -> [f64; 6] {
    [m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z]
}

const fn diagonal(m: DMat3) -> DVec3 {
    DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z)
}
