//! A pose that was checked.

mod check;
#[cfg(test)]
pub(crate) mod samples;
#[cfg(test)]
mod tests;

use glam::{DMat3, DQuat, DVec3};
use lodestone_schema::{AidFlags, HeadingSource, Pose, PositionSource, Status, Validity};

use crate::covariance;
use crate::error::{MessageError, NotValid};
use crate::frame::{Body, Rotation, World};
use crate::transform::Transform;

/// How a pose came to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The daemon published it.
    Published,
    /// It lies between two published poses.
    Interpolated,
    /// It is extrapolated from the newest published pose.
    Predicted {
        /// How far ahead, ns.
        ahead_ns: i64,
    },
}

/// Where the camera looks in the horizontal plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// Turn about up (`R_z`), from east towards north, rad, within ±π.
    pub yaw_rad: f64,
    /// Standard deviation, rad.
    pub sigma_rad: f64,
}

impl Heading {
    /// Degrees clockwise from north, 0 to below 360, as a compass shows it.
    ///
    /// ```
    /// use lodestone_client::Heading;
    /// let east = Heading { yaw_rad: 0.0, sigma_rad: 0.01 };
    /// assert_eq!(east.compass_deg(), 90.0);
    /// ```
    pub fn compass_deg(self) -> f64 {
        let degrees = (90.0 - self.yaw_rad.to_degrees()).rem_euclid(360.0);
        // The remainder of a tiny negative number rounds up to 360.
        if degrees < 360.0 { degrees } else { 0.0 }
    }
}

/// Where a camera is and which way it looks, checked: what is unknown is `None`, and what is not
/// `None` is finite and within physical bounds.
///
/// ```
/// use lodestone_client::{CameraPose, MessageError, Pose, Validity};
///
/// fn receive(message: Pose) -> Result<(), MessageError> {
///     let pose = CameraPose::try_from(message)?;
///     match pose.position_m() {
///         Some(position) => println!("{position} m at {} ns", pose.time_ns()),
///         None => println!("position unknown"),
///     }
///     Ok(())
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraPose {
    message: Pose,
    origin: Origin,
}

impl TryFrom<Pose> for CameraPose {
    type Error = MessageError;

    /// Checks a message: every code is known, and every field whose [`Validity`] flag is set is
    /// finite, within bounds and, for the orientation, of unit length within 1e-6.
    fn try_from(message: Pose) -> Result<Self, MessageError> {
        check::pose(&message)?;
        let mut message = message;
        if Validity::from_bits_truncate(message.validity).contains(Validity::TILT) {
            message.orientation = DQuat::from_array(message.orientation).normalize().to_array();
        }
        Ok(Self { message, origin: Origin::Published })
    }
}

impl CameraPose {
    /// Takes what was worked out from checked poses.
    pub(crate) const fn derived(message: Pose, origin: Origin) -> Self {
        Self { message, origin }
    }

    /// The message; fields without their [`Validity`] flag mean nothing.
    pub const fn message(&self) -> &Pose {
        &self.message
    }

    /// How this pose came to be.
    pub const fn origin(&self) -> Origin {
        self.origin
    }

    /// Number of the pose within its lane; of the earlier neighbour if interpolated.
    pub const fn sequence(&self) -> u64 {
        self.message.sequence
    }

    /// Index of the camera in the daemon's configuration.
    pub const fn camera_id(&self) -> u32 {
        self.message.camera_id
    }

    /// Number of re-initialisations of the lane so far.
    pub const fn reset_counter(&self) -> u32 {
        self.message.reset_counter
    }

    /// Time of validity on `CLOCK_MONOTONIC`, ns.
    pub const fn time_ns(&self) -> i64 {
        self.message.time_ns
    }

    /// Time of validity since the UNIX epoch, ns.
    pub const fn unix_time_ns(&self) -> i64 {
        self.message.time_ns.saturating_add(self.message.unix_offset_ns)
    }

    /// What the lane says about this pose.
    pub const fn status(&self) -> Status {
        Status::from_bits_truncate(self.message.status)
    }

    /// Which fields are known.
    pub const fn validity(&self) -> Validity {
        Validity::from_bits_truncate(self.message.validity)
    }

    /// Where the heading comes from.
    pub fn heading_source(&self) -> HeadingSource {
        HeadingSource::from_code(self.message.heading_source).unwrap_or(HeadingSource::None)
    }

    /// Where the position comes from.
    pub fn position_source(&self) -> PositionSource {
        PositionSource::from_code(self.message.position_source).unwrap_or(PositionSource::None)
    }

