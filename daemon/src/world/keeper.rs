//! Looks after the world beside the lanes: patience, reset, the file, the message.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DMat3, DQuat, DVec3};
use lodestone_config::model::{Config, North};
use lodestone_config::{KEPT_WORLD_FORMAT, KeptCamera, KeptSource, KeptWorld, Loaded};
use lodestone_fusion::{is_position_known, so3};
use lodestone_schema::{DistanceSource, NorthKind, World, WorldState};

use super::founding::Founding;
use super::frame::{WorldFrame, WorldPhase};
use super::membership::Place;
use super::motion::Motion;
use super::pairs::field_of;
use super::store::{self, Epochs, StoreError};
use crate::driver::synthetic::EarthField;
use crate::reading::HostTime;

/// Between two writings of the file, where anything has changed.
const BETWEEN_WRITINGS: Duration = Duration::from_secs(2);
/// Changes of a position and its sigma below this are not worth a writing, m.
const NOTABLE_M: f64 = 0.01;
/// A camera whose last pose is older than this is not there, ns.
const THERE_NS: i64 = 500_000_000;

/// The world beside the lanes.
#[derive(Debug)]
pub struct Keeper {
    frame: Arc<WorldFrame>,
    /// Names of the members: cameras, then bodies.
    names: Vec<String>,
    /// Which members have a start.
    with_start: Vec<bool>,
    file: Option<PathBuf>,
    epochs: Epochs,
    patience: Duration,
    blank: World,
    north: North,
    /// The world as it is kept, and whether an earlier run fixed it; `None` while it waits.
    known: Option<(KeptWorld, WorldState)>,
    waiting_since: Instant,
    last_writing: Option<Instant>,
    written: Option<KeptWorld>,
    sequence: u64,
}

/// The world that a run of the daemon begins with.
#[derive(Debug)]
pub struct Beginning {
    /// What lanes share.
    pub frame: Arc<WorldFrame>,
    /// Where each member was in the last run, as far as it was kept.
    pub places: Vec<Option<Place>>,
}

impl Keeper {
    /// The world of a configuration, with what was kept of it.
    pub fn begin(loaded: &Loaded, kept: Option<KeptWorld>) -> (Self, Beginning) {
        let config = &loaded.config;
        let bodies = config.body.iter().map(|body| body.name.clone());
        let names: Vec<String> =
            config.camera.iter().map(|camera| camera.name.clone()).chain(bodies).collect();
        let epochs = Epochs::of(&config.shared_memory.root);
        if let Some(kept) = &kept {
            // A later world that is not kept must not bear an old number.
            complain(epochs.note(kept.epoch.max(epochs.next() - 1)));
        }
        let phase = match &kept {
            Some(kept) => WorldPhase {
                epoch: kept.epoch,
                fixed: true,
                starts_hold: kept.starts_hold,
                member: index_of(&names, &kept.first_camera),
            },
            None => WorldPhase::waiting(epochs.next()),
        };
        let frame = Arc::new(WorldFrame::new(names.len(), phase));
        let places = names.iter().map(|name| place_of(kept.as_ref()?, name, config)).collect();
        let with_start = config.camera.iter().map(|camera| camera.start.is_some());
        let keeper = Self {
            with_start: with_start.chain(config.body.iter().map(|_| false)).collect(),
            names,
            file: loaded.kept_world_path(),
            epochs,
            patience: Duration::from_secs_f64(config.world.patience_s),
            blank: blank_of(config),
            north: config.world.north,
            known: kept.map(|kept| (kept, WorldState::Restored)),
            waiting_since: Instant::now(),
            last_writing: None,
            written: None,
            sequence: 0,
            frame: Arc::clone(&frame),
        };
        (keeper, Beginning { frame, places })
    }

    /// What lanes share.
    pub const fn frame(&self) -> &Arc<WorldFrame> {
        &self.frame
    }

    /// Looks at the world: whether it was fixed, whether somebody else must fix it, whether it is to be
    /// written.
    pub fn look(&mut self, now: HostTime, unix_offset_ns: i64) {
        let phase = self.frame.phase();
        if !phase.fixed {
            self.look_for_founder(phase, now);
        } else if self.known.as_ref().is_none_or(|(known, _)| known.epoch != phase.epoch) {
            self.take_note(phase, unix_offset_ns);
        }
        if self.last_writing.is_none_or(|last| last.elapsed() >= BETWEEN_WRITINGS) {
            self.write_if_changed();
        }
    }

    /// Whether the message would say how the world is: between fixing it and saying how, a lane may be
    /// interrupted.
    pub fn is_up_to_date(&self) -> bool {
        let phase = self.frame.phase();
        let known = self.known.as_ref().map(|(known, _)| known.epoch);
        known == phase.fixed.then_some(phase.epoch)
    }

