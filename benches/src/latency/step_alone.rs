//! A lane's core on readings made beforehand, at the rate of a camera and with nothing around it: one
//! filter step as it costs when the processor has slept in between.

use std::error::Error;
use std::hint::black_box;

use lodestone_client::latency::{Sighting, Stamps};
use lodestone_client::monotonic_now_ns;
use lodestone_config::model::TrajectoryKind;
use lodestone_daemon::lane::Core;
use lodestone_daemon::reading::Reading;

use super::metronome::{Metronome, beats};
use super::role::Watch;
use super::told::Told;
use crate::readings::Load;

/// Readings until the filter is aligned and the camera walks.
const BEFORE: usize = 2400;

/// A core whose filter is aligned and carried, and what it takes next.
pub struct Aligned {
    /// The core.
    pub core: Core,
    /// The next readings.
    pub readings: Vec<Reading>,
}

impl Aligned {
    /// With so many readings to come.
    ///
    /// # Errors
    /// If there is no synthetic world.
    pub fn new(count: usize) -> Result<Self, Box<dyn Error>> {
        let mut load = Load::synthetic(TrajectoryKind::Walk, BEFORE + count)?;
        let readings = load.readings.split_off(BEFORE);
        let mut core = Core::new(&load.settings);
        for reading in &load.readings {
            core.take(reading, |_| {});
        }
        Ok(Self { core, readings })
    }
}

/// Takes a reading every 2.5 ms and tells how long each took.
///
/// # Errors
/// If there is no synthetic world, or it cannot be told.
pub fn run(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let Aligned { mut core, readings } = Aligned::new(beats(watch.settle_s + watch.measure_s))?;
    let mut told = Told::of(1);
    let now_ns = monotonic_now_ns();
    let (mut metronome, begin_ns) =
        (Metronome::after(now_ns), now_ns + (watch.settle_s * 1e9) as i64);
    for reading in &readings {
        let start_ns = metronome.wait()?;
        core.take(black_box(reading), |step| {
            black_box(step);
        });
        let end_ns = monotonic_now_ns();
        if start_ns >= begin_ns {
            told.see(0, &Sighting { stamps: stamps(start_ns, end_ns), in_one_look: 1 });
        }
    }
    told.tell()
}

/// A way that is a step and nothing else.
const fn stamps(start_ns: i64, end_ns: i64) -> Stamps {
    Stamps {
        arrival_ns: start_ns,
        ring_ns: start_ns,
        step_start_ns: start_ns,
        step_end_ns: end_ns,
        published_ns: end_ns,
        seen_ns: end_ns,
    }
}
