//! `lodestone status`.

use std::time::{Duration, Instant};

use super::args::StatusArgs;
use super::failure::Failure;
use super::json::{heading, numbers};
use super::output::Output;
use super::report::{Monitor, Report};
use super::session::Session;

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
    for report in monitors.iter_mut().map(Monitor::report) {
        if session.json {
            output.json(&report)?;
        } else {
            output.line(&text(&report))?;
        }
    }
    Ok(())
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
            "  rate      {} samples/s, {} poses/s; arrival to published {} ms (p50), {} ms (p99)",
            or_dash(r.sample_rate_hz, 1.0, 1),
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
    lines.extend(r.problems.iter().map(|problem| format!("  !         {problem}")));
    lines.join("\n")
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
