//! Telling the daemon what this process knows of a camera's motion.

use core::fmt;

use glam::{DMat3, DVec3};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::ipc;
use lodestone_schema::transport::{PublishSubscribe, open_for_reading};
use lodestone_schema::{Aiding, AidingKind, AidingOrigin, ServiceKind};

use crate::client::Client;
use crate::error::{AidingError, CameraNameError, ConnectError};
use crate::frame::{Body, Rotation, World};
use crate::pose_stream::PoseStream;
use crate::time::Time;

/// Offers measurements to one camera's lane: speed, position, pose, velocity.
///
/// The daemon weighs each by its covariance, at the time it was valid, up to two seconds ago, and refuses
/// what does not fit ([`crate::CameraPose::aids_used`] and [`crate::CameraPose::aids_refused`] tell).
/// A speed counts only where the camera is configured to sit on a vehicle.
///
/// ```no_run
/// use lodestone_client::{Client, monotonic_now_ns};
///
/// let mut front = Client::connect()?.aiding("front")?;
/// loop {
///     let wheel_speed_m_s = 8.3; // from the vehicle's bus
///     front.speed(monotonic_now_ns(), wheel_speed_m_s, Some(0.05))?;
///     std::thread::sleep(std::time::Duration::from_millis(20));
/// }
/// # #[allow(unreachable_code)]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct AidingPublisher {
    client: Client,
    poses: PoseStream,
    port: Option<Port>,
    origin: AidingOrigin,
    lever_arm_m: DVec3,
    anchor: Option<PoseStream>,
    sequence: u64,
}

struct Port {
    publisher: Publisher<ipc::Service, Aiding, ()>,
    /// The service stays in existence while this is held.
    _service: PublishSubscribe<Aiding>,
}

impl AidingPublisher {
    pub(crate) fn new(client: Client, poses: PoseStream) -> Self {
        let (origin, lever_arm_m) = (AidingOrigin::Other, DVec3::ZERO);
        Self { client, poses, port: None, origin, lever_arm_m, anchor: None, sequence: 0 }
    }

    /// Says what the measurements are made with; default [`AidingOrigin::Other`].
    #[must_use]
    pub const fn made_with(mut self, origin: AidingOrigin) -> Self {
        self.origin = origin;
        self
    }

    /// Says which point is measured: an antenna, from the camera's body origin in the body frame, m.
    #[must_use]
    pub const fn at_lever_arm(mut self, lever_arm_m: DVec3) -> Self {
        self.lever_arm_m = lever_arm_m;
        self
    }

    /// Says that poses are measured against another camera, the anchor: its own uncertainty is then the
    /// daemon's to add, and the two fit each other as well as they were measured.
    ///
    /// What [`Self::pose`] takes must then be in the world by the anchor's pose as published for that time, and
    /// its covariances those of the measurement alone; [`Self::relative_pose`] sees to it. Other measurements
    /// than poses are refused by the daemon.
    ///
    /// # Errors
    /// [`CameraNameError`].
    pub fn anchored_to(mut self, camera: &str) -> Result<Self, CameraNameError> {
        self.anchor = Some(self.client.poses(camera)?);
        Ok(self)
    }

    /// Whether the lane, and its anchor, are heard of, so that a measurement can be addressed.
    ///
    /// A measurement that is made rarely, and soon too old, had better not begin with listening for them: ask
    /// now and then before.
    pub fn is_ready(&mut self) -> bool {
        let anchor = self.anchor.as_mut().is_none_or(|anchor| anchor.latest().is_ok());
        self.poses.latest().is_ok() && anchor
    }

    /// Where this camera is in the body axes of its anchor, `p_anchor = R p + D`: D, m, with its covariance,
    /// m², and R with its covariance as a small rotation vector, rad², all in the anchor's axes; valid at a
    /// time of `CLOCK_MONOTONIC`, ns, for which the anchor's pose is looked up.
    ///
    /// # Errors
    /// [`AidingError`].
    pub fn relative_pose(
        &mut self,
        time_ns: i64,
        (distance_m, covariance_m2): (DVec3, DMat3),
        (orientation, covariance_rad2): (Rotation<Body, Body>, DMat3),
    ) -> Result<(), AidingError> {
        let anchor = self.anchor.as_mut().ok_or(AidingError::NoAnchor)?;
        let world_from_anchor = anchor.lookup(Time::Monotonic(time_ns))?.world_from_body()?;
        let by_anchor = world_from_anchor.rotation();
        let turn = by_anchor.matrix();
        let in_world = |m: DMat3| symmetric(turn * m * turn.transpose());
        self.pose(
            time_ns,
            (world_from_anchor.apply(distance_m), in_world(covariance_m2)),
            (by_anchor * orientation, in_world(covariance_rad2)),
        )
    }

    /// Forward speed of the vehicle, m/s, backwards negative, valid at a time of `CLOCK_MONOTONIC`, ns; with
    /// its standard deviation, or the daemon's own guess.
    ///
    /// # Errors
    /// [`AidingError`].
    pub fn speed(
        &mut self,
        time_ns: i64,
        speed_m_s: f64,
        sigma_m_s: Option<f64>,
    ) -> Result<(), AidingError> {
        let mut message = blank(AidingKind::ForwardSpeed, time_ns);
        message.value[0] = finite("speed", speed_m_s)?;
        if let Some(sigma) = sigma_m_s {
            message.value_covariance[0] = positive("sigma", sigma)?.powi(2);
        }
        self.send(message)
    }

