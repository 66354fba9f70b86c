//! One camera as another one has it, checked.

use core::time::Duration;

use glam::{DMat3, DQuat, DVec3};
use lodestone_schema::{DistanceSource, ServiceKind, Validity, WORLD_NAME, name_of};

use crate::client::Client;
use crate::covariance;
use crate::error::{MessageError, NotValid, StreamError};
use crate::frame::{Body, Rotation};
use crate::message::Message;
use crate::stream::nothing;
use crate::subscription::Subscription;
use crate::transform::Transform;

/// A relative pose as it lies in shared memory.
pub type RelativeMessage = lodestone_schema::Relative;

/// Camera b in the body axes of camera a: `p_a = R_ab p_b + D_ab`; what is not known is `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativePose {
    message: RelativeMessage,
    source: DistanceSource,
}

/// Beyond any place.
const LIMIT: f64 = 1e9;

impl TryFrom<RelativeMessage> for RelativePose {
    type Error = MessageError;

    fn try_from(message: RelativeMessage) -> Result<Self, MessageError> {
        let code = message.distance_source;
        let source = DistanceSource::from_code(code)
            .ok_or(MessageError::UnknownCode { field: "distance_source", code })?;
        name_of(&message.name_a).ok_or(MessageError::BadName { field: "name_a" })?;
        name_of(&message.name_b).ok_or(MessageError::BadName { field: "name_b" })?;
        let valid = Validity::from_bits_truncate(message.validity);
        if valid.contains(Validity::HEADING) {
            let norm = DQuat::from_array(message.orientation).length();
            let is_unit = (norm - 1.0).abs() < 1e-6;
            if !is_unit {
                return Err(MessageError::NotUnit { norm });
            }
            bounded("orientation_covariance_rad2", &message.orientation_covariance_rad2)?;
        }
        if valid.contains(Validity::POSITION) {
            bounded("distance_m", &message.distance_m)?;
            bounded("distance_covariance_m2", &message.distance_covariance_m2)?;
        }
        Ok(Self { message, source })
    }
}

fn bounded(field: &'static str, values: &[f64]) -> Result<(), MessageError> {
    match values.iter().copied().find(|v| v.is_nan() || v.abs() > LIMIT) {
        Some(value) => Err(MessageError::OutOfRange { field, value, limit: LIMIT }),
        None => Ok(()),
    }
}

impl Message for RelativePose {
    type Raw = RelativeMessage;
    const KIND: ServiceKind = ServiceKind::Relative;
    const SILENCE: Duration = Duration::from_secs(5);

    fn sequence(raw: &RelativeMessage) -> u64 {
        raw.sequence
    }

    fn time_ns(raw: &RelativeMessage) -> i64 {
        raw.time_ns
    }
}

impl RelativePose {
    /// The message; fields without their [`Validity`] flag are not vouched for.
    pub const fn message(&self) -> &RelativeMessage {
        &self.message
    }

    /// Camera a, in whose axes all is given.
    pub fn camera_a(&self) -> &str {
        name_of(&self.message.name_a).unwrap_or_default()
    }

    /// Camera b.
    pub fn camera_b(&self) -> &str {
        name_of(&self.message.name_b).unwrap_or_default()
    }

    /// The instant, `CLOCK_MONOTONIC`, ns.
    pub const fn time_ns(&self) -> i64 {
        self.message.time_ns
    }

    /// What is known within the daemon's bounds: tilt and heading together, position.
    pub const fn validity(&self) -> Validity {
        Validity::from_bits_truncate(self.message.validity)
    }

    /// Where the distance is known from.
    pub const fn distance_source(&self) -> DistanceSource {
        self.source
    }

    /// Whether both sit on one body.
    pub const fn is_rigid(&self) -> bool {
        self.message.rigid != 0
    }

    /// `R_ab`: b's body axes to a's.
    pub fn orientation(&self) -> Option<Rotation<Body, Body>> {
        let rotation = Rotation::from_quaternion(DQuat::from_array(self.message.orientation));
        rotation.filter(|_| self.validity().contains(Validity::HEADING))
    }

    /// Covariance of `R_ab` as a small rotation vector about a's body axes, rad².
    pub fn orientation_covariance_rad2(&self) -> Option<DMat3> {
        let valid = self.validity().contains(Validity::HEADING);
        valid.then(|| covariance::matrix(self.message.orientation_covariance_rad2))
    }

