//! Consumers of one camera's poses.

use std::error::Error;
use std::thread::sleep;
use std::time::Duration;

use lodestone_client::latency::{Counted, Poller, Sighting, Stamps};
use lodestone_client::{PoseStream, Status, monotonic_now_ns};
use lodestone_schema::ServiceKind;
use lodestone_schema::transport::open_event_for_reading;

use super::super::configuration::camera;
use super::super::cpu_time;
use super::super::peers::{Follower, GAP_THRESHOLD_NS, Peer};
use super::super::told::Told;
use super::Watch;

/// After a pose the next one is 2.5 ms away: for the first fifth of that nobody need look. So a consumer
/// with real-time priority leaves its processor to others often enough not to be throttled.
pub(crate) const BREATH: Duration = Duration::from_micros(500);

/// Polls.
pub(super) fn poll(watch: &Watch) -> Result<(), Box<dyn Error>> {
    poll_with(watch, 1, &mut |_, _| Ok(false))
}

/// Polls two streams: the lane's, and the floor's.
pub(super) fn poll_in_turns(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let mut floor = None;
    poll_with(watch, 2, &mut |told, begin_ns| {
        let floor = match &mut floor {
            Some(floor) => floor,
            none => none.insert(Follower::join(Peer::Iceoryx2, &watch.place(), 1)?),
        };
        floor.look(told, begin_ns)
    })
}

/// Looks at something else, with what it tells and from when it counts; whether something came.
type Else<'a> = &'a mut dyn FnMut(&mut Told, i64) -> Result<bool, Box<dyn Error>>;

fn poll_with(watch: &Watch, streams: usize, look: Else<'_>) -> Result<(), Box<dyn Error>> {
    let mut poses = vec![stream(watch)?];
    connect(&mut poses);
    let mut told = Told::of(streams);
    // Joins before it counts.
    look(&mut told, i64::MAX)?;
    let span = Span::of(watch);
    let mut poller = Poller::new(poses, span.begin_ns, GAP_THRESHOLD_NS);
    while monotonic_now_ns() < span.end_ns {
        let mut came = false;
        let gap = poller.round(|stream, seen| {
            came = true;
            told.leave_out(stream, &seen.left_out);
            if let Some(sighting) = &seen.sighting {
                told.see(stream, sighting);
            }
        });
        if let Some(gap) = gap.filter(|gap| gap.end_ns > span.begin_ns) {
            told.note_gap(gap);
        }
        if came || look(&mut told, span.begin_ns)? {
            sleep(BREATH);
            poller.forget_last_look();
        } else {
            std::hint::spin_loop();
        }
    }
    told.tell()
}

/// Waits as the client does.
pub(super) fn wait(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let mut poses = stream(watch)?;
    connect(std::slice::from_mut(&mut poses));
    sleeping(watch, &mut |told, begin_ns| {
        // Before the daemon is up there is nothing to wait for.
        if poses.wait(Duration::from_millis(100)).is_ok() {
            take(&mut poses, told, begin_ns);
        }
    })
}

/// Sleeps until the lane's wake-up event.
pub(super) fn event(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let mut poses = stream(watch)?;
    connect(std::slice::from_mut(&mut poses));
    let node = watch.domain().open_node("bench-event")?;
    let service = open_event_for_reading(&node, ServiceKind::Wake, poses.camera())?;
    let listener = service.listener_builder().create()?;
    sleeping(watch, &mut |told, begin_ns| {
        // An error would show as poses that are not seen.
        let _ = listener.timed_wait(|_| {}, Duration::from_millis(100));
        take(&mut poses, told, begin_ns);
    })
}

/// Calls `look` over and over and tells what it saw, with the processor time that it took.
fn sleeping(watch: &Watch, look: &mut dyn FnMut(&mut Told, i64)) -> Result<(), Box<dyn Error>> {
    let span = Span::of(watch);
    let mut told = Told::of(1);
    let mut cpu_ns = None;
    while monotonic_now_ns() < span.end_ns {
        look(&mut told, span.begin_ns);
        if cpu_ns.is_none() && monotonic_now_ns() >= span.begin_ns {
            cpu_ns = Some(cpu_time::of_process(std::process::id()));
        }
    }
    told.cpu_ns = cpu_time::of_process(std::process::id()) - cpu_ns.unwrap_or(0);
    told.measured_ns = (span.end_ns - span.begin_ns).cast_unsigned();
    told.tell()
}

/// Notes the newest pose, if it counts.
fn take(poses: &mut PoseStream, told: &mut Told, begin_ns: i64) {
    let batch = poses.all();
    let lost = batch.lost;
    let (mut newest, mut count) = (None, 0);
    for pose in batch {
        (newest, count) = (Some(pose), count + 1);
    }
    let Some(pose) = newest else { return };
    let stamps = Stamps::of(pose.message(), monotonic_now_ns());
    if stamps.arrival_ns < begin_ns {
        told.leave_out(0, &Counted { warm_up: count, ..Counted::default() });
    } else if pose.status().contains(Status::SENSOR_STALE) {
        told.leave_out(0, &Counted { repeated: count, ..Counted::default() });
    } else {
        told.leave_out(0, &Counted { lost, ..Counted::default() });
        told.see(0, &Sighting { stamps, in_one_look: count });
    }
}

/// From when to when it counts, `CLOCK_MONOTONIC`.
struct Span {
    begin_ns: i64,
    end_ns: i64,
}

impl Span {
    fn of(watch: &Watch) -> Self {
        let begin_ns = monotonic_now_ns() + (watch.settle_s * 1e9) as i64;
        Self { begin_ns, end_ns: begin_ns + (watch.measure_s * 1e9) as i64 }
    }
}

fn stream(watch: &Watch) -> Result<PoseStream, Box<dyn Error>> {
    Ok(watch.client()?.poses(&camera(0))?)
}

/// Waits until poses come: what the start of the daemon takes is no part of the measurement.
fn connect(streams: &mut [PoseStream]) {
    for stream in streams {
        // If none comes at all, the measurement will say so.
        let _ = stream.wait(Duration::from_secs(10));
    }
}
