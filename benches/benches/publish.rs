//! Publishing one pose to 0, 1, 4 and 16 subscribers that do not read, beside plain iceoryx2.
//!
//! The lane's publisher stamps each message with the time just before it is sent (one clock call)
//! and loans the next sample ahead; the peer copies and sends.

use std::error::Error;
use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Bencher, Criterion};
use iceoryx2::prelude::ServiceName;
use lodestone_benches::domain::OwnDomain;
use lodestone_benches::ledger::Ledger;
use lodestone_benches::message::empty_pose;
use lodestone_config::model::SharedMemory;
use lodestone_daemon::publisher::LanePublisher;
use lodestone_schema::transport::open_for_reading;
use lodestone_schema::{Pose, ServiceKind};

const SUBSCRIBERS: [usize; 4] = [0, 1, 4, 16];

fn main() -> Result<(), Box<dyn Error>> {
    let own = OwnDomain::new("publish")?;
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let ledger = Ledger::default();
    for subscribers in SUBSCRIBERS {
        lane(&mut criterion, &ledger, &own, subscribers)?;
        peer(&mut criterion, &ledger, &own, subscribers)?;
    }
    criterion.final_summary();
    ledger.print_ratios("lane, 0 subscribers");
    Ok(())
}

fn lane(
    criterion: &mut Criterion,
    ledger: &Ledger,
    own: &OwnDomain,
    subscribers: usize,
) -> Result<(), Box<dyn Error>> {
    let camera = format!("to{subscribers}");
    let mut publisher = LanePublisher::open(own.domain(), &SharedMemory::default(), &camera)?;
    let node = own.domain().open_node("bench-subscribers")?;
    let service = open_for_reading::<Pose>(&node, ServiceKind::Pose, &camera)?;
    let mut joined = Vec::new();
    for _ in 0..subscribers {
        joined.push(service.subscriber_builder().create()?);
    }
    let mut pose = empty_pose();
    let name = format!("lane, {subscribers} subscribers");
    criterion.bench_function(&name, |b| {
        timed(b, ledger, &name, || {
            pose.sequence += 1;
            black_box(publisher.publish_pose(&pose));
        });
    });
    if publisher.errors() > 0 {
        return Err(format!("{} messages were not sent", publisher.errors()).into());
    }
    Ok(())
}

fn peer(
    criterion: &mut Criterion,
    ledger: &Ledger,
    own: &OwnDomain,
    subscribers: usize,
) -> Result<(), Box<dyn Error>> {
    let settings = SharedMemory::default();
    let node = own.domain().open_node("bench-peer")?;
    let name = ServiceName::new(&format!("bench/peer/{subscribers}"))?;
    let service = node
        .service_builder(&name)
        .publish_subscribe::<Pose>()
        .enable_safe_overflow(true)
        .history_size(settings.pose_history)
        .subscriber_max_buffer_size(settings.pose_history)
        .max_subscribers(settings.max_subscribers)
        .create()?;
    let publisher = service.publisher_builder().create()?;
    let mut joined = Vec::new();
    for _ in 0..subscribers {
        joined.push(service.subscriber_builder().create()?);
    }
    let mut pose = empty_pose();
    let (mut failed, name) = (0_u64, format!("plain iceoryx2, {subscribers} subscribers"));
    criterion.bench_function(&name, |b| {
        timed(b, ledger, &name, || {
            pose.sequence += 1;
            failed += u64::from(publisher.send_copy(black_box(pose)).is_err());
        });
    });
    if failed > 0 {
        return Err(format!("{failed} messages were not sent").into());
    }
    Ok(())
}

fn timed(bencher: &mut Bencher<'_>, ledger: &Ledger, name: &str, mut work: impl FnMut()) {
    bencher.iter_custom(|iterations| {
        let begin = Instant::now();
        (0..iterations).for_each(|_| work());
        let total = begin.elapsed();
        ledger.add(name, total, iterations);
        total
    });
}