    /// What corrected this pose within the last second.
    pub const fn aids_used(&self) -> AidFlags {
        AidFlags::from_bits_truncate(self.message.aids_used)
    }

    /// What was refused by its gate within the last second.
    pub const fn aids_refused(&self) -> AidFlags {
        AidFlags::from_bits_truncate(self.message.aids_refused)
    }

    /// Epoch of the world this pose is in; 0 while there is none. Poses of different epochs do not
    /// compare.
    pub const fn world_epoch(&self) -> u32 {
        self.message.world_epoch
    }

    /// Whether all of these fields are known.
    ///
    /// # Errors
    /// [`NotValid`] names those that are not.
    pub fn require(&self, fields: Validity) -> Result<(), NotValid> {
        let missing = fields.difference(self.validity());
        if missing.is_empty() { Ok(()) } else { Err(NotValid(missing)) }
    }

    /// Orientation; its turn about up means something only if [`CameraPose::heading`] is known.
    pub fn orientation(&self) -> Option<Rotation<World, Body>> {
        self.known(Validity::TILT)
            .then(|| Rotation::from_unit(DQuat::from_array(self.message.orientation)))
    }

    /// Where the camera looks in the horizontal plane; `None` as well while it looks straight up
    /// or down ([`Status::GIMBAL_LOCK`]).
    pub fn heading(&self) -> Option<Heading> {
        let locked = self.status().contains(Status::GIMBAL_LOCK);
        let known = self.known(Validity::TILT | Validity::HEADING) && !locked;
        let yaw_rad = self.orientation()?.to_yaw_pitch_roll().0;
        let sigma_rad = self.message.orientation_covariance_rad2[5].sqrt();
        known.then_some(Heading { yaw_rad, sigma_rad })
    }

    /// Position of the body origin in the world, m.
    pub fn position_m(&self) -> Option<DVec3> {
        self.vector(Validity::POSITION, self.message.position_m)
    }

    /// Velocity of the body origin in the world, m/s.
    pub fn velocity_m_s(&self) -> Option<DVec3> {
        self.vector(Validity::VELOCITY, self.message.velocity_m_s)
    }

    /// Angular rate of the body against the world, in the body frame, rad/s.
    pub fn angular_rate_rad_s(&self) -> Option<DVec3> {
        self.vector(Validity::ANGULAR_RATE, self.message.angular_rate_rad_s)
    }

    /// Specific force in the body frame, m/s²; +9.81 upward at rest.
    pub fn specific_force_m_s2(&self) -> Option<DVec3> {
        self.vector(Validity::SPECIFIC_FORCE, self.message.specific_force_m_s2)
    }

    /// Covariance of the position in the world, m².
    pub fn position_covariance_m2(&self) -> Option<DMat3> {
        self.matrix(Validity::POSITION, &self.message.position_covariance_m2)
    }

    /// Covariance of the velocity in the world, (m/s)².
    pub fn velocity_covariance_m2_s2(&self) -> Option<DMat3> {
        self.matrix(Validity::VELOCITY, &self.message.velocity_covariance_m2_s2)
    }

    /// Covariance of the orientation as a small rotation vector about the world axes, rad².
    pub fn orientation_covariance_rad2(&self) -> Option<DMat3> {
        let both = Validity::TILT | Validity::HEADING;
        self.matrix(both, &self.message.orientation_covariance_rad2)
    }

    /// Standard deviation of the position, the root of the mean variance of its axes, m.
    pub fn position_sigma_m(&self) -> Option<f64> {
        self.position_covariance_m2().map(|p| (covariance::trace(&p) / 3.0).sqrt())
    }

    /// Turns body coordinates into world coordinates.
    ///
    /// # Errors
    /// [`NotValid`] unless tilt, heading and position are known.
    pub fn world_from_body(&self) -> Result<Transform<World, Body>, NotValid> {
        self.require(Validity::TILT | Validity::HEADING | Validity::POSITION)?;
        let rotation = Rotation::from_unit(DQuat::from_array(self.message.orientation));
        Ok(Transform::new(rotation, DVec3::from_array(self.message.position_m)))
    }

    fn known(&self, fields: Validity) -> bool {
        self.validity().contains(fields)
    }

    fn vector(&self, field: Validity, value: [f64; 3]) -> Option<DVec3> {
        self.known(field).then(|| DVec3::from_array(value))
    }

    fn matrix(&self, fields: Validity, triangle: &[f64; 6]) -> Option<DMat3> {
        self.known(fields).then(|| covariance::matrix(*triangle))
    }
}
