//! ZED 2 and ZED 2i over USB HID, without the vendor's SDK.
//!
//! ```text
//! poll ── wait, drain ── raw ── report ── stamps ──> sink        (the lane's thread)
//!   │ ▲
//!   ▼ │ commands, links
//! attendant ── hotplug, discovery, open, start, ping, stop       (a thread of its own)
//! ```
//!
//! Each camera is found by the serial number that is printed on it; several cameras are several
//! drivers. A camera that is unplugged is looked for until it is back, and each time it is opened
//! [`Reading::epoch`] is raised, because its clock may have started anew.
//!
//! # Axes, and how to settle a doubt of 180°
//!
//! Readings are in the sensor's own axes: x down, y to the camera's left, z forward
//! (zed-open-capture, picture `imu_axis`), for gyroscope, accelerometer and magnetometer alike.
//! The configuration's `axis_map` makes the body's forward, left, up of them; its default is
//! `["z", "y", "-x"]`. One public ROS driver uses `(−z, −y, −x)` instead. Both agree that a level
//! camera reads −9.81 m/s² on x, so a camera that just stands cannot tell them apart: they differ
//! by half a turn about the vertical, in which every heading would be off by 180°.
//!
//! A tilt settles it: lift the camera's back so that it looks down by some 30°. The body's forward
//! axis then points below the horizon, and the accelerometer, which at rest reads +9.81 *upward*,
//! must read about −4.9 m/s² on body x. In sensor axes: z goes to −4.9 if the default is right, to
//! +4.9 if the other map is. The same for the left: raise the camera's left side, and body y (the
//! sensor's y by default) must go positive.

mod attendant;
pub mod discovery;
mod hotplug;
pub mod raw;
mod reader;
pub mod report;
mod stamps;

use std::sync::atomic::Ordering;
use std::time::Duration;

use self::attendant::{Attendant, Command, Link};
use self::discovery::{Found, OpenError};
use self::reader::Outcome;
use self::report::Report;
use self::stamps::{Stamps, Step};
use super::{Driver, DriverCounters, DriverInfo, Sink, SourceState};
use crate::reading::{HostTime, Reading, RecordedAiding};

/// Samples per second the camera means to send (seen in the field: 358 to 412).
pub const NOMINAL_RATE_HZ: f64 = 400.0;

/// Time without a readable report after which the stream is started again; the camera is reported lost from here on.
const RESTART_AFTER: Duration = Duration::from_millis(500);

/// Time without a readable report after which the camera is closed and opened again.
const REOPEN_AFTER: Duration = Duration::from_millis(2500);

/// Most that the time between two polls counts as silence, unless the poll was to wait longer: a
/// thread that was not run (a starved or stopped process) has not listened.
const LISTENED_AT_MOST: Duration = Duration::from_millis(100);

/// A camera, found by its serial number.
pub struct Zed2 {
    serial: u64,
    attendant: Attendant,
    /// The open camera; `None` while it is lost.
    stream: Option<Stream>,
    /// What was last known of the camera, for [`Driver::info`].
    known: Option<Found>,
    /// Times the camera was opened.
    openings: u64,
    progress: Progress,
}

/// One opening of the camera.
struct Stream {
    link: Link,
    /// The wake-up of the last poll; at first, when the camera was opened.
    woken: HostTime,
    /// For how long the driver listened since the last readable report.
    silence: Duration,
    restarted: bool,
}

/// What reports are judged against and counted in.
#[derive(Default)]
struct Progress {
    epoch: u32,
    stamps: Stamps,
    counters: DriverCounters,
}

impl Zed2 {
    /// Takes the camera with this serial number, which need not be plugged in yet: the driver is
    /// [`SourceState::Lost`] until it is.
    ///
    /// # Errors
    ///
    /// [`OpenError::Thread`] if the camera's thread cannot be started.
    pub fn new(serial: u64) -> Result<Self, OpenError> {
        Ok(Self {
            serial,
            attendant: Attendant::start(serial)?,
            stream: None,
            known: None,
            openings: 0,
            progress: Progress::default(),
        })
    }

    /// Takes the camera with this serial number, which must be there and may be opened now.
    ///
    /// # Errors
    ///
    /// Says what is plugged in instead, that the model is not supported, or which right is
    /// missing. A caller that wants to wait for the camera goes on with [`Zed2::new`].
    pub fn open(serial: u64) -> Result<Self, OpenError> {
        let found = attendant::probe(serial)?;
        let mut driver = Self::new(serial)?;
        driver.known = Some(found);
        Ok(driver)
    }

    /// Waits for the camera to be opened.
    fn search(&mut self, timeout: Duration) -> SourceState {
        let Some(link) = self.attendant.wait_for_link(timeout) else {
            return SourceState::Lost;
        };
        if self.openings > 0 {
            self.progress.counters.reconnects += 1;
            self.progress.begin_epoch();
        }
        self.openings += 1;
        self.known = Some(link.camera.clone());
        self.stream = Some(Stream::new(link));
        SourceState::Streaming
    }