    /// Position in the world, m, with its covariance, m², valid at a time of `CLOCK_MONOTONIC`, ns.
    ///
    /// # Errors
    /// [`AidingError`].
    pub fn position(
        &mut self,
        time_ns: i64,
        position_m: DVec3,
        covariance_m2: DMat3,
    ) -> Result<(), AidingError> {
        self.vector(AidingKind::Position, time_ns, position_m, covariance_m2)
    }

    /// Velocity in the world, m/s, with its covariance, (m/s)², valid at a time of `CLOCK_MONOTONIC`, ns.
    ///
    /// # Errors
    /// [`AidingError`].
    pub fn velocity(
        &mut self,
        time_ns: i64,
        velocity_m_s: DVec3,
        covariance_m2_s2: DMat3,
    ) -> Result<(), AidingError> {
        self.vector(AidingKind::Velocity, time_ns, velocity_m_s, covariance_m2_s2)
    }

    /// Position and orientation in the world with their covariances, m² and rad² about the world's axes, valid
    /// at a time of `CLOCK_MONOTONIC`, ns.
    ///
    /// # Errors
    /// [`AidingError`].
    pub fn pose(
        &mut self,
        time_ns: i64,
        (position_m, covariance_m2): (DVec3, DMat3),
        (orientation, covariance_rad2): (Rotation<World, Body>, DMat3),
    ) -> Result<(), AidingError> {
        let mut message = blank(AidingKind::Pose, time_ns);
        message.value = vector("position", position_m)?;
        message.value_covariance = upper_triangle("covariance", covariance_m2)?;
        message.orientation = orientation.quaternion().to_array();
        message.orientation_covariance_rad2 =
            upper_triangle("orientation covariance", covariance_rad2)?;
        self.send(message)
    }

    fn vector(
        &mut self,
        kind: AidingKind,
        time_ns: i64,
        value: DVec3,
        covariance: DMat3,
    ) -> Result<(), AidingError> {
        let mut message = blank(kind, time_ns);
        message.value = vector("value", value)?;
        message.value_covariance = upper_triangle("covariance", covariance)?;
        self.send(message)
    }

    fn send(&mut self, mut message: Aiding) -> Result<(), AidingError> {
        // The lane's poses tell which camera and which world it is, also after a restart.
        let latest = self.poses.latest()?;
        message.camera_id = latest.camera_id();
        message.world_epoch = latest.world_epoch();
        if let Some(anchor) = &mut self.anchor {
            // Cameras count from 0, and 0 is none.
            message.anchor =
                u16::try_from(anchor.latest()?.camera_id()).map_or(u16::MAX, |id| id + 1);
        }
        message.origin = self.origin.code();
        message.lever_arm_m = self.lever_arm_m.to_array();
        message.sequence = self.sequence;
        let port = match &mut self.port {
            Some(port) => port,
            none => none.insert(open(&self.client, self.poses.camera())?),
        };
        let sent = port.publisher.send_copy(message).map_err(|error| error.to_string());
        match sent {
            // Nobody listens: the daemon went, and a new one may have made the service anew.
            Ok(0) => {
                self.port = None;
                Err(AidingError::NobodyListens)
            }
            Ok(_) => {
                self.sequence += 1;
                Ok(())
            }
            Err(what) => {
                self.port = None;
                Err(AidingError::Transport { what })
            }
        }
    }
}

fn open(client: &Client, camera: &str) -> Result<Port, ConnectError> {
    let node = client.node()?;
    let service = open_for_reading::<Aiding>(&node, ServiceKind::Aiding, camera)?;
    let publisher = service.publisher_builder().create().map_err(|error| {
        ConnectError::Transport { camera: camera.into(), what: error.to_string() }
    })?;
    Ok(Port { publisher, _service: service })
}

const fn blank(kind: AidingKind, time_ns: i64) -> Aiding {
    Aiding {
        sequence: 0,
        camera_id: 0,
        world_epoch: 0,
        kind: kind.code(),
        origin: 0,
        anchor: 0,
        reserved: [0; 4],
        time_ns,
        value: [f64::NAN; 3],
        orientation: [f64::NAN; 4],
        value_covariance: [f64::NAN; 6],
        orientation_covariance_rad2: [f64::NAN; 6],
        lever_arm_m: [0.0; 3],
    }
}

fn finite(what: &'static str, value: f64) -> Result<f64, AidingError> {
    if value.is_finite() { Ok(value) } else { Err(AidingError::NotFinite { what }) }
}

fn positive(what: &'static str, value: f64) -> Result<f64, AidingError> {
    if finite(what, value)? > 0.0 { Ok(value) } else { Err(AidingError::NotPositive { what }) }
}

fn vector(what: &'static str, value: DVec3) -> Result<[f64; 3], AidingError> {
    if value.is_finite() { Ok(value.to_array()) } else { Err(AidingError::NotFinite { what }) }
}

/// Rounding must not tell the two halves apart.
fn symmetric(m: DMat3) -> DMat3 {
    (m + m.transpose()) * 0.5
}

/// `xx xy xz yy yz zz`.
fn upper_triangle(what: &'static str, c: DMat3) -> Result<[f64; 6], AidingError> {
    if !c.is_finite() {
        return Err(AidingError::NotFinite { what });
    }
    for axis in 0..3 {
        positive(what, c.col(axis)[axis])?;
    }
    Ok([c.x_axis.x, c.y_axis.x, c.z_axis.x, c.y_axis.y, c.z_axis.y, c.z_axis.z])
}

impl fmt::Debug for AidingPublisher {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("AidingPublisher")
            .field("camera", &self.poses.camera())
            .field("anchor", &self.anchor.as_ref().map(PoseStream::camera))
            .field("connected", &self.port.is_some())
            .field("sent", &self.sequence)
            .finish_non_exhaustive()
    }
}
