//! The least that anybody pays who stands on iceoryx2 and filters: a step, and a message.

use std::error::Error;
use std::hint::black_box;
use std::time::Duration;

use super::super::configuration::camera;
use super::super::metronome::{Metronome, STEP_NS, beats};
use super::super::payload::payload;
use super::super::peers::Peer;
use super::super::step_alone::Aligned;
use super::Watch;

/// For the daemon to start and its first pose.
const START: Duration = Duration::from_secs(10);

/// Works midway between the samples of the daemon's first camera, so that both have the same machine from
/// one millisecond to the next, and neither is in the other's way.
pub(super) fn run(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let mut aligned = Aligned::new(beats(watch.settle_s + watch.measure_s))?;
    let mut sender = Peer::Iceoryx2.sender(&watch.place(), false)?;
    let mut poses = watch.client()?.poses(&camera(0))?;
    poses.wait(START)?;
    let arrival_ns = poses.wait(START)?.message().arrival_time_ns;
    let mut metronome = Metronome::after(arrival_ns + STEP_NS / 2);
    drop(poses);
    for (sequence, reading) in (1..).zip(&aligned.readings) {
        let start_ns = metronome.wait()?;
        aligned.core.take(black_box(reading), |step| {
            black_box(step);
        });
        sender.send(&payload(sequence, start_ns))?;
    }
    Ok(())
}
