//! Three cameras, two lanes, and what happens to them.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::JoinHandle;

use lodestone_daemon::driver::zed2::discovery::Product;
use lodestone_daemon::driver::zed2::raw::RawReport;
use lodestone_daemon::driver::{Driver, DriverCounters, SourceState};
use lodestone_tests::virtual_zed2::VirtualZed2;

use crate::lane::Lane;
use crate::{
    FRONT, FRONT_MARK, MINI, POLL, REAR, REAR_MARK, Verdict, ensure, mini_is_refused,
    others_are_listed, permission_is_explained, report, text, wait_for_nodes,
};

/// Three cameras are plugged in; two lanes read two of them, the rear one on a thread of its own
/// from the beginning to the end.
pub(crate) struct Scene {
    front_camera: VirtualZed2,
    _mini: VirtualZed2,
    front: Lane,
    rear: Rear,
}

/// The lane that must not notice what happens to the front camera.
struct Rear {
    camera: VirtualZed2,
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Lane>,
}

impl Rear {
    fn start(camera: VirtualZed2) -> Result<Self, String> {
        let mut lane = Lane::open(REAR)?;
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            while !stopped.load(Relaxed) {
                lane.poll(POLL);
            }
            lane
        });
        Ok(Self { camera, stop, thread })
    }

    fn finish(self) -> Result<(Lane, VirtualZed2), String> {
        self.stop.store(true, Relaxed);
        let lane = self.thread.join().map_err(|_| "the rear lane panicked")?;
        Ok((lane, self.camera))
    }
}

impl Scene {
    pub(crate) fn set() -> Result<Self, String> {
        let front_camera = VirtualZed2::plug_in(Product::Zed2, FRONT, FRONT_MARK).map_err(text)?;
        let rear_camera = VirtualZed2::plug_in(Product::Zed2i, REAR, REAR_MARK).map_err(text)?;
        let mini = VirtualZed2::plug_in(Product::Mini, MINI, 0).map_err(text)?;
        wait_for_nodes(3)?;
        Ok(Self {
            front_camera,
            _mini: mini,
            front: Lane::open(FRONT)?,
            rear: Rear::start(rear_camera)?,
        })
    }

    pub(crate) fn play(mut self) {
        report("mini-is-refused", mini_is_refused());
        report("others-are-listed", others_are_listed());
        report("permission-is-explained", permission_is_explained());
        report("streams", self.streams());
        report("pings", self.pings());
        report("garbage-is-survived", self.garbage_is_survived());
        report("blocked-commands-do-not-block", self.blocked_commands_do_not_block());
        report("silence-is-restarted", self.silence_is_restarted());
        let mut scene = match self.unplug_is_noticed() {
            Ok((scene, facts)) => {
                report("unplug-is-noticed", Ok(facts));
                scene
            }
            Err(reason) => return report("unplug-is-noticed", Err(reason)),
        };
        report("replug-resumes", scene.replug_resumes());
        report("other-camera-is-untouched", scene.other_camera_is_untouched());
    }

    fn streams(&mut self) -> Verdict {
        // What came while nobody polled; the ring may have run over.
        self.front.take(100)?;
        let from = self.front.readings.len();
        let before = self.front.driver.counters();
        self.front.take(2400)?;
        self.front.ensure_unbroken(from)?;
        self.front.ensure_only(FRONT_MARK)?;
        let lane = &self.front;
        let fields = lane.readings[from..].iter().filter(|r| r.mag.is_some()).count();
        ensure(fields >= 2400 / 8, || format!("{fields} magnetometer readings"))?;
        let after = lane.driver.counters();
        let same = DriverCounters { pings: before.pings, ..after };
        ensure(same == before, || format!("{before:?} became {after:?}"))?;
        let (count, rate_hz) = (lane.readings.len() - from, lane.rate_hz(from));
        let gaps = after.gaps - before.gaps;
        Ok(format!("{count} samples at {rate_hz:.1} Hz, {gaps} gaps"))
    }

    /// The stream above took 6 s, as long as the camera goes on unpinged.
    fn pings(&mut self) -> Verdict {
        self.front.take(400)?;
        let (seen, counters) = (self.front_camera.seen(), self.front.driver.counters());
        let pings = seen.pings.load(Relaxed);
        ensure(seen.expired.load(Relaxed) == 0, || "the camera stopped unpinged".into())?;
        ensure(pings >= 5 && counters.pings_failed == 0, || format!("{pings}, {counters:?}"))?;
        Ok(format!("{pings} pings seen by the camera, {} counted by the driver", counters.pings))
    }

