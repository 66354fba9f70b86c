//! `lodestone world`: what all cameras share.

use std::time::{Duration, Instant};

use lodestone_client::{NorthKind, RequestError, StreamError, WorldInfo, WorldState};
use serde::Serialize;

use super::args::{WorldAction, WorldArgs};
use super::describe::code;
use super::failure::Failure;
use super::output::Output;
use super::session::Session;
use super::status::or_dash;

/// The world is published once a second.
const PATIENCE: Duration = Duration::from_millis(1500);
/// The next look of the daemon, and its first camera's next step; a message a second.
const RESET_PATIENCE: Duration = Duration::from_secs(3);
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

/// The world; `null` stands for what is unknown.
#[derive(Debug, Serialize)]
pub(super) struct WorldLine {
    state: String,
    epoch: Option<u32>,
    kept: bool,
    t0_unix_ns: Option<i64>,
    first_camera: Option<String>,
    north: String,
    declination_deg: Option<f64>,
    field_norm_ut: Option<f64>,
    field_dip_deg: Option<f64>,
    heading_sigma_deg: Option<f64>,
    tilt_sigma_deg: Option<f64>,
    first_orientation_xyzw: Option<[f64; 4]>,
    magnetometer_position_m: Option<[f64; 3]>,
    age_s: Option<f64>,
}

pub(super) fn run(session: &Session, args: &WorldArgs) -> Result<(), Failure> {
    // Whether there is a daemon at all, and of this version, the cameras tell.
    session.cameras()?;
    let world = match args.action {
        Some(WorldAction::Reset) => session.client.reinitialise_world(RESET_PATIENCE)?,
        None => read(session)?,
    };
    let line = WorldLine::new(&world);
    let mut output = Output::new();
    if session.json { output.json(&line) } else { output.line(&line.to_text()) }
}

fn read(session: &Session) -> Result<WorldInfo, Failure> {
    let mut stream = session.client.world();
    patiently(session, || stream.latest())
}

/// Looks until there is something, or patience or the user ends it.
pub(super) fn patiently<T>(
    session: &Session,
    mut look: impl FnMut() -> Result<T, StreamError>,
) -> Result<T, Failure> {
    let end = Instant::now() + PATIENCE;
    loop {
        match look() {
            Err(_) if Instant::now() < end && !session.stop.asked() => {
                session.stop.sleep_until(Instant::now() + BETWEEN_LOOKS);
            }
            done => return Ok(done?),
        }
    }
}

impl WorldLine {
    fn new(world: &WorldInfo) -> Self {
        let degrees = |rad: Option<f64>| rad.map(f64::to_degrees);
        let t0_unix_ns = world.t0_unix_ns();
        let m = world.message();
        let now_unix_ns = m.time_ns.saturating_add(m.unix_offset_ns);
        Self {
            state: code(world.state()),
            epoch: world.epoch(),
            kept: world.is_kept(),
            t0_unix_ns,
            first_camera: world.first_camera().map(Into::into),
            north: code(world.north()),
            declination_deg: degrees(world.declination_rad()),
            field_norm_ut: world.field_norm_ut(),
            field_dip_deg: degrees(world.field_dip_rad()),
            heading_sigma_deg: degrees(world.heading_sigma_rad()),
            tilt_sigma_deg: degrees(world.tilt_sigma_rad()),
            first_orientation_xyzw: world.first_orientation().map(|q| q.to_array()),
            magnetometer_position_m: world.magnetometer_position_m().map(|v| v.to_array()),
            age_s: t0_unix_ns.map(|t0| now_unix_ns.saturating_sub(t0) as f64 * 1e-9),
        }
    }

    fn to_text(&self) -> String {
        let Some(epoch) = self.epoch else {
            let advice = "no camera is aligned yet";
            return format!("world: {}, {advice}; y to {} north", self.state, self.north);
        };
        let kept = if self.kept { "kept across restarts" } else { "not kept across restarts" };
        [
            format!("world {epoch}: {}, {kept}", self.state),
            format!(
                "  fixed     by {} {} s ago, heading ± {}°, tilt ± {}°",
                self.first_camera.as_deref().unwrap_or("an unknown camera"),
                or_dash(self.age_s, 1.0, 1),
                or_dash(self.heading_sigma_deg, 1.0, 1),
                or_dash(self.tilt_sigma_deg, 1.0, 2),
            ),
            format!(
                "  axes      x east, y {} north, z up; declination {}°",
                self.north,
                or_dash(self.declination_deg, 1.0, 1)
            ),
            format!(
                "  field     {} µT, dip {}°",
                or_dash(self.field_norm_ut, 1.0, 1),
                or_dash(self.field_dip_deg, 1.0, 1)
            ),
        ]
        .join("\n")
    }
}

/// One line about the world, for a status of everything.
pub(super) fn headline(world: &WorldInfo) -> String {
    let north = match world.north() {
        NorthKind::Magnetic => "magnetic",
        NorthKind::True => "true",
    };
    match (world.state(), world.epoch()) {
        (WorldState::Waiting, _) | (_, None) => "world: waits for a camera to be aligned".into(),
        (state, Some(epoch)) => format!(
            "world {epoch}: {} by {}, y to {north} north",
            code(state),
            world.first_camera().unwrap_or("an unknown camera")
        ),
    }
}

impl From<RequestError> for Failure {
    fn from(error: RequestError) -> Self {
        Self::Other(error.to_string())
    }
}