    /// Standard deviation of `R_ab` about its worst axis, rad.
    pub fn orientation_sigma_rad(&self) -> Option<f64> {
        self.orientation_covariance_rad2().map(|c| worst(&c))
    }

    /// Angle by which b is turned against a, rad, 0 to π.
    pub fn angle_rad(&self) -> Option<f64> {
        let quaternion = self.orientation()?.quaternion();
        Some(2.0 * quaternion.xyz().length().atan2(quaternion.w.abs()))
    }

    /// `D_ab`: from a's body origin to b's, in a's body axes, m.
    pub fn distance_m(&self) -> Option<DVec3> {
        let valid = self.validity().contains(Validity::POSITION);
        valid.then(|| DVec3::from_array(self.message.distance_m))
    }

    /// Covariance of `D_ab` in a's body axes, m².
    pub fn distance_covariance_m2(&self) -> Option<DMat3> {
        let valid = self.validity().contains(Validity::POSITION);
        valid.then(|| covariance::matrix(self.message.distance_covariance_m2))
    }

    /// Standard deviation of `D_ab` along its worst axis, m.
    pub fn distance_sigma_m(&self) -> Option<f64> {
        self.distance_covariance_m2().map(|c| worst(&c))
    }

    /// Turns b's body coordinates into a's: what puts two clouds together.
    ///
    /// # Errors
    /// [`NotValid`] unless rotation and distance are known.
    pub fn a_from_b(&self) -> Result<Transform<Body, Body>, NotValid> {
        let needed = Validity::TILT | Validity::HEADING | Validity::POSITION;
        match (self.orientation(), self.distance_m()) {
            (Some(rotation), Some(distance)) => Ok(Transform::new(rotation, distance)),
            _ => Err(NotValid(needed.difference(self.validity()))),
        }
    }

    /// The same pair the other way round: camera a in the body axes of camera b.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = DQuat::from_array(self.message.orientation).conjugate();
        let turn = DMat3::from_quat(rotation);
        let distance = DVec3::from_array(self.message.distance_m);
        let over = |triangle: [f64; 6]| turn * covariance::matrix(triangle) * turn.transpose();
        // An error of the rotation about a's axes turns the distance that b sees.
        let by_turn = covariance::cross_matrix(distance);
        let turned = by_turn
            * covariance::matrix(self.message.orientation_covariance_rad2)
            * by_turn.transpose();
        let of_distance = covariance::matrix(self.message.distance_covariance_m2) + turned;
        let m = self.message;
        let message = RelativeMessage {
            camera_a: m.camera_b,
            camera_b: m.camera_a,
            name_a: m.name_b,
            name_b: m.name_a,
            orientation: rotation.to_array(),
            orientation_covariance_rad2: covariance::triangle(&over(m.orientation_covariance_rad2)),
            distance_m: (-(turn * distance)).to_array(),
            distance_covariance_m2: covariance::triangle(&(turn * of_distance * turn.transpose())),
            ..m
        };
        Self { message, ..*self }
    }
}

fn worst(m: &DMat3) -> f64 {
    m.x_axis.x.max(m.y_axis.y).max(m.z_axis.z).sqrt()
}

/// Relative poses of one pair of cameras, or of all.
///
/// ```no_run
/// # let client = lodestone_client::Client::connect()?;
/// let mut pair = client.relative("front", "rear")?;
/// let front_from_rear = pair.latest()?.a_from_b()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct RelativeStream {
    subscription: Subscription<RelativePose>,
    /// `None` for all pairs.
    asked: Option<(String, String)>,
    latest: Vec<RelativePose>,
}

impl RelativeStream {
    pub(crate) fn new(client: Client, asked: Option<(String, String)>) -> Self {
        let subscription = Subscription::new(client, WORLD_NAME.into());
        Self { subscription, asked, latest: Vec::new() }
    }

    /// The newest relative pose of the pair, in the order in which it was asked for; of all pairs, the
    /// newest of any.
    ///
    /// # Errors
    /// [`StreamError`] if none ever came.
    pub fn latest(&mut self) -> Result<RelativePose, StreamError> {
        self.receive();
        let newest = self.latest.iter().max_by_key(|pose| pose.message.sequence).copied();
        newest.ok_or_else(|| nothing(&self.subscription))
    }

