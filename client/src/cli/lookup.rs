//! `lodestone lookup`.

use std::time::Duration;

use lodestone_client::{Time, monotonic_now_ns};

use super::args::{ClockName, LookupArgs};
use super::failure::Failure;
use super::json::PoseLine;
use super::output::Output;
use super::session::Session;

/// A running daemon's history comes with its next pose.
const PATIENCE: Duration = Duration::from_secs(1);

pub(super) fn run(session: &Session, args: &LookupArgs) -> Result<(), Failure> {
    let asked_at_ns = monotonic_now_ns();
    let camera = session.camera(args.camera.as_deref())?;
    let mut poses = session.client.poses(&camera)?;
    poses.wait(PATIENCE)?;
    let pose = poses.lookup(time(args, asked_at_ns))?;
    let line = PoseLine::new(&camera, &pose);
    let mut output = Output::new();
    if session.json { output.json(&line) } else { output.line(&line.to_text()) }
}

fn time(args: &LookupArgs, asked_at_ns: i64) -> Time {
    let ago_ns = args.ago.map(|ago| i64::try_from(ago.as_nanos()).unwrap_or(i64::MAX));
    match (args.time, args.clock) {
        (Some(time), ClockName::Unix) => Time::Unix(time.0),
        (Some(time), ClockName::Monotonic) => Time::Monotonic(time.0),
        (None, _) => Time::Monotonic(asked_at_ns.saturating_sub(ago_ns.unwrap_or(0))),
    }
}
