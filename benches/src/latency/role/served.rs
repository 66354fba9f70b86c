//! Many cameras: what arrives, and what is lost on the way.

use std::error::Error;
use std::thread::sleep;
use std::time::Duration;

use lodestone_client::{Client, HealthStream, PoseStream, monotonic_now_ns};

use super::super::configuration::camera;
use super::super::told::Told;
use super::Watch;

/// Between two looks at all cameras; each has room for half a second.
const NAP: Duration = Duration::from_millis(5);

/// Longest time until a camera is there.
const START: Duration = Duration::from_secs(30);

/// Health comes once a second.
const PATIENCE_NS: i64 = 5_000_000_000;

/// What lanes and consumer have counted so far.
#[derive(Clone, Copy, Default)]
struct Counts {
    samples: u64,
    samples_lost: u64,
    poses: u64,
    poses_lost: u64,
}

pub(super) fn run(watch: &Watch, cameras: usize) -> Result<(), Box<dyn Error>> {
    let mut consumer = Consumer::join(&watch.client()?, cameras)?;
    consumer.read_for(watch.settle_s)?;
    let before = consumer.counts()?;
    consumer.read_for(watch.measure_s)?;
    let after = consumer.counts()?;
    let mut told = Told::of(0);
    told.figures = vec![
        ("samples taken".into(), (after.samples - before.samples) as f64),
        ("samples lost".into(), (after.samples_lost - before.samples_lost) as f64),
        ("poses received".into(), (after.poses - before.poses) as f64),
        ("poses lost".into(), (after.poses_lost - before.poses_lost) as f64),
    ];
    told.tell()
}

/// One process that reads all cameras.
struct Consumer {
    poses: Vec<PoseStream>,
    healths: Vec<HealthStream>,
}

impl Consumer {
    fn join(client: &Client, cameras: usize) -> Result<Self, Box<dyn Error>> {
        let names: Vec<String> = (0..cameras).map(camera).collect();
        let mut poses = opened(&names, |name| client.poses(name))?;
        for stream in &mut poses {
            // So many lanes start one after the other.
            stream.wait(START)?;
        }
        Ok(Self { poses, healths: opened(&names, |name| client.health(name))? })
    }

    /// Reads for a while, and until every lane has told its health since the beginning of it.
    fn read_for(&mut self, seconds: f64) -> Result<(), Box<dyn Error>> {
        let begin_ns = monotonic_now_ns();
        let until_ns = begin_ns + (seconds * 1e9) as i64;
        while monotonic_now_ns() < until_ns || !self.all_told_since(until_ns) {
            if monotonic_now_ns() > until_ns + PATIENCE_NS {
                return Err("a lane does not tell its health".into());
            }
            self.poses.iter_mut().for_each(|stream| stream.all().into_iter().for_each(drop));
            sleep(NAP);
        }
        Ok(())
    }

    fn all_told_since(&mut self, time_ns: i64) -> bool {
        let told = |stream: &mut HealthStream| {
            stream.latest().is_ok_and(|health| health.message().time_ns >= time_ns)
        };
        let told = self.healths.iter_mut().map(told).filter(|told| *told);
        // Every one is asked, since each connects when it is first asked.
        told.count() == self.poses.len()
    }

    fn counts(&mut self) -> Result<Counts, Box<dyn Error>> {
        let mut all = Counts::default();
        for stream in &mut self.healths {
            let health = stream.latest()?;
            let counts = health.message();
            all.samples += counts.samples;
            // What the sensor itself loses is none here: the synthetic cameras drop nothing.
            all.samples_lost += counts.ring_dropped + counts.samples_lost + counts.publish_errors;
        }
        for stream in &self.poses {
            all.poses += stream.counts().received;
            all.poses_lost += stream.counts().lost;
        }
        Ok(all)
    }
}

fn opened<T, E: Error + 'static>(
    names: &[String],
    open: impl Fn(&str) -> Result<T, E>,
) -> Result<Vec<T>, Box<dyn Error>> {
    Ok(names.iter().map(|name| open(name)).collect::<Result<Vec<T>, E>>()?)
}
