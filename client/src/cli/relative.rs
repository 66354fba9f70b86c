//! `lodestone relative`: each camera as the others have it.

use lodestone_client::{DistanceSource, RelativePose};
use serde::Serialize;

use super::args::RelativeArgs;
use super::describe::{bits, code};
use super::failure::Failure;
use super::json::numbers;
use super::output::Output;
use super::session::Session;
use super::status::or_dash;
use super::world::patiently;

/// One pair; `null` stands for what is unknown.
#[derive(Debug, Serialize)]
pub(super) struct RelativeLine {
    camera_a: String,
    camera_b: String,
    time_ns: i64,
    world_epoch: Option<u32>,
    angle_deg: Option<f64>,
    orientation_sigma_deg: Option<f64>,
    orientation_xyzw: Option<[f64; 4]>,
    orientation_covariance_rad2: Option<[f64; 6]>,
    field_correlation: Option<f64>,
    distance_m: Option<[f64; 3]>,
    distance_sigma_m: Option<f64>,
    distance_covariance_m2: Option<[f64; 6]>,
    distance_source: String,
    rigid: bool,
    valid: Vec<String>,
}

pub(super) fn run(session: &Session, args: &RelativeArgs) -> Result<(), Failure> {
    let cameras = session.cameras()?;
    let mut stream = match &args.cameras[..] {
        [a, b] => {
            for name in [a, b] {
                session.camera(Some(name))?;
            }
            session.client.relative(a, b)?
        }
        _ if cameras.len() < 2 => {
            return Err(Failure::Other("there is one camera only, and no pair".into()));
        }
        _ => session.client.relatives(),
    };
    let pairs = patiently(session, || stream.all().map(<[RelativePose]>::to_vec))?;
    let mut output = Output::new();
    for pair in &pairs {
        let line = RelativeLine::new(pair);
        if session.json { output.json(&line) } else { output.line(&line.to_text()) }?;
    }
    Ok(())
}

impl RelativeLine {
    pub(super) fn new(pair: &RelativePose) -> Self {
        let message = pair.message();
        let oriented = pair.orientation();
        let distance = pair.distance_m();
        Self {
            camera_a: pair.camera_a().into(),
            camera_b: pair.camera_b().into(),
            time_ns: pair.time_ns(),
            world_epoch: Some(message.world_epoch).filter(|&epoch| epoch > 0),
            angle_deg: pair.angle_rad().map(f64::to_degrees),
            orientation_sigma_deg: pair.orientation_sigma_rad().map(f64::to_degrees),
            orientation_xyzw: oriented.map(|r| r.quaternion().to_array()),
            orientation_covariance_rad2: oriented.map(|_| message.orientation_covariance_rad2),
            field_correlation: Some(message.field_correlation).filter(|c| c.is_finite()),
            distance_m: distance.map(|d| d.to_array()),
            distance_sigma_m: pair.distance_sigma_m(),
            distance_covariance_m2: distance.map(|_| message.distance_covariance_m2),
            distance_source: code(pair.distance_source()),
            rigid: pair.is_rigid(),
            valid: bits(pair.validity()),
        }
    }

    pub(super) fn to_text(&self) -> String {
        let Self { camera_a, camera_b, .. } = self;
        format!("{camera_b} in {camera_a}: {}; {}", self.turned(), self.distant())
    }

    fn turned(&self) -> String {
        match self.orientation_xyzw {
            None => "turned by an unknown angle".into(),
            Some(quaternion) => {
                // Cameras whose clouds were registered know it to hundredths of a degree.
                let is_close = self.orientation_sigma_deg.is_some_and(|sigma| sigma < 0.2);
                let decimals = if is_close { 3 } else { 1 };
                format!(
                    "turned by {}° ± {}°, {} xyzw",
                    or_dash(self.angle_deg, 1.0, decimals),
                    or_dash(self.orientation_sigma_deg, 1.0, decimals),
                    numbers(Some(&quaternion), 4)
                )
            }
        }
    }

    fn distant(&self) -> String {
        match &self.distance_m {
            None if self.distance_source == code(DistanceSource::Unknown) => {
                "distance unknown".into()
            }
            None => format!("distance too uncertain ({})", self.distance_source),
            Some(distance) => format!(
                "at {} ± {} m ({})",
                numbers(Some(distance), 3),
                or_dash(self.distance_sigma_m, 1.0, 3),
                self.distance_source
            ),
        }
    }
}