    /// Hands the dead link back to be closed and looked for again.
    fn lose(&mut self) -> SourceState {
        if let Some(stream) = self.stream.take() {
            self.attendant.ask(Command::Reopen(stream.link));
        }
        SourceState::Lost
    }

    /// What silence means: first start the stream again, then open the camera again.
    fn judge_silence(&mut self) -> SourceState {
        let Some(stream) = &mut self.stream else {
            return SourceState::Lost;
        };
        if stream.silence < RESTART_AFTER {
            return SourceState::Streaming;
        }
        if stream.silence >= REOPEN_AFTER {
            return self.lose();
        }
        if !stream.restarted {
            stream.restarted = true;
            self.progress.counters.stream_restarts += 1;
            self.attendant.ask(Command::Restart);
        }
        SourceState::Lost
    }
}

impl Stream {
    fn new(link: Link) -> Self {
        Self { link, woken: HostTime::now(), silence: Duration::ZERO, restarted: false }
    }

    /// Waits at most `timeout`, then takes everything that has arrived. The time of arrival is
    /// that of the wake-up.
    fn read(&mut self, timeout: Duration, progress: &mut Progress, sink: &mut dyn Sink) -> Outcome {
        let woken = reader::wait(&self.link.fd, timeout);
        let arrival = HostTime::now();
        self.listen(arrival, timeout);
        if woken != Outcome::Open {
            return woken;
        }
        let firmware = self.link.camera.firmware;
        let mut heard = false;
        let outcome = reader::drain(&self.link.fd, |bytes| match Report::parse(bytes, firmware) {
            Ok(report) => {
                heard = true;
                progress.take(&report, arrival, sink);
            }
            Err(_) => progress.counters.malformed += 1,
        });
        if heard {
            self.silence = Duration::ZERO;
            self.restarted = false;
        }
        outcome
    }

    /// Counts the time since the last poll as silence, until something is heard.
    fn listen(&mut self, now: HostTime, timeout: Duration) {
        let since_ns = now.as_nanos() - self.woken.as_nanos();
        let since = Duration::from_nanos(u64::try_from(since_ns).unwrap_or(0));
        self.silence += since.min(timeout.max(LISTENED_AT_MOST));
        self.woken = now;
    }
}

impl Progress {
    /// From here on, stamps have nothing to do with those before.
    fn begin_epoch(&mut self) {
        self.epoch = self.epoch.wrapping_add(1);
        self.stamps = Stamps::default();
    }

    /// Judges a report by its stamp and hands it on.
    fn take(&mut self, report: &Report, arrival: HostTime, sink: &mut dyn Sink) {
        let step = self.stamps.take(report.sensor_time);
        self.count(step);
        if step == Step::Duplicate {
            return;
        }
        if report.imu_valid {
            sink.push(reading(report, self.epoch, arrival));
        } else {
            self.counters.marked_invalid += 1;
        }
    }

    fn count(&mut self, step: Step) {
        let counters = &mut self.counters;
        match step {
            Step::Forward { missing: 0 } => {}
            Step::Forward { missing } => {
                counters.gaps += 1;
                counters.samples_missing += missing;
            }
            Step::Duplicate => counters.duplicates += 1,
            Step::Backward => counters.backwards += 1,
            Step::Restart => {
                counters.clock_restarts += 1;
                self.epoch = self.epoch.wrapping_add(1);
            }
        }
    }
}

fn reading(report: &Report, epoch: u32, arrival: HostTime) -> Reading {
    Reading {
        epoch,
        sensor_time: report.sensor_time,
        arrival,
        gyro: report.gyro,
        accel: report.accel,
        mag: report.mag.fresh(),
        temperature_c: report.imu_temperature_c,
        saturated: report.saturated,
        aiding: RecordedAiding::NONE,
    }
}

impl Driver for Zed2 {
    fn info(&self) -> DriverInfo {
        let description = match &self.known {
            Some(Found { product, firmware: Some(firmware), .. }) => {
                format!("{product} (firmware {firmware})")
            }
            Some(Found { product, .. }) => product.to_string(),
            None => "ZED 2 (not found yet)".into(),
        };
        DriverInfo { description, serial: Some(self.serial), nominal_rate_hz: NOMINAL_RATE_HZ }
    }

    fn poll(&mut self, timeout: Duration, sink: &mut dyn Sink) -> SourceState {
        let Some(stream) = &mut self.stream else {
            return self.search(timeout);
        };
        match stream.read(timeout, &mut self.progress, sink) {
            Outcome::Gone => self.lose(),
            Outcome::Open | Outcome::Silent => self.judge_silence(),
        }
    }

    fn counters(&self) -> DriverCounters {
        let counts = self.attendant.counts();
        DriverCounters {
            pings: counts.pings.load(Ordering::Relaxed),
            pings_failed: counts.pings_failed.load(Ordering::Relaxed),
            ..self.progress.counters
        }
    }
}

#[cfg(test)]
mod tests;
