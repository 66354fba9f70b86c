//! What a lane pays for its subscribers.

use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use lodestone_config::model::SharedMemory;
use lodestone_daemon::publisher::LanePublisher;
use lodestone_schema::transport::open_for_reading;
use lodestone_schema::{Pose, ServiceKind};

use super::super::told::Told;
use super::Watch;
use crate::ledger::median;
use crate::message::empty_pose;

/// Subscribers; they read between bursts, so that each send also takes back what they have read.
const SUBSCRIBERS: [usize; 4] = [0, 1, 4, 16];
/// Poses in one measurement; no more than a subscriber has room for.
const BURST: u32 = 400;

/// Publishes bursts to each number of subscribers in turn until the time is over, and tells the median
/// time of a pose for each.
pub(super) fn run(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let node = watch.domain().open_node("bench-subscribers")?;
    let mut pose = empty_pose();
    let mut subjects = Vec::new();
    for count in SUBSCRIBERS {
        let camera = format!("to{count}");
        let publisher = LanePublisher::open(&watch.domain(), &SharedMemory::default(), &camera)?;
        let service = open_for_reading::<Pose>(&node, ServiceKind::Pose, &camera)?;
        let joined = (0..count).map(|_| service.subscriber_builder().create());
        let joined = joined.collect::<Result<Vec<_>, _>>()?;
        subjects.push((count, publisher, joined, Vec::new()));
    }
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < watch.settle_s + watch.measure_s {
        for (_, publisher, joined, times_ns) in &mut subjects {
            let burst = Instant::now();
            for _ in 0..BURST {
                pose.sequence += 1;
                black_box(publisher.publish_pose(&pose));
            }
            times_ns.push(burst.elapsed().as_secs_f64() * 1e9 / f64::from(BURST));
            read(joined)?;
        }
    }
    let errors: u64 = subjects.iter().map(|(_, publisher, ..)| publisher.errors()).sum();
    if errors > 0 {
        return Err(format!("{errors} poses were not sent").into());
    }
    let mut told = Told::of(0);
    let figures = subjects.iter().map(|(n, _, _, times)| (figure(*n), median(times)));
    told.figures = figures.collect();
    told.tell()
}

fn read(subscribers: &[Subscriber<ipc::Service, Pose, ()>]) -> Result<(), Box<dyn Error>> {
    for subscriber in subscribers {
        while let Some(pose) = subscriber.receive()? {
            black_box(&*pose);
        }
    }
    Ok(())
}

/// The name of what publishing to so many costs, ns.
pub(crate) fn figure(subscribers: usize) -> String {
    format!("ns to {subscribers} subscribers")
}
