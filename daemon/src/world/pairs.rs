//! Relative poses of all pairs of cameras.

use lodestone_config::model::{Camera, Config, ValidityBounds};
use lodestone_fusion::relative::{Apart, Mount, Relative, Station, mounted, relative, relative_by};
use lodestone_fusion::{Rotation, SensorTime};
use lodestone_schema::{DistanceSource, NAME_BYTES, Relative as Message, Validity, to_name};

use super::frame::WorldFrame;
use super::motion::Motion;
use super::ties;
use super::words::triangle;
use crate::lane::Core;
use crate::reading::HostTime;

/// Longest time over which a pose is carried to the instant of another one, s.
const LONGEST_CARRY_S: f64 = 0.1;
/// What is older than this is not known any more, s.
const STALE_S: f64 = 0.5;

/// Two cameras of the configuration, the earlier one first.
#[derive(Clone, Debug)]
pub struct Pair {
    cameras: [Side; 2],
    /// Both sit on one body, so.
    surveyed: Option<Relative>,
    bounds: ValidityBounds,
    message: Message,
}

#[derive(Clone, Debug)]
struct Side {
    member: usize,
    /// The body that carries it, and how.
    on_body: Option<(usize, Mount)>,
}

/// Camera b as camera a has it, in the world that both cores are in; `None` until both are aligned.
///
/// For cores whose readings are stamped by one clock: the older pose is carried on to the newer one's
/// instant.
pub fn relative_of(a: &Core, b: &Core) -> Option<Relative> {
    let (a, b) = (a.at_last_reading()?, b.at_last_reading()?);
    let between = |from: SensorTime, to: SensorTime| (to - from).as_secs_f64().max(0.0);
    let (station_a, station_b) = (a.station(), b.station());
    Some(relative(
        &station_a.carried(between(a.time, b.time)),
        &station_b.carried(between(b.time, a.time)),
    ))
}

impl Pair {
    /// Every pair of the configuration's cameras.
    pub fn all(config: &Config) -> Vec<Self> {
        let count = config.camera.len();
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        let mut pairs: Vec<Self> = pairs.map(|(a, b)| Self::new(config, a, b)).collect();
        let pair_count = pairs.len() as u32;
        for pair in &mut pairs {
            pair.message.pair_count = pair_count;
        }
        pairs
    }

    fn new(config: &Config, a: usize, b: usize) -> Self {
        let cameras = [side(config, a), side(config, b)];
        let surveyed = match (&cameras[0].on_body, &cameras[1].on_body) {
            (Some((body_a, a)), Some((body_b, b))) if body_a == body_b => Some(mounted(a, b)),
            _ => None,
        };
        let name = |camera: usize| field_of(&config.camera[camera].name);
        let message = Message {
            camera_a: a as u32,
            camera_b: b as u32,
            name_a: name(a),
            name_b: name(b),
            rigid: surveyed.is_some().into(),
            ..unknown()
        };
        Self { cameras, surveyed, bounds: config.estimator.validity, message }
    }

    /// The relative pose as it is now.
    pub fn message(&self, frame: &WorldFrame, now: HostTime, sequence: u64) -> Message {
        let blank = Message {
            sequence,
            time_ns: now.as_nanos(),
            world_epoch: frame.phase().published_epoch(),
            ..self.message
        };
        if let Some(surveyed) = &self.surveyed {
            return self.fill(blank, surveyed, DistanceSource::Surveyed, true);
        }
        let motions = [0, 1].map(|which| self.cameras[which].motion(frame, now));
        match motions {
            [Some(a), Some(b)] if a.epoch == b.epoch => {
                let members = [0, 1].map(|which| self.cameras[which].member);
                let apart = ties::apart(frame, members, now);
                self.fill_from_motions(blank, [&a, &b], apart)
            }
            _ => blank,
        }
    }

    fn fill_from_motions(
        &self,
        blank: Message,
        [a, b]: [&Motion; 2],
        apart: Option<[Apart; 2]>,
    ) -> Message {
        let time_ns = a.time_ns.max(b.time_ns);
        let behind_s = |motion: &Motion| (time_ns - motion.time_ns) as f64 * 1e-9;
        if behind_s(a).max(behind_s(b)) > LONGEST_CARRY_S {
            return blank;
        }
        let carried = |motion: &Motion| motion.station.carried(behind_s(motion));
        let (at_a, at_b) = (carried(a), carried(b));
        let found = match apart {
            // As surely as they are known where each of them was, and carried since.
            Some([by_a, by_b]) => relative_by(
                &at_a,
                &at_b,
                [&carried_on(&by_a, a, &at_a), &carried_on(&by_b, b, &at_b)],
            ),
            None => relative(&at_a, &at_b),
        };
        let known = a.heading_known && b.heading_known;
        // Before there is a world, each camera's place is but one to come.
        let found = if a.epoch == 0 { Relative { distance: None, ..found } } else { found };
        let source = distance_source(a.source, b.source);
        self.fill(Message { time_ns, world_epoch: a.epoch, ..blank }, &found, source, known)
    }

    fn fill(
        &self,
        blank: Message,
        found: &Relative,
        source: DistanceSource,
        heading_known: bool,
    ) -> Message {
        let mut message = Message {
            field_correlation: found.field_correlation,
            orientation: found.orientation.quaternion().to_array(),
            orientation_covariance_rad2: triangle(found.orientation_covariance),
            ..blank
        };
        if let Some(distance) = found.distance {
            message.distance_source = source.code();
            message.distance_m = distance.vector.to_array();
            message.distance_covariance_m2 = triangle(distance.covariance);
        }
        message.validity = validity(found, heading_known, &self.bounds).bits();
        message
    }
}