    /// Ends the world: the first camera that is aligned fixes the next one.
    pub fn reset(&mut self) {
        if self.frame.end() {
            tracing::info!("the world is defined anew");
            (self.known, self.waiting_since) = (None, Instant::now());
        }
    }

    /// Writes the file a last time.
    pub fn finish(&mut self) {
        self.write_if_changed();
    }

    /// Whoever may fix the world but is not there is passed over after a while: by one that has a start,
    /// so that the starts of the others hold, else by the next one.
    fn look_for_founder(&mut self, phase: WorldPhase, now: HostTime) {
        let there = |member: usize| {
            let motion = self.frame.motion(member);
            motion.is_some_and(|motion| now.as_nanos() - motion.time_ns < THERE_NS)
        };
        let chosen = phase.member.map(usize::from);
        if self.waiting_since.elapsed() < self.patience || chosen.is_some_and(there) {
            return;
        }
        let mut with_start = (0..self.names.len()).filter(|&m| self.with_start[m] && there(m));
        let next = with_start.next().or_else(|| (0..self.names.len()).find(|&m| there(m)));
        if let Some(next) = next
            && self.frame.pass_on(phase, next as u16)
        {
            let (first, next) = (&self.names[chosen.unwrap_or(0)], &self.names[next]);
            tracing::warn!("{first} is not there: {next} fixes the world");
        }
    }

    /// A lane has fixed the world.
    fn take_note(&mut self, phase: WorldPhase, unix_offset_ns: i64) {
        let Some(member) = phase.member.map(usize::from) else { return };
        // The lane says how right after it has fixed it.
        let Some(founding) = self.frame.founding(member, phase.epoch) else { return };
        let name = &self.names[member];
        tracing::info!(epoch = phase.epoch, "{name} has fixed the world");
        let known = self.kept_of(phase, &founding, name.clone(), unix_offset_ns);
        self.known = Some((known, WorldState::Fixed));
        self.last_writing = None;
        complain(self.epochs.note(phase.epoch));
    }

    fn kept_of(
        &self,
        phase: WorldPhase,
        founding: &Founding,
        first_camera: String,
        unix_offset_ns: i64,
    ) -> KeptWorld {
        KeptWorld {
            format: KEPT_WORLD_FORMAT,
            epoch: phase.epoch,
            t0_unix_ns: founding.time.as_nanos().saturating_add(unix_offset_ns),
            north: self.north,
            first_camera,
            starts_hold: phase.starts_hold,
            rotation_rad: so3::log(founding.orientation).to_array(),
            // A heading that counts from the start alone may be anything.
            heading_sigma_rad: finite_or(founding.heading_sigma_rad, core::f64::consts::PI),
            tilt_sigma_rad: founding.tilt_sigma_rad,
            field_ut: founding.field_ut.map(DVec3::into),
            magnetometer_position_m: founding.origin_in_body_m.to_array(),
            camera: Vec::new(),
        }
    }

    fn write_if_changed(&mut self) {
        let (Some(file), Some((known, _))) = (&self.file, &self.known) else { return };
        let camera = self.kept_cameras(known);
        let now = KeptWorld { camera, ..known.clone() };
        if self.written.as_ref().is_some_and(|written| !differs(written, &now)) {
            return;
        }
        complain(store::write(file, &now));
        self.last_writing = Some(Instant::now());
        self.written = Some(now);
    }

    /// Where each member was last; of those not seen in this run, what the file said.
    fn kept_cameras(&self, known: &KeptWorld) -> Vec<KeptCamera> {
        let before = self.written.as_ref().filter(|written| written.epoch == known.epoch);
        let before = &before.unwrap_or(known).camera;
        let seen: Vec<KeptCamera> = (0..self.names.len())
            .filter_map(|member| {
                let motion = self.frame.motion(member)?;
                kept_camera(&self.names[member], &motion, known.epoch)
            })
            .collect();
        let unseen = before.iter().filter(|old| seen.iter().all(|new| new.name != old.name));
        unseen.cloned().chain(seen.clone()).collect()
    }

    /// The world's message.
    pub fn message(&mut self, now: HostTime, unix_offset_ns: i64) -> World {
        let sequence = self.sequence;
        self.sequence += 1;
        let head = World {
            sequence,
            time_ns: now.as_nanos(),
            unix_offset_ns,
            kept: self.file.is_some().into(),
            ..self.blank
        };
        let phase = self.frame.phase();
        match &self.known {
            Some((known, state)) if phase.fixed && known.epoch == phase.epoch => {
                World { state: state.code(), ..self.filled(head, known) }
            }
            _ => head,
        }
    }

