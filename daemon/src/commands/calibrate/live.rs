//! A camera that is being turned, through the driver that `run` uses.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use lodestone_calibration::{Progress, Sample, calibrate as fit, thinned};
use lodestone_config::Loaded;
use lodestone_schema::transport::Domain;

use super::{CalibrateError, Guidance, Movement, settings};
use crate::cli::CalibrateArgs;
use crate::clock::UnixOffset;
use crate::commands::supervision::LaneContext;
use crate::driver::{Driver, SourceState};
use crate::reading::Reading;
use crate::service::instance::InstanceLock;
use crate::service::signals::StopFlag;
use crate::source;
use crate::status_board::LaneBoard;
use crate::world::WorldFrame;

/// Between two looks at what was collected.
const LOOK: Duration = Duration::from_secs(1);
/// Most samples kept: an hour at 400 Hz, 150 MB.
const MOST_SAMPLES: usize = 400 * 3600;
/// Samples in a mean of the quick look: 100 Hz of 400.
const QUICK_GROUP: usize = 4;

/// Collects until the goal is reached, somebody stops it, or the source ends.
pub(super) fn movement(
    loaded: &Loaded,
    configured: bool,
    serial: u64,
    args: &CalibrateArgs,
    mut guidance: Guidance,
) -> Result<Movement, CalibrateError> {
    let index = index_of(loaded, serial)?;
    let stop = StopFlag::new();
    stop.raise_on_signals().map_err(CalibrateError::Signals)?;
    let root = &loaded.config.shared_memory.root;
    let _lock = InstanceLock::acquire(root).map_err(CalibrateError::Taken)?;
    let camera = &loaded.config.camera[index];
    let settings = settings::of(camera, configured.then_some(&loaded.config.world));
    let opened = source::open(&context(loaded, index, &stop))?;
    guidance.begin(serial, &opened.driver.info().description);
    let collector = Collector::start(opened.driver, stop.clone())?;
    let begin = Instant::now();
    loop {
        thread::sleep(LOOK.min(Duration::from_millis(200)));
        let attempt = fit(&thinned(&collector.samples(), QUICK_GROUP), &settings);
        let progress = Progress::of(&attempt, &settings.limits, args.sigma);
        guidance.show(&progress, begin.elapsed());
        let is_over = args.duration.is_some_and(|limit| begin.elapsed() >= limit);
        if progress.is_complete() || is_over || stop.is_raised() || collector.is_finished() {
            break;
        }
        thread::sleep(LOOK);
    }
    guidance.finish();
    stop.raise();
    Ok(Movement { serial, samples: collector.finish()?, settings })
}

fn index_of(loaded: &Loaded, serial: u64) -> Result<usize, CalibrateError> {
    let cameras = &loaded.config.camera;
    cameras.iter().position(|camera| camera.serial == serial).ok_or_else(|| {
        let serials = cameras.iter().filter(|c| c.serial != 0).map(|c| c.serial.to_string());
        let known = serials.collect::<Vec<_>>().join(", ");
        let known = if known.is_empty() { "none".into() } else { known };
        CalibrateError::UnknownCamera { serial, known }
    })
}

/// What a lane of this camera would be opened with; nothing is published.
fn context(loaded: &Loaded, camera: usize, stop: &StopFlag) -> LaneContext {
    let settings = &loaded.config.shared_memory;
    LaneContext {
        camera,
        loaded: Arc::new(loaded.clone()),
        domain: Domain { prefix: settings.prefix.clone(), root: settings.root.clone() },
        board: Arc::new(LaneBoard::new()),
        unix_offset: UnixOffset::sampled(),
        world: Arc::new(WorldFrame::waiting(1, 1)),
        kept_place: None,
        stop: stop.clone(),
    }
}

/// Reads a driver on a thread of its own, so that a fit never makes it wait.
struct Collector {
    collected: Arc<Mutex<Vec<Sample>>>,
    thread: JoinHandle<()>,
}

impl Collector {
    fn start(driver: Box<dyn Driver>, stop: StopFlag) -> Result<Self, CalibrateError> {
        let collected = Arc::new(Mutex::new(Vec::new()));
        let into = Arc::clone(&collected);
        let thread = thread::Builder::new()
            .name("collector".into())
            .spawn(move || collect(driver, &stop, &into))
            .map_err(|e| CalibrateError::Collector(e.to_string()))?;
        Ok(Self { collected, thread })
    }

    fn samples(&self) -> Vec<Sample> {
        locked(&self.collected).clone()
    }

    fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    fn finish(self) -> Result<Vec<Sample>, CalibrateError> {
        let ended = self.thread.join();
        ended.map_err(|_| CalibrateError::Collector("its thread panicked".into()))?;
        Ok(std::mem::take(&mut *locked(&self.collected)))
    }
}

fn locked(collected: &Mutex<Vec<Sample>>) -> MutexGuard<'_, Vec<Sample>> {
    collected.lock().unwrap_or_else(PoisonError::into_inner)
}

fn collect(mut driver: Box<dyn Driver>, stop: &StopFlag, into: &Mutex<Vec<Sample>>) {
    let (mut readings, mut epoch, mut was_lost) = (Vec::new(), 0, false);
    while !stop.is_raised() {
        let state = driver.poll(Duration::from_millis(100), &mut readings);
        if (state == SourceState::Lost) != was_lost {
            was_lost = state == SourceState::Lost;
            tracing::warn!("the camera {}", if was_lost { "is lost" } else { "is back" });
        }
        let mut collected = locked(into);
        for reading in readings.drain(..) {
            if reading.epoch != epoch {
                // Times of two runs of the sensor's clock do not compare.
                epoch = reading.epoch;
                collected.clear();
                tracing::warn!("the sensor's clock began anew, and so does the calibration");
            }
            collected.push(sample(&reading));
        }
        if state == SourceState::Ended || collected.len() >= MOST_SAMPLES {
            return;
        }
    }
}

/// A saturated reading says nothing: it becomes no number, which the fit leaves out.
pub(crate) fn sample(reading: &Reading) -> Sample {
    let gyro = reading.gyro.vector;
    Sample {
        time_ns: reading.sensor_time.as_nanos(),
        gyro_rad_s: if reading.saturated { glam::DVec3::NAN } else { gyro },
        accel_m_s2: reading.accel.vector,
        mag_ut: reading.mag.map(|mag| mag.vector),
        temperature_c: reading.temperature_c.map(f64::from),
    }
}
