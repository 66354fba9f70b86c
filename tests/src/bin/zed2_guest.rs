//! Runs as `/init`, the only process of a user-mode Linux kernel: plays cameras over `/dev/uhid`
//! and runs the daemon's ZED 2 driver against them. Prints one line per check, `ok NAME: FACTS`
//! or `FAILED NAME: REASON`; then the kernel powers off.

use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lodestone_daemon::driver::zed2::Zed2;
use lodestone_daemon::driver::zed2::discovery::{OpenError, Product, list};
use lodestone_daemon::driver::zed2::raw::RawReport;
use lodestone_daemon::driver::{Driver, DriverCounters, SourceState};
use lodestone_daemon::reading::Reading;
use lodestone_tests::virtual_zed2::{TICKS_PER_SAMPLE, VirtualZed2};
use rustix::fs::{Mode, OFlags};
use rustix::mount::MountFlags;
use rustix::system::RebootCommand;

const FRONT: u64 = 31_100_001;
const REAR: u64 = 31_100_002;
const MINI: u64 = 31_100_003;

/// What the cameras send as the gyroscope's raw x.
const FRONT_MARK: i16 = 111;
const REAR_MARK: i16 = -222;
const RAD_S: f64 = 1000.0 / 32768.0 * std::f64::consts::PI / 180.0;

/// No check waits longer: a watchdog powers off, whatever hangs.
const WATCHDOG: Duration = Duration::from_secs(170);
const PATIENCE: Duration = Duration::from_secs(60);
const POLL: Duration = Duration::from_millis(50);

type Verdict = Result<String, String>;

fn main() {
    if std::env::args().nth(1).as_deref() == Some("open") {
        // The other user of `permission_is_explained`.
        print!("{}", Zed2::open(FRONT).err().map_or("opened".into(), |error| error.to_string()));
        return;
    }
    if std::process::id() != 1 {
        eprintln!("zed2-guest is the init of a virtual machine; see tests/zed2_in_kernel.rs");
        std::process::exit(2);
    }
    if let Err(error) = mount_all() {
        println!("FAILED mount: {error}");
    }
    std::thread::spawn(|| {
        std::thread::sleep(WATCHDOG);
        println!("FAILED watchdog: not done after {} s", WATCHDOG.as_secs());
        power_off();
    });
    // A panic of init would take the kernel's console with it.
    let run = std::panic::catch_unwind(run_all);
    println!("{}", if run.is_ok() { "done" } else { "FAILED panic: see above" });
    power_off();
}

fn mount_all() -> rustix::io::Result<()> {
    for (kind, target) in [("devtmpfs", c"/dev"), ("proc", c"/proc"), ("sysfs", c"/sys")] {
        rustix::mount::mount(kind, target, kind, MountFlags::empty(), None)?;
    }
    // Panics and logs go where the checks go.
    let console = rustix::fs::open("/dev/console", OFlags::WRONLY, Mode::empty())?;
    rustix::stdio::dup2_stderr(&console)
}

fn power_off() {
    let _ = rustix::system::reboot(RebootCommand::PowerOff);
}

fn report(name: &str, verdict: Verdict) {
    match verdict {
        Ok(facts) => println!("ok {name}: {facts}"),
        Err(reason) => println!("FAILED {name}: {reason}"),
    }
}

fn run_all() {
    report("absent-is-explained", absent_is_explained());
    match Scene::set() {
        Ok(scene) => scene.play(),
        Err(error) => println!("FAILED scene: {error}"),
    }
    report("clean-stop", clean_stop());
    report("waits-for-the-camera", waits_for_the_camera());
}

fn ensure(holds: bool, otherwise: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise()) }
}

fn text(error: impl ToString) -> String {
    error.to_string()
}

fn absent_is_explained() -> Verdict {
    let message = Zed2::open(FRONT).err().map(text).ok_or("opened a camera that is not there")?;
    ensure(message.contains("no ZED camera is plugged in"), || message.clone())?;
    Ok(message)
}

/// A driver and all it has given.
struct Lane {
    driver: Zed2,
    readings: Vec<Reading>,
}

impl Lane {
    fn open(serial: u64) -> Result<Self, String> {
        Ok(Self { driver: Zed2::open(serial).map_err(text)?, readings: Vec::new() })
    }

    fn poll(&mut self, timeout: Duration) -> SourceState {
        self.driver.poll(timeout, &mut self.readings)
    }

    /// Polls until `done`, or patience ends.
    fn poll_until(
        &mut self,
        what: &str,
        mut done: impl FnMut(&Self, SourceState) -> bool,
    ) -> Result<Duration, String> {
        let start = Instant::now();
        while start.elapsed() < PATIENCE {
            let state = self.poll(POLL);
            if done(self, state) {
                return Ok(start.elapsed());
            }
        }
        Err(format!("{what} did not happen: {:?}", self.driver.counters()))
    }

    fn take(&mut self, samples: usize) -> Result<(), String> {
        let goal = self.readings.len() + samples;
        self.poll_until("streaming", |lane, _| lane.readings.len() >= goal).map(drop)
    }