impl Side {
    /// The camera's own motion, or what its body's makes of it; `None` if neither is fresh.
    fn motion(&self, frame: &WorldFrame, now: HostTime) -> Option<Motion> {
        let fresh = |motion: &Motion| {
            let age_s = (now.as_nanos() - motion.time_ns) as f64 * 1e-9;
            age_s < STALE_S
        };
        if let Some(own) = frame.motion(self.member).filter(fresh) {
            return Some(own);
        }
        let (body, mount) = self.on_body.as_ref()?;
        let body = frame.motion(*body).filter(fresh)?;
        Some(Motion { station: mount.carried_by(&body.station), ..body })
    }
}

fn side(config: &Config, camera: usize) -> Side {
    let settings = &config.camera[camera];
    let body = settings.body.as_ref();
    let body = body.and_then(|name| config.body.iter().position(|body| body.name == *name));
    // Bodies count on after the cameras.
    let on_body = body.map(|body| (config.camera.len() + body, mount_of(settings)));
    Side { member: camera, on_body }
}

/// A name as the field of a message; the configuration allows none that is too long.
pub(super) fn field_of(name: &str) -> [u8; NAME_BYTES] {
    to_name(name).unwrap_or([0; NAME_BYTES])
}

/// How a camera is mounted, as configured.
pub(super) fn mount_of(camera: &Camera) -> Mount {
    let [roll, pitch, yaw] = camera.mounting.roll_pitch_yaw_deg.map(f64::to_radians);
    Mount {
        orientation: Rotation::from_yaw_pitch_roll(yaw, pitch, roll),
        position: camera.mounting.position_m.into(),
        rotation_sigma_rad: camera.mounting.rotation_sigma_deg.to_radians(),
        position_sigma_m: camera.mounting.position_sigma_m,
    }
}

/// What carrying a pose to another instant adds to how far it is from another one.
fn carried_on(apart: &Apart, from: &Motion, to: &Station) -> Apart {
    Apart {
        orientation: apart.orientation + to.orientation_covariance
            - from.station.orientation_covariance,
        position: apart.position + to.position_covariance - from.station.position_covariance,
    }
}

/// Of two sources the one that says more about the distance: a fix of either camera is younger than
/// where it began.
fn distance_source(a: DistanceSource, b: DistanceSource) -> DistanceSource {
    use DistanceSource as S;
    if a == S::Unknown || b == S::Unknown {
        return S::Unknown;
    }
    [S::CloudRegistration, S::PositionFix, S::MagneticGradient]
        .into_iter()
        .find(|source| a == *source || b == *source)
        .unwrap_or(S::CommonStart)
}

/// A value is valid while its standard deviation is within the bound that holds for poses.
fn validity(found: &Relative, heading_known: bool, bounds: &ValidityBounds) -> Validity {
    let worst = |m: glam::DMat3| m.x_axis.x.max(m.y_axis.y).max(m.z_axis.z).sqrt();
    let rotation = worst(found.orientation_covariance);
    let mut validity = Validity::TIME;
    let turned = heading_known && rotation < bounds.heading_sigma_deg.to_radians();
    validity.set(Validity::TILT | Validity::HEADING, turned);
    let near = found.distance.is_some_and(|d| worst(d.covariance) < bounds.position_sigma_m);
    validity.set(Validity::POSITION, near);
    validity
}

/// A message of which nothing is known.
pub(crate) const fn unknown() -> Message {
    Message {
        sequence: 0,
        time_ns: 0,
        camera_a: 0,
        camera_b: 0,
        name_a: [0; NAME_BYTES],
        name_b: [0; NAME_BYTES],
        world_epoch: 0,
        pair_count: 0,
        validity: 0,
        distance_source: DistanceSource::Unknown.code(),
        rigid: 0,
        reserved: [0; 2],
        field_correlation: f64::NAN,
        orientation: [f64::NAN; 4],
        orientation_covariance_rad2: [f64::NAN; 6],
        distance_m: [f64::NAN; 3],
        distance_covariance_m2: [f64::NAN; 6],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_is_named_after_the_youngest_knowledge_of_either_camera() {
        use DistanceSource as S;
        assert_eq!(distance_source(S::CommonStart, S::CommonStart), S::CommonStart);
        assert_eq!(distance_source(S::CommonStart, S::Unknown), S::Unknown);
        assert_eq!(distance_source(S::PositionFix, S::CommonStart), S::PositionFix);
        assert_eq!(distance_source(S::PositionFix, S::CloudRegistration), S::CloudRegistration);
        assert_eq!(distance_source(S::MagneticGradient, S::CommonStart), S::MagneticGradient);
    }

    #[test]
    fn three_cameras_make_three_pairs_and_one_makes_none() {
        let named = |name: &str| Camera { name: name.into(), ..Camera::default() };
        let with = |names: &[&str]| Config {
            camera: names.iter().map(|name| named(name)).collect(),
            ..Config::default()
        };
        assert!(Pair::all(&with(&["front"])).is_empty());
        let pairs = Pair::all(&with(&["a", "b", "c"]));
        let ids: Vec<_> = pairs.iter().map(|p| (p.message.camera_a, p.message.camera_b)).collect();
        assert_eq!(ids, [(0, 1), (0, 2), (1, 2)]);
        assert!(pairs.iter().all(|pair| pair.message.pair_count == 3));
    }
}
