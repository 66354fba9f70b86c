//! Many cameras: what arrives, and what is lost on the way.

use std::error::Error;
use std::thread::sleep;
use std::time::Duration;

use lodestone_client::{Client, HealthStream, LaneHealth, PoseStream, monotonic_now_ns};

use super::super::configuration::camera;
use super::super::told::Told;
use super::Watch;

/// Between two looks at all cameras; each has room for half a second.
const NAP: Duration = Duration::from_millis(5);

/// Longest time until a camera is there.
const START: Duration = Duration::from_secs(30);

/// What a lane counts of samples that did not become poses.
#[derive(Clone, Copy, Default)]
struct Losses {
    samples: u64,
    lost: u64,
}

pub(super) fn run(watch: &Watch, cameras: usize) -> Result<(), Box<dyn Error>> {
    let client = watch.client()?;
    let names: Vec<String> = (0..cameras).map(camera).collect();
    let mut streams = opened(&names, |name| client.poses(name))?;
    for stream in &mut streams {
        // So many lanes start one after the other.
        stream.wait(START)?;
    }
    let settled_ns = monotonic_now_ns() + (watch.settle_s * 1e9) as i64;
    read(&mut streams, settled_ns);
    let (before, lost_before) = (losses(&client, &names)?, lost(&streams));
    let received_before = received(&streams);
    read(&mut streams, monotonic_now_ns() + (watch.measure_s * 1e9) as i64);
    let after = losses(&client, &names)?;
    let mut told = Told::of(0);
    told.figures = vec![
        ("samples taken".into(), (after.samples - before.samples) as f64),
        ("samples lost".into(), (after.lost - before.lost) as f64),
        ("poses received".into(), (received(&streams) - received_before) as f64),
        ("poses lost".into(), (lost(&streams) - lost_before) as f64),
    ];
    told.tell()
}

fn opened<T, E: Error + 'static>(
    names: &[String],
    open: impl Fn(&str) -> Result<T, E>,
) -> Result<Vec<T>, Box<dyn Error>> {
    Ok(names.iter().map(|name| open(name)).collect::<Result<Vec<T>, E>>()?)
}

fn read(streams: &mut [PoseStream], until_ns: i64) {
    while monotonic_now_ns() < until_ns {
        streams.iter_mut().for_each(|stream| {
            stream.all().into_iter().for_each(drop);
        });
        sleep(NAP);
    }
}

fn lost(streams: &[PoseStream]) -> u64 {
    streams.iter().map(|stream| stream.counts().lost).sum()
}

fn received(streams: &[PoseStream]) -> u64 {
    streams.iter().map(|stream| stream.counts().received).sum()
}

/// All lanes' counts together, by their health.
fn losses(client: &Client, names: &[String]) -> Result<Losses, Box<dyn Error>> {
    let mut streams: Vec<HealthStream> = opened(names, |name| client.health(name))?;
    // Each connects when it is first asked, and gets something within a second of that.
    streams.iter_mut().for_each(|stream| {
        let _ = stream.latest();
    });
    let mut all = Losses::default();
    for stream in &mut streams {
        let health = patiently(stream)?;
        let counts = health.message();
        all.samples += counts.samples;
        // What the sensor itself loses is none here: the synthetic cameras drop nothing.
        all.lost += counts.ring_dropped + counts.samples_lost + counts.publish_errors;
    }
    Ok(all)
}

/// Health comes once a second.
fn patiently(stream: &mut HealthStream) -> Result<LaneHealth, Box<dyn Error>> {
    for _ in 0..500 {
        if let Ok(health) = stream.latest() {
            return Ok(health);
        }
        sleep(Duration::from_millis(10));
    }
    Ok(stream.latest()?)
}