    /// The newest relative pose of each pair, in the order of the configuration.
    ///
    /// # Errors
    /// [`StreamError`] until every pair has come.
    pub fn all(&mut self) -> Result<&[RelativePose], StreamError> {
        self.receive();
        let wanted = match (&self.asked, self.latest.first()) {
            (Some(_), _) => 1,
            (None, Some(pose)) => pose.message.pair_count as usize,
            (None, None) => usize::MAX,
        };
        if self.latest.len() < wanted {
            return Err(nothing(&self.subscription));
        }
        Ok(&self.latest)
    }

    fn receive(&mut self) {
        while let Some(received) = self.subscription.next() {
            if received.restart {
                self.latest.clear();
            }
            let pose = received.message.ok().and_then(|pose| self.chosen(pose));
            let Some(pose) = pose else { continue };
            let key = |p: &RelativePose| (p.message.camera_a, p.message.camera_b);
            match self.latest.binary_search_by_key(&key(&pose), key) {
                Ok(place) => self.latest[place] = pose,
                Err(place) => self.latest.insert(place, pose),
            }
        }
    }

    fn chosen(&self, pose: RelativePose) -> Option<RelativePose> {
        let Some((a, b)) = &self.asked else { return Some(pose) };
        let is = |x: &str, y: &str| pose.camera_a() == x && pose.camera_b() == y;
        if is(a, b) {
            return Some(pose);
        }
        is(b, a).then(|| pose.inverse())
    }
}

#[cfg(test)]
mod tests {
    use lodestone_schema::to_name;
    use proptest::prelude::*;

    use super::*;
    use crate::pose::samples::{quaternions, vectors};

    fn message(orientation: DQuat, distance: DVec3) -> RelativeMessage {
        RelativeMessage {
            sequence: 3,
            time_ns: 5,
            camera_a: 0,
            camera_b: 1,
            name_a: to_name("front").unwrap(),
            name_b: to_name("rear").unwrap(),
            world_epoch: 1,
            pair_count: 1,
            validity: (Validity::TILT | Validity::HEADING | Validity::POSITION).bits(),
            distance_source: DistanceSource::CommonStart.code(),
            rigid: 0,
            reserved: [0; 2],
            field_correlation: 1.0,
            orientation: orientation.to_array(),
            orientation_covariance_rad2: [1e-4, 0.0, 0.0, 1e-4, 0.0, 4e-4],
            distance_m: distance.to_array(),
            distance_covariance_m2: [1e-2, 0.0, 0.0, 1e-2, 0.0, 1e-2],
        }
    }

    proptest! {
        #[test]
        fn the_other_way_round_undoes_it(q in quaternions(), d in vectors(20.0), p in vectors(5.0)) {
            let ab = RelativePose::try_from(message(q, d)).unwrap();
            let ba = ab.inverse();
            prop_assert_eq!((ba.camera_a(), ba.camera_b()), ("rear", "front"));
            let there = ab.a_from_b().unwrap().apply(p);
            prop_assert!(ba.a_from_b().unwrap().apply(there).abs_diff_eq(p, 1e-9));
            prop_assert!(ba.distance_sigma_m().unwrap() >= 0.1 - 1e-9);
        }
    }

    #[test]
    fn what_is_not_vouched_for_is_none_and_what_is_wrong_is_refused() {
        let good = message(DQuat::IDENTITY, DVec3::X);
        let unknown = RelativeMessage {
            validity: Validity::TIME.bits(),
            orientation: [f64::NAN; 4],
            distance_m: [f64::NAN; 3],
            ..good
        };
        let pose = RelativePose::try_from(unknown).unwrap();
        assert_eq!((pose.orientation().is_none(), pose.distance_m()), (true, None));
        assert!(pose.a_from_b().is_err());
        let torn = RelativeMessage { orientation: [f64::NAN; 4], ..good };
        assert!(RelativePose::try_from(torn).is_err());
        let unknown_code = RelativeMessage { distance_source: 99, ..good };
        assert!(RelativePose::try_from(unknown_code).is_err());
        let unnamed = RelativeMessage { name_a: [0xff; 64], ..good };
        assert!(RelativePose::try_from(unnamed).is_err());
    }
}