    fn filled(&self, head: World, known: &KeptWorld) -> World {
        let field = known.field_ut.map_or(DVec3::NAN, DVec3::from);
        let first = index_of(&self.names, &known.first_camera);
        World {
            t0_unix_ns: known.t0_unix_ns,
            epoch: known.epoch,
            first_camera_id: first.map_or(u32::MAX, u32::from),
            first_camera: field_of(&known.first_camera),
            field_norm_ut: field.length(),
            field_dip_rad: (-field.z / field.length()).asin(),
            heading_sigma_rad: known.heading_sigma_rad,
            tilt_sigma_rad: known.tilt_sigma_rad,
            first_orientation: rotation(known.rotation_rad).to_array(),
            magnetometer_position_m: known.magnetometer_position_m,
            ..head
        }
    }
}

fn rotation(vector: [f64; 3]) -> DQuat {
    so3::exp(vector.into())
}

fn finite_or(value: f64, otherwise: f64) -> f64 {
    if value.is_finite() { value } else { otherwise }
}

fn index_of(names: &[String], name: &str) -> Option<u16> {
    names.iter().position(|known| known == name).map(|index| index as u16)
}

/// Where a member was in the last run, uncertain by how far it may have been moved since.
fn place_of(kept: &KeptWorld, name: &str, config: &Config) -> Option<Place> {
    let camera = kept.camera.iter().find(|camera| camera.name == name)?;
    let (sigma, moved) = (DVec3::from(camera.sigma_m), config.world.moved_sigma_m);
    Some(Place {
        position: camera.position_m.into(),
        covariance: DMat3::from_diagonal(sigma * sigma + DVec3::splat(moved * moved)),
        source: match camera.source {
            KeptSource::CommonStart => DistanceSource::CommonStart,
            KeptSource::CloudRegistration => DistanceSource::CloudRegistration,
            KeptSource::MagneticGradient => DistanceSource::MagneticGradient,
            KeptSource::PositionFix => DistanceSource::PositionFix,
        },
    })
}

/// What to keep of a member; `None` where its position is not known in this world.
fn kept_camera(name: &str, motion: &Motion, epoch: u32) -> Option<KeptCamera> {
    let covariance = motion.station.position_covariance;
    let source = match motion.source {
        DistanceSource::Unknown => return None,
        DistanceSource::Surveyed | DistanceSource::CommonStart => KeptSource::CommonStart,
        DistanceSource::CloudRegistration => KeptSource::CloudRegistration,
        DistanceSource::MagneticGradient => KeptSource::MagneticGradient,
        DistanceSource::PositionFix => KeptSource::PositionFix,
    };
    let variances = DVec3::new(covariance.x_axis.x, covariance.y_axis.y, covariance.z_axis.z);
    (motion.epoch == epoch && is_position_known(covariance)).then(|| KeptCamera {
        name: name.into(),
        position_m: motion.station.position.into(),
        sigma_m: variances.to_array().map(f64::sqrt),
        source,
    })
}

/// Whether the file is worth writing again.
fn differs(a: &KeptWorld, b: &KeptWorld) -> bool {
    let far = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).distance(b.into()) > NOTABLE_M;
    let other = |a: &KeptCamera, b: &KeptCamera| {
        a.name != b.name || far(a.position_m, b.position_m) || far(a.sigma_m, b.sigma_m)
    };
    let (cameras_a, cameras_b) = (&a.camera, &b.camera);
    a.epoch != b.epoch
        || cameras_a.len() != cameras_b.len()
        || cameras_a.iter().zip(cameras_b).any(|(a, b)| other(a, b))
}

fn complain(result: Result<(), StoreError>) {
    if let Err(error) = result {
        tracing::error!("the world is not kept: {error}");
    }
}

fn blank_of(config: &Config) -> World {
    let earth = EarthField::of(&config.world);
    World {
        north: match config.world.north {
            North::Magnetic => NorthKind::Magnetic.code(),
            North::True => NorthKind::True.code(),
        },
        declination_rad: earth.map_or(f64::NAN, |earth| earth.declination_rad),
        latitude_deg: config.world.latitude_deg,
        longitude_deg: config.world.longitude_deg,
        altitude_m: config.world.altitude_m,
        ..unknown()
    }
}

/// A message of which nothing is known.
pub(crate) const fn unknown() -> World {
    World {
        sequence: 0,
        time_ns: 0,
        unix_offset_ns: 0,
        t0_unix_ns: i64::MIN,
        epoch: 0,
        first_camera_id: u32::MAX,
        state: WorldState::Waiting.code(),
        north: NorthKind::Magnetic.code(),
        kept: 0,
        reserved: [0; 5],
        first_camera: [0; lodestone_schema::NAME_BYTES],
        declination_rad: f64::NAN,
        latitude_deg: f64::NAN,
        longitude_deg: f64::NAN,
        altitude_m: f64::NAN,
        field_norm_ut: f64::NAN,
        field_dip_rad: f64::NAN,
        heading_sigma_rad: f64::NAN,
        tilt_sigma_rad: f64::NAN,
        first_orientation: [f64::NAN; 4],
        magnetometer_position_m: [f64::NAN; 3],
    }
}
