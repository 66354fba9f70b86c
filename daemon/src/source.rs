//! The source of a camera's samples, as its configuration names it.

use std::path::Path;
use std::sync::Arc;

use lodestone_config::model::{Camera, DriverKind};
use lodestone_fusion::SensorTime;
use lodestone_schema::{Pose, Status, Validity};

use crate::commands::supervision::LaneContext;
use crate::driver::Driver;
use crate::driver::faulty::FaultyDriver;
use crate::driver::host_clock::OnHostClock;
use crate::driver::replay::{ReplayDriver, ReplayError};
use crate::driver::synthetic::{SyntheticDriver, SyntheticError, Truth, TruthSource};
use crate::driver::zed2::Zed2;
use crate::driver::zed2::discovery::OpenError;
use crate::publisher::blank_pose;
use crate::rig::is_member;
use crate::service::housekeeping::TruthProvider;
use crate::status_board::LaneBoard;

/// An opened source.
pub struct Source {
    /// The driver, with the configured faults around it.
    pub driver: Box<dyn Driver>,
    /// What really happens, where the world is simulated.
    pub truth: Option<Box<dyn TruthProvider>>,
    /// Host seconds in a sensor second: 1, or less for a recording played faster.
    pub host_rate: f64,
}

/// Why a source could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// A camera on USB.
    #[error(transparent)]
    Zed2(#[from] OpenError),
    /// A simulated world.
    #[error(transparent)]
    Synthetic(#[from] SyntheticError),
    /// A recording.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// Opens the source of one camera.
///
/// # Errors
/// [`SourceError`]; a camera that is only not plugged in is no error, it is waited for.
pub fn open(context: &LaneContext) -> Result<Source, SourceError> {
    let camera = context.settings();
    let source = match camera.driver {
        DriverKind::Zed2 => plain(zed2(camera)?),
        DriverKind::Synthetic => synthetic(context, camera)?,
        DriverKind::Replay => replay(context, camera)?,
    };
    Ok(with_faults(source, camera))
}

fn plain(driver: impl Driver + 'static) -> Source {
    Source { driver: Box::new(driver), truth: None, host_rate: 1.0 }
}

/// A source whose time may pass faster than the host's; at speed 0 as fast as it goes.
fn paced(driver: impl Driver + 'static, speed: f64) -> Source {
    if speed > 0.0 {
        return Source { host_rate: speed.recip(), ..plain(driver) };
    }
    plain(OnHostClock(driver))
}

fn zed2(camera: &Camera) -> Result<Zed2, OpenError> {
    Zed2::open(camera.serial).or_else(|e| match e {
        // It may be plugged in later.
        OpenError::Thread(_) => Err(e),
        absent => {
            tracing::warn!(camera = camera.name, "{absent}; waiting for it");
            Zed2::new(camera.serial)
        }
    })
}

fn synthetic(context: &LaneContext, camera: &Camera) -> Result<Source, SyntheticError> {
    let config = &context.loaded.config;
    let driver = if is_member(config, context.camera) {
        SyntheticDriver::riding(camera, config.leader_of(camera), &config.world)?
    } else {
        SyntheticDriver::new(camera, &config.world)?
    };
    let truth = BesideTheLane {
        truth: driver.truth_source(),
        board: Arc::clone(&context.board),
        camera_id: context.camera as u32,
        sequence: 0,
        last: SensorTime::from_nanos(0),
    };
    let speed = camera.synthetic.as_ref().map_or(1.0, |synthetic| synthetic.speed);
    Ok(Source { truth: Some(Box::new(truth)), ..paced(driver, speed) })
}

fn replay(context: &LaneContext, camera: &Camera) -> Result<Source, ReplayError> {
    let settings = camera.replay.clone().unwrap_or_default();
    let directory = context.loaded.path.parent().unwrap_or(Path::new(""));
    let driver = ReplayDriver::open(&settings, directory)?;
    Ok(paced(driver, settings.speed))
}

fn with_faults(source: Source, camera: &Camera) -> Source {
    if camera.fault.is_empty() {
        return source;
    }
    tracing::warn!(camera = camera.name, faults = camera.fault.len(), "faults will be injected");
    Source { driver: Box::new(FaultyDriver::new(source.driver, &camera.fault)), ..source }
}

/// The truth at the sensor time of the lane's latest pose, so that the two can be compared.
struct BesideTheLane {
    truth: TruthSource,
    board: Arc<LaneBoard>,
    camera_id: u32,
    sequence: u64,
    last: SensorTime,
}

impl TruthProvider for BesideTheLane {
    fn truth_at_now(&mut self) -> Option<Pose> {
        let latest = self.board.latest.read();
        let time = SensorTime::from_nanos(latest.sensor_time_ns);
        if latest.time_ns == 0 || time == self.last {
            return None;
        }
        self.last = time;
        let truth = self.truth.truth_at(time);
        let pose = Pose {
            sequence: self.sequence,
            camera_id: self.camera_id,
            sensor_time_ns: latest.sensor_time_ns,
            time_ns: latest.time_ns,
            arrival_time_ns: latest.time_ns,
            step_start_time_ns: latest.time_ns,
            step_end_time_ns: latest.time_ns,
            ..truth_message(&truth)
        };
        self.sequence += 1;
        Some(pose)
    }
}

/// The message that holds a truth, without its time.
pub(crate) fn truth_message(truth: &Truth) -> Pose {
    let known = Validity::TILT
        | Validity::HEADING
        | Validity::VELOCITY
        | Validity::POSITION
        | Validity::ANGULAR_RATE
        | Validity::SPECIFIC_FORCE
        | Validity::TIME;
    Pose {
        status: Status::INITIALISED.bits(),
        validity: known.bits(),
        position_m: truth.position_m.into(),
        velocity_m_s: truth.velocity_m_s.into(),
        orientation: truth.orientation.quaternion().to_array(),
        angular_rate_rad_s: truth.angular_rate_rad_s.into(),
        specific_force_m_s2: truth.specific_force.vector.into(),
        position_covariance_m2: [0.0; 6],
        velocity_covariance_m2_s2: [0.0; 6],
        orientation_covariance_rad2: [0.0; 6],
        ..blank_pose()
    }
}