    fn ensure_only(&self, mark: i16) -> Result<(), String> {
        let expected = f64::from(mark) * RAD_S;
        let stranger = self.readings.iter().find(|r| (r.gyro.vector.x - expected).abs() > 1e-12);
        ensure(stranger.is_none(), || format!("a sample of another camera: {stranger:?}"))
    }

    /// The samples in sensor time from `from` on: none missing, none twice.
    fn ensure_unbroken(&self, from: usize) -> Result<(), String> {
        let period = i64::try_from(TICKS_PER_SAMPLE).map_err(text)? * 78_125 / 2;
        let breaks = self.readings[from..]
            .windows(2)
            .filter(|pair| (pair[1].sensor_time - pair[0].sensor_time).as_nanos() != period)
            .count();
        ensure(breaks == 0, || format!("{breaks} breaks: {:?}", self.driver.counters()))
    }

    /// Samples per second by arrival, from a reading on.
    fn rate_hz(&self, from: usize) -> f64 {
        let readings = &self.readings[from..];
        let (Some(first), Some(last)) = (readings.first(), readings.last()) else {
            return 0.0;
        };
        let span_ns = last.arrival.as_nanos() - first.arrival.as_nanos();
        (readings.len() - 1) as f64 * 1e9 / span_ns as f64
    }
}

/// Three cameras are plugged in; two lanes read two of them, the rear one on a thread of its own
/// from the beginning to the end.
struct Scene {
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
    fn set() -> Result<Self, String> {
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

    fn play(mut self) {
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
        self.front_camera.be_deaf(true);
        let taken = self.front.take(800);
        self.front_camera.be_deaf(false);
        taken?;
        self.front.ensure_unbroken(from)?;
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
        let steady = counters.reconnects == 0 && seen.starts.load(Relaxed) == 1;
        ensure(steady, || format!("{counters:?}, {seen:?}"))?;
        let (count, rate_hz) = (lane.readings.len(), lane.rate_hz(0));
        Ok(format!("{count} samples at {rate_hz:.1} Hz, {} gaps", counters.gaps))
    }
}

fn wait_for_nodes(count: usize) -> Result<(), String> {
    let start = Instant::now();
    while list().map_err(text)?.0.len() < count {
        ensure(start.elapsed() < PATIENCE, || "the kernel made no hidraw node".into())?;
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(())
}

fn mini_is_refused() -> Verdict {
    match Zed2::open(MINI) {
        Err(error @ OpenError::Unsupported { .. }) => Ok(text(error)),
        Err(error) => Err(text(error)),
        Ok(_) => Err("opened a ZED Mini".into()),
    }
}

fn others_are_listed() -> Verdict {
    let message = Zed2::open(99).err().map(text).ok_or("opened number 99")?;
    let complete = [FRONT, REAR, MINI].iter().all(|serial| message.contains(&serial.to_string()));
    ensure(complete, || message.clone())?;
    Ok(message)
}

fn permission_is_explained() -> Verdict {
    let output = Command::new("/init").arg("open").uid(65_534).output().map_err(text)?;
    let message = String::from_utf8_lossy(&output.stdout).into_owned();
    ensure(message.contains("udev rule is missing"), || message.clone())?;
    Ok(message)
}

fn clean_stop() -> Verdict {
    let camera = VirtualZed2::plug_in(Product::Zed2, FRONT, FRONT_MARK).map_err(text)?;
    wait_for_nodes(1)?;
    let mut lane = Lane::open(FRONT)?;
    lane.take(100)?;
    drop(lane);
    let stops = camera.seen().stops.load(Relaxed);
    ensure(stops == 1, || format!("{stops} stop commands"))?;
    ensure(!attendants_are_left().map_err(text)?, || "the driver left a thread behind".into())?;
    Ok("one stop command, no thread left".into())
}

/// Whether a driver's thread is still there; one that was joined may take a moment to vanish.
fn attendants_are_left() -> std::io::Result<bool> {
    let start = Instant::now();
    while start.elapsed() < PATIENCE {
        let mut names = Vec::new();
        for task in std::fs::read_dir("/proc/self/task")? {
            names.push(std::fs::read_to_string(task?.path().join("comm")).unwrap_or_default());
        }
        if !names.iter().any(|name| name.starts_with("zed2-attendant")) {
            return Ok(false);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(true)
}

fn waits_for_the_camera() -> Verdict {
    let mut lane = Lane { driver: Zed2::new(REAR).map_err(text)?, readings: Vec::new() };
    let state = lane.poll(POLL);
    ensure(state == SourceState::Lost, || format!("{state:?} without a camera"))?;
    let _camera = VirtualZed2::plug_in(Product::Zed2i, REAR, REAR_MARK).map_err(text)?;
    lane.take(100)?;
    lane.ensure_only(REAR_MARK)?;
    let (info, counters) = (lane.driver.info(), lane.driver.counters());
    ensure(counters.reconnects == 0, || "the first opening is no reconnect".into())?;
    ensure(info.description == "ZED 2i", || info.description.clone())?;
    Ok("started before the camera, streams once it is there".into())
}
