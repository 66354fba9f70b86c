//! `lodestone bench`.

mod measurement;
mod processors;
mod report;
mod warnings;

use std::fs;
use std::time::Duration;

use lodestone_client::latency::{GAP_THRESHOLD, Machine, Poller, Sentinel};
use lodestone_client::{PoseStream, monotonic_now_ns};

use super::args::BenchArgs;
use super::failure::Failure;
use super::output::{Output, remark};
use super::session::Session;
use measurement::Measurement;
use processors::Processors;
use report::Report;

pub(super) fn run(session: &Session, args: &BenchArgs) -> Result<(), Failure> {
    let cameras = chosen(session, &args.cameras)?;
    let processors = Processors::choose(args.cpu)?;
    let mut warnings = processors.warnings();
    let sentinel = processors.other.and_then(|cpu| {
        let started = Sentinel::start(cpu, GAP_THRESHOLD);
        started.map_err(|error| warnings.push(format!("no sentinel: {error}"))).ok()
    });
    processors.pin()?;
    let machine = Machine::observed();
    warnings.extend(warnings::of_system(&machine, session, &cameras));
    remark(format_args!(
        "measuring {} for {} s after {} s; ctrl-c ends it with what is there",
        cameras.join(", "),
        args.duration.as_secs_f64(),
        args.warm_up.as_secs_f64(),
    ));
    let mut measurement = Measurement::new(cameras.len(), sentinel);
    let measured = measure(session, args, &cameras, &mut measurement)?;
    let report = Report::new(machine, &cameras, &measurement, measured, warnings);
    if let Some(file) = &args.html {
        let written = fs::write(file, report.page(&cameras, &measurement));
        written.map_err(|e| Failure::Other(format!("{}: {e}", file.display())))?;
    }
    let mut output = Output::new();
    if session.json { output.json(&report) } else { output.line(&report.text()) }?;
    match measurement.measured() {
        0 => Err(Failure::Other("no pose came".into())),
        _ => Ok(()),
    }
}

/// The cameras asked for, each once; all that there are if none was named.
fn chosen(session: &Session, asked: &[String]) -> Result<Vec<String>, Failure> {
    if asked.is_empty() {
        return session.cameras();
    }
    let mut cameras: Vec<String> = Vec::new();
    for camera in asked {
        let camera = session.camera(Some(camera))?;
        if !cameras.contains(&camera) {
            cameras.push(camera);
        }
    }
    Ok(cameras)
}

/// Polls until the time is over or the user stops; gives the time that was measured.
fn measure(
    session: &Session,
    args: &BenchArgs,
    cameras: &[String],
    measurement: &mut Measurement,
) -> Result<Duration, Failure> {
    let open = |camera: &String| session.client.poses(camera);
    let mut streams = cameras.iter().map(open).collect::<Result<Vec<PoseStream>, _>>()?;
    // Connecting belongs to no sample's way.
    for stream in &mut streams {
        let _ = stream.latest();
    }
    let begin_ns = monotonic_now_ns().saturating_add(nanos(args.warm_up));
    let end_ns = begin_ns.saturating_add(nanos(args.duration));
    let mut poller = Poller::new(streams, begin_ns, nanos(GAP_THRESHOLD));
    let mut now_ns = begin_ns;
    while now_ns < end_ns && !session.stop.asked() {
        let gap = poller.round(|camera, seen| measurement.take(camera, seen));
        now_ns = monotonic_now_ns();
        if let Some(gap) = gap.filter(|gap| gap.end_ns > begin_ns) {
            measurement.note_gap(gap);
        }
        measurement.settle(now_ns);
    }
    measurement.settle_all();
    Ok(Duration::from_nanos(u64::try_from(now_ns - begin_ns).unwrap_or(0)))
}

fn nanos(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}
