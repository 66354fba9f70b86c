//! The least that anybody pays who stands on iceoryx2 and filters: a step, and a message.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use lodestone_client::monotonic_now_ns;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use super::super::configuration::camera;
use super::super::payload::payload;
use super::super::peers::{Peer, STEP_NS};
use super::super::step_alone::Aligned;
use super::Watch;

const SECOND_NS: i64 = 1_000_000_000;
/// For the daemon to start and its first pose.
const START: Duration = Duration::from_secs(10);

/// Works midway between the samples of the daemon's first camera, so that both have the same machine from
/// one millisecond to the next, and neither is in the other's way.
pub(super) fn run(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let rounds = ((watch.settle_s + watch.measure_s) * SECOND_NS as f64) as i64 / STEP_NS;
    let mut aligned = Aligned::new(usize::try_from(rounds)?)?;
    let mut sender = Peer::Iceoryx2.sender(&watch.place(), false)?;
    let mut poses = watch.client()?.poses(&camera(0))?;
    poses.wait(START)?;
    let mut due_ns = poses.wait(START)?.message().arrival_time_ns + STEP_NS / 2;
    drop(poses);
    for (sequence, reading) in (1..).zip(&aligned.readings) {
        due_ns += STEP_NS;
        let due = Timespec { tv_sec: due_ns / SECOND_NS, tv_nsec: due_ns % SECOND_NS };
        clock_nanosleep_absolute(ClockId::Monotonic, &due)?;
        let start_ns = monotonic_now_ns();
        aligned.core.take(black_box(reading), |step| {
            black_box(step);
        });
        sender.send(&payload(sequence, start_ns))?;
    }
    Ok(())
}
