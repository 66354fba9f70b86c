//! Aiding messages of other processes, checked and in the estimator's terms.

use glam::{DMat3, DQuat, DVec3};
use lodestone_fusion::{Aid, Anchor, Measurement, Rotation, SensorTime};
use lodestone_schema::{Aiding, AidingKind, AidingOrigin, AnchorRefusal, DistanceSource};

/// Largest difference of a quaternion's length from one that rounding explains.
const UNIT_TOLERANCE: f64 = 1e-3;

/// Whom a message is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Addressee {
    pub(crate) camera_id: u32,
    pub(crate) world_epoch: u32,
}

/// What a message says, at a time on the sensor's clock; `None` where it makes no sense, or speaks of
/// another camera or another world. Values and covariances are the estimator's to check.
pub(crate) fn understood(
    message: &Aiding,
    time: SensorTime,
    to: Addressee,
    anchor: Option<Anchor>,
) -> Option<Aid> {
    let of_this_world = message.world_epoch == 0 || message.world_epoch == to.world_epoch;
    if message.camera_id != to.camera_id || !of_this_world {
        return None;
    }
    let value = DVec3::from(message.value);
    let covariance = symmetric(&message.value_covariance);
    let lever_m = DVec3::from(message.lever_arm_m);
    let measurement = match AidingKind::from_code(message.kind)? {
        AidingKind::ForwardSpeed => speed(message)?,
        AidingKind::Velocity => Measurement::Velocity { velocity_m_s: value, covariance, lever_m },
        AidingKind::Position => Measurement::Position { position_m: value, covariance, lever_m },
        AidingKind::Pose => Measurement::Pose {
            position_m: value,
            covariance,
            lever_m,
            orientation: orientation(message)?,
            orientation_covariance: symmetric(&message.orientation_covariance_rad2),
        },
    };
    Some(Aid { time, measurement, anchor })
}

/// Index of the camera against which a message's pose was measured; `None` where it is one in the world.
///
/// # Errors
/// [`AnchorRefusal::NoPose`] where it is none.
pub(super) fn anchor_index(message: &Aiding) -> Result<Option<usize>, AnchorRefusal> {
    let Some(index) = message.anchor.checked_sub(1) else { return Ok(None) };
    match AidingKind::from_code(message.kind) {
        Some(AidingKind::Pose) => Ok(Some(index.into())),
        _ => Err(AnchorRefusal::NoPose),
    }
}

/// Where a position is known from once a message has corrected it; `None` if it is no fix.
pub(super) fn fix_source(message: &Aiding) -> Option<DistanceSource> {
    match AidingKind::from_code(message.kind)? {
        AidingKind::ForwardSpeed | AidingKind::Velocity => None,
        AidingKind::Position | AidingKind::Pose => {
            Some(match AidingOrigin::from_code(message.origin) {
                Some(AidingOrigin::CloudRegistration) => DistanceSource::CloudRegistration,
                _ => DistanceSource::PositionFix,
            })
        }
    }
}

/// A variance that is not a number leaves the noise to the daemon.
fn speed(message: &Aiding) -> Option<Measurement> {
    let variance = message.value_covariance[0];
    let sigma_m_s = (!variance.is_nan()).then(|| variance.sqrt());
    let believable = message.value[0].is_finite();
    believable.then_some(Measurement::Speed { speed_m_s: message.value[0], sigma_m_s })
}

fn orientation(
    message: &Aiding,
) -> Option<Rotation<lodestone_fusion::World, lodestone_fusion::Body>> {
    let quaternion = DQuat::from_array(message.orientation);
    let unit = (quaternion.length() - 1.0).abs() < UNIT_TOLERANCE;
    unit.then(|| Rotation::from_quaternion(quaternion)).flatten()
}

/// The matrix of `xx xy xz yy yz zz`.
const fn symmetric(c: &[f64; 6]) -> DMat3 {
    DMat3::from_cols_array(&[c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TO: Addressee = Addressee { camera_id: 3, world_epoch: 2 };

    fn message(kind: AidingKind) -> Aiding {
        Aiding {
            sequence: 0,
            camera_id: 3,
            world_epoch: 2,
            kind: kind.code(),
            origin: 0,
            anchor: 0,
            reserved: [0; 4],
            time_ns: 0,
            value: [1.0, 2.0, 3.0],
            orientation: [0.0, 0.0, 1.0, 0.0],
            value_covariance: [4.0, 0.1, 0.2, 5.0, 0.3, 6.0],
            orientation_covariance_rad2: [0.01, 0.0, 0.0, 0.01, 0.0, 0.01],
            lever_arm_m: [0.1, 0.2, 0.3],
        }
    }

    fn heard(message: &Aiding) -> Option<Measurement> {
        understood(message, SensorTime::from_nanos(5), TO, None).map(|aid| aid.measurement)
    }

    #[test]
    fn each_kind_says_what_it_holds() {
        let covariance = DMat3::from_cols_array(&[4.0, 0.1, 0.2, 0.1, 5.0, 0.3, 0.2, 0.3, 6.0]);
        let (position_m, lever_m) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.1, 0.2, 0.3));
        let speed = Measurement::Speed { speed_m_s: 1.0, sigma_m_s: Some(2.0) };
        assert_eq!(heard(&message(AidingKind::ForwardSpeed)), Some(speed));
        let position = Measurement::Position { position_m, covariance, lever_m };
        assert_eq!(heard(&message(AidingKind::Position)), Some(position));
        let velocity = Measurement::Velocity { velocity_m_s: position_m, covariance, lever_m };
        assert_eq!(heard(&message(AidingKind::Velocity)), Some(velocity));
        assert!(matches!(heard(&message(AidingKind::Pose)), Some(Measurement::Pose { .. })));
    }

    #[test]
    fn a_speed_may_leave_its_noise_open() {
        let mut open = message(AidingKind::ForwardSpeed);
        open.value_covariance = [f64::NAN; 6];
        let speed = Measurement::Speed { speed_m_s: 1.0, sigma_m_s: None };
        assert_eq!(heard(&open), Some(speed));
    }

    #[test]
    fn what_makes_no_sense_or_is_for_others_is_not_understood() {
        let good = message(AidingKind::Pose);
        for wrong in [
            Aiding { kind: 99, ..good },
            Aiding { camera_id: 4, ..good },
            Aiding { world_epoch: 1, ..good },
            Aiding { orientation: [f64::NAN; 4], ..good },
            Aiding { orientation: [0.0, 0.0, 1.2, 0.0], ..good },
            Aiding { value: [f64::NAN; 3], ..message(AidingKind::ForwardSpeed) },
        ] {
            assert_eq!(heard(&wrong), None, "{wrong:?}");
        }
        assert!(heard(&Aiding { world_epoch: 0, ..good }).is_some(), "of any world");
    }
}
