//! Runs as `/init`, the only process of a user-mode Linux kernel: plays cameras over `/dev/uhid`
//! and runs the daemon's ZED 2 driver against them. Prints one line per check, `ok NAME: FACTS`
//! or `FAILED NAME: REASON`; then the kernel powers off.

mod lane;
mod scene;

use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};

use crate::lane::Lane;
use crate::scene::Scene;
use lodestone_daemon::driver::zed2::Zed2;
use lodestone_daemon::driver::zed2::discovery::{OpenError, Product, list};
use lodestone_daemon::driver::{Driver, SourceState};
use lodestone_tests::virtual_zed2::VirtualZed2;
use rustix::fs::{Mode, OFlags};
use rustix::mount::MountFlags;
use rustix::system::RebootCommand;

const FRONT: u64 = 31_100_001;
const REAR: u64 = 31_100_002;
const MINI: u64 = 31_100_003;

/// What the cameras send as the gyroscope's raw x.
const FRONT_MARK: i16 = 111;
const REAR_MARK: i16 = -222;

/// No check waits longer: a watchdog powers off, whatever hangs.
const WATCHDOG: Duration = Duration::from_secs(170);
const PATIENCE: Duration = Duration::from_mins(1);
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
    // What the driver logs stands among the checks: it explains a failure.
    tracing_subscriber::fmt()
        .with_ansi(false)
        .with_target(false)
        .with_max_level(tracing_subscriber::filter::LevelFilter::DEBUG)
        .init();
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

/// The words of an error, for `map_err`.
#[expect(clippy::needless_pass_by_value, reason = "`map_err` gives the value away")]
fn text(error: impl ToString) -> String {
    error.to_string()
}

fn absent_is_explained() -> Verdict {
    let message = Zed2::open(FRONT).err().map(text).ok_or("opened a camera that is not there")?;
    ensure(message.contains("no ZED camera is plugged in"), || message.clone())?;
    Ok(message)
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
