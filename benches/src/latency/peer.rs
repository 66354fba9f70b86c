//! The peer: iceoryx2 alone, the same message at the same rate.

use std::error::Error;
use std::thread::sleep;
use std::time::{Duration, Instant};

use iceoryx2::prelude::ServiceName;
use lodestone_client::monotonic_now_ns;
use lodestone_schema::Pose;
use lodestone_schema::transport::PublishSubscribe;
use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec};

use super::role::Watch;
use super::stages::Stages;
use crate::message::empty_pose;

const STEP_NS: i64 = 2_500_000;
const SECOND_NS: i64 = 1_000_000_000;

/// Longest wait for the other side's service.
const PATIENCE: Duration = Duration::from_secs(2);

/// A service with room for what a consumer may miss; nothing else is asked of it. The publisher
/// creates it.
fn service(watch: &Watch, create: bool) -> Result<PublishSubscribe<Pose>, Box<dyn Error>> {
    let node = watch.domain().open_node("bench-peer")?;
    let name = ServiceName::new("bench/peer")?;
    let builder = || node.service_builder(&name).publish_subscribe::<Pose>();
    if create {
        let service = builder().enable_safe_overflow(true).subscriber_max_buffer_size(512);
        return Ok(service.create()?);
    }
    let begin = Instant::now();
    loop {
        match builder().open() {
            Err(_) if begin.elapsed() < PATIENCE => sleep(Duration::from_millis(10)),
            done => return Ok(done?),
        }
    }
}

/// Publishes an empty pose every 2.5 ms, all stamps taken just before it is sent.
///
/// # Errors
/// Whatever iceoryx2 says.
pub fn publish(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let publisher = service(watch, true)?.publisher_builder().create()?;
    let (begin, mut due_ns) = (Instant::now(), monotonic_now_ns());
    let end = Duration::from_secs_f64(watch.settle_s + watch.measure_s);
    while begin.elapsed() < end {
        due_ns += STEP_NS;
        let due = Timespec { tv_sec: due_ns / SECOND_NS, tv_nsec: due_ns % SECOND_NS };
        clock_nanosleep_absolute(ClockId::Monotonic, &due)?;
        let now_ns = monotonic_now_ns();
        publisher.send_copy(Pose {
            arrival_time_ns: now_ns,
            step_start_time_ns: now_ns,
            step_end_time_ns: now_ns,
            published_time_ns: now_ns,
            ..empty_pose()
        })?;
    }
    Ok(())
}

/// Polls the peer's service.
///
/// # Errors
/// Whatever iceoryx2 says.
pub fn subscribe(watch: &Watch) -> Result<(), Box<dyn Error>> {
    let subscriber = service(watch, false)?.subscriber_builder().create()?;
    watch.report(|| {
        let mut newest = None;
        while let Some(sample) = subscriber.receive()? {
            newest = Some(Stages::of(&sample, monotonic_now_ns()));
        }
        if newest.is_none() {
            std::hint::spin_loop();
        }
        Ok(newest)
    })
}