    fn garbage_is_survived(&mut self) -> Verdict {
        let from = self.front.readings.len();
        for i in 0..50 {
            // The first byte is the report's number, by which the kernel knows it; the rest is
            // noise, and no time stamp. (This kernel keeps short reports back by itself.)
            let noise = RawReport { struct_id: 1, ticks: u64::MAX - i, ..RawReport::default() };
            let mut report = noise.emit();
            report[10..].fill(0xa5);
            self.front_camera.send_also(report.to_vec());
        }
        self.front.take(200)?;
        self.front.ensure_unbroken(from)?;
        let malformed = self.front.driver.counters().malformed;
        ensure(malformed == 50, || format!("{malformed} malformed reports, sent 50"))?;
        Ok("50 malformed reports counted, no sample lost between them".into())
    }

    fn blocked_commands_do_not_block(&mut self) -> Verdict {
        let from = self.front.readings.len();
        let pings = self.front.driver.counters().pings;
        self.front_camera.be_deaf(true);
        let taken = self.front.take(800);
        self.front_camera.be_deaf(false);
        taken?;
        self.front.ensure_unbroken(from)?;
        let pings = self.front.driver.counters().pings - pings;
        ensure(pings <= 1, || format!("{pings} pings passed: none hung"))?;
        Ok("800 samples without a gap while a ping hung".into())
    }

    fn silence_is_restarted(&mut self) -> Verdict {
        let starts = self.front_camera.seen().starts.load(Relaxed);
        self.front_camera.stumble();
        self.front.poll_until("silence", |_, state| state == SourceState::Lost)?;
        self.front.poll_until("streaming", |_, state| state == SourceState::Streaming)?;
        let counters = self.front.driver.counters();
        let started = self.front_camera.seen().starts.load(Relaxed) - starts;
        let restarted = counters.stream_restarts >= 1 && started >= 1;
        ensure(restarted && counters.reconnects == 0, || format!("{started}, {counters:?}"))?;
        Ok(format!("{started} more start command, no re-open"))
    }

    fn unplug_is_noticed(self) -> Result<(Unplugged, String), String> {
        let Self { front_camera, mut front, rear, _mini } = self;
        front.take(10)?;
        front_camera.unplug().map_err(text)?;
        // What the kernel still holds comes first, then the loss, in one and the same poll.
        let state = front.poll(POLL);
        ensure(state == SourceState::Lost, || format!("{state:?} after the unplugging"))?;
        Ok((Unplugged { front, rear }, "lost with the first poll".into()))
    }
}

/// The front camera's plug is out.
struct Unplugged {
    front: Lane,
    rear: Rear,
}

impl Unplugged {
    fn replug_resumes(&mut self) -> Verdict {
        for _ in 0..10 {
            let state = self.front.poll(POLL);
            ensure(state == SourceState::Lost, || format!("{state:?} without a camera"))?;
        }
        let before = self.front.readings.len();
        // Its clock starts anew; the rear camera sits on another node as before.
        let camera = VirtualZed2::plug_in(Product::Zed2, FRONT, FRONT_MARK).map_err(text)?;
        let back = self.front.poll_until("the return", |lane, _| lane.readings.len() > before)?;
        self.front.take(400)?;
        let (old, new) = self.front.readings.split_at(before);
        let counters = self.front.driver.counters();
        ensure(counters.reconnects == 1, || format!("{counters:?}"))?;
        ensure(old.iter().all(|r| r.epoch == 0), || "an early new epoch".into())?;
        ensure(new.iter().all(|r| r.epoch == 1), || "no new epoch".into())?;
        ensure(new[0].sensor_time < old[0].sensor_time.max(old[before - 1].sensor_time), || {
            "the clock did not start anew".into()
        })?;
        self.front.ensure_unbroken(before)?;
        self.front.ensure_only(FRONT_MARK)?;
        drop(camera);
        Ok(format!("streaming again {} ms after the plug, reconnects = 1", back.as_millis()))
    }

    /// Nothing that happened to the front camera reached the rear lane.
    fn other_camera_is_untouched(self) -> Verdict {
        let (lane, camera) = self.rear.finish()?;
        lane.ensure_only(REAR_MARK)?;
        lane.ensure_unbroken(0)?;
        let (counters, seen) = (lane.driver.counters(), camera.seen());
        // A guest that is starved of processor time falls silent long enough for a new start.
        let starts = 1 + counters.stream_restarts;
        let steady = counters.reconnects == 0 && seen.starts.load(Relaxed) == starts;
        ensure(steady, || format!("{counters:?}, {seen:?}"))?;
        let (count, rate_hz) = (lane.readings.len(), lane.rate_hz(0));
        Ok(format!("{count} samples at {rate_hz:.1} Hz, {} gaps", counters.gaps))
    }
}
