//! `lodestone status`.

use std::time::{Duration, Instant};

use lodestone_client::{RelativePose, WorldInfo};

use super::args::StatusArgs;
use super::failure::Failure;
use super::json::{heading, numbers};
use super::output::Output;
use super::relative::RelativeLine;
use super::report::{Monitor, Report};
use super::session::Session;
use super::world::{headline, patiently};

/// Health comes once a second, and a late consumer gets it with the next one at the latest.
const PATIENCE: Duration = Duration::from_millis(1500);
const BETWEEN_LOOKS: Duration = Duration::from_millis(20);

pub(super) fn run(session: &Session, args: &StatusArgs) -> Result<(), Failure> {
    let cameras = match &args.camera {
        Some(camera) => vec![session.camera(Some(camera))?],
        None => session.cameras()?,
    };
    let monitors: Result<Vec<_>, _> =
        cameras.iter().map(|camera| Monitor::new(&session.client, camera)).collect();
    let mut monitors = monitors?;
    listen(session, &mut monitors);
    if !monitors.iter_mut().any(Monitor::has_anything) {
        return Err(dead(session, &cameras));
    }
    let mut output = Output::new();
    let shared = Shared::listen(session, cameras.len() > 1);
    if let (Some(world), false) = (&shared.world, session.json) {
        output.line(&headline(world))?;
    }
    for mut report in monitors.iter_mut().map(Monitor::report) {
        report.relative = shared.pairs_of(&report.camera);
        if session.json {
            output.json(&report)?;
        } else {
            output.line(&text(&report))?;
        }
    }
    Ok(())
}

/// What belongs to no single camera.
struct Shared {
    world: Option<WorldInfo>,
    pairs: Vec<RelativePose>,
}

impl Shared {
    /// What comes within a short time; a daemon with one camera has no pairs.
    fn listen(session: &Session, has_pairs: bool) -> Self {
        let (mut world, mut pairs) = (session.client.world(), session.client.relatives());
        let both = || {
            let world = world.latest()?;
            let pairs = if has_pairs { pairs.all()?.to_vec() } else { Vec::new() };
            Ok((world, pairs))
        };
        let (world, pairs) = patiently(session, both).ok().unzip();
        Self { world, pairs: pairs.unwrap_or_default() }
    }

    /// The pairs in which the camera is the first.
    fn pairs_of(&self, camera: &str) -> Vec<RelativeLine> {
        let first = self.pairs.iter().filter(|pair| pair.camera_a() == camera);
        first.map(RelativeLine::new).collect()
    }
}

fn listen(session: &Session, monitors: &mut [Monitor]) {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end && !session.stop.asked() {
        // Every monitor must look, so that each gets connected.
        let complete = monitors.iter_mut().filter_map(|m| m.is_complete().then_some(())).count();
        if complete == monitors.len() {
            return;
        }
        session.stop.sleep_until(Instant::now() + BETWEEN_LOOKS);
    }
}

fn dead(session: &Session, cameras: &[String]) -> Failure {
    Failure::Other(format!(
        "{} (files of {} are left from an earlier run, but nobody publishes)",
        session.nobody(),
        cameras.join(", ")
    ))
}

fn text(r: &Report) -> String {
    let serial = r.serial.map_or_else(String::new, |serial| format!("  serial {serial}"));
    let mut lines = vec![
        format!("{}: {}{serial}", r.camera, r.state),
        format!(
            "  rate      {}{} poses/s; arrival to published {} ms (p50), {} ms (p99)",
            samples(r),
            or_dash(r.pose_rate_hz, 1.0, 1),
            or_dash(r.latency_p50_s, 1e3, 3),
            or_dash(r.latency_p99_s, 1e3, 3),
        ),
        format!(
            "  heading   {} clockwise from north ({})",
            heading(r.heading_deg, r.heading_sigma_deg),
            r.heading_source.as_deref().unwrap_or("no pose"),
        ),
        format!(
            "  position  {} ({})",
            position(r),
            r.position_source.as_deref().unwrap_or("no pose"),
        ),
        format!(
            "  lost      {} by the sensor, {} dropped, {} steps bridged",
            count(r.samples_lost),
            count(r.ring_dropped),
            count(r.steps_bridged),
        ),
    ];
    if let Some(delay_s) = r.group_delay_s.filter(|delay_s| *delay_s > 0.0) {
        lines.push(format!("  low-pass  delays by {:.2} ms, made up for", delay_s * 1e3));
    }
    lines.extend(r.relative.iter().map(|pair| format!("  pair      {}", pair.to_text())));
    lines.extend(r.problems.iter().map(|problem| format!("  !         {problem}")));
    lines.join("\n")
}

/// A body has none of its own, but members.
fn samples(r: &Report) -> String {
    r.members_in_use.as_ref().map_or_else(
        || format!("{} samples/s, ", or_dash(r.sample_rate_hz, 1.0, 1)),
        |members| {
            let used = members.iter().filter(|used| **used).count();
            format!("{used} of {} cameras in use, ", members.len())
        },
    )
}

fn position(r: &Report) -> String {
    r.position_m.map_or_else(
        || "unknown".into(),
        |p| {
            let sigma_m = or_dash(r.position_sigma_m, 1.0, 3);
            format!("{} ± {sigma_m} m east, north, up", numbers(Some(&p), 3))
        },
    )
}

/// A number in another unit, `-` if unknown.
pub(super) fn or_dash(value: Option<f64>, scale: f64, decimals: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{:.decimals$}", value * scale))
}

/// A counter, `-` if unknown.
pub(super) fn count(value: Option<u64>) -> String {
    value.map_or_else(|| "-".into(), |value| value.to_string())
}
