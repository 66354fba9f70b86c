//! A ZED 2 played over `/dev/uhid`.
//!
//! It does what is known of the real one: it streams input report 0x01 after `32 01`, stops after
//! `32 00` or 6 s without a ping, tells its state in feature report 0x32. The report descriptor
//! of the real camera is not public; a vendor-page one with the same reports serves.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lodestone_daemon::driver::zed2::discovery::{Product, VENDOR};
use lodestone_daemon::driver::zed2::raw::RawReport;
use rustix::event::{PollFd, PollFlags, Timespec};

use crate::uhid::{Description, Device, Request};

/// Silence from the host after which the camera stops streaming.
pub const PING_LIMIT: Duration = Duration::from_secs(6);

/// Ticks (39.0625 µs) and time from one sample to the next.
pub const TICKS_PER_SAMPLE: u64 = 64;
const SAMPLE_PERIOD: Duration = Duration::from_micros(2500);

/// A new magnetometer reading with every eighth sample: 50 Hz.
const MAG_EVERY: u64 = 8;

/// Samples sent at once when the camera comes late, a quarter of the kernel's ring. A camera that
/// is later than that was starved of processor time, as was its reader: its clock waits for it.
const BURST: usize = 16;

const EIO: u16 = 5;

#[rustfmt::skip]
const REPORT_DESCRIPTOR: &[u8] = &[
    0x06, 0x00, 0xff,       // usage page: vendor
    0x09, 0x01, 0xa1, 0x01, // usage 1, collection: application
    0x15, 0x00, 0x26, 0xff, 0x00, 0x75, 0x08, // values of 8 bits, 0 to 255
    0x85, 0x01, 0x95, 0x3f, 0x09, 0x01, 0x81, 0x02, // report 0x01: 63 bytes in
    0x85, 0x21, 0x95, 0x01, 0x09, 0x02, 0xb1, 0x02, // report 0x21: 1 byte feature
    0x85, 0x22, 0x95, 0x03, 0x09, 0x03, 0xb1, 0x02, // report 0x22: 3 bytes feature
    0x85, 0x32, 0x95, 0x01, 0x09, 0x04, 0xb1, 0x02, // report 0x32: 1 byte feature
    0xc0,
];

/// What the camera saw and did; nothing decreases.
#[derive(Debug, Default)]
pub struct Seen {
    /// Start commands.
    pub starts: AtomicU64,
    /// Stop commands.
    pub stops: AtomicU64,
    /// Pings.
    pub pings: AtomicU64,
    /// Times the stream ended because nobody pinged.
    pub expired: AtomicU64,
    /// Samples sent.
    pub samples: AtomicU64,
    /// Whether it leaves feature reports without an answer.
    deaf: AtomicBool,
    /// Told to fall silent, as if its firmware had stumbled.
    stumble: AtomicBool,
    stop: AtomicBool,
}

/// A virtual camera that is plugged in.
pub struct VirtualZed2 {
    seen: Arc<Seen>,
    extra: Arc<Mutex<VecDeque<Vec<u8>>>>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl VirtualZed2 {
    /// Plugs a camera in. Each of its samples carries `mark` as the gyroscope's raw x, so that
    /// two cameras can be told apart by what they send.
    ///
    /// # Errors
    ///
    /// The kernel has no uhid, or this user may not use it.
    pub fn plug_in(product: Product, serial: u64, mark: i16) -> io::Result<Self> {
        let device = Device::create(&Description {
            name: &format!("STEREOLABS {product}"),
            serial: &serial.to_string(),
            vendor: VENDOR,
            product: product.id(),
            report_descriptor: REPORT_DESCRIPTOR,
        })?;
        let seen = Arc::new(Seen::default());
        let extra = Arc::new(Mutex::new(VecDeque::new()));
        let play = Play {
            device,
            mark,
            seen: Arc::clone(&seen),
            extra: Arc::clone(&extra),
            sample: 0,
            due: None,
            pinged: Instant::now(),
            unanswered: Vec::new(),
        };
        let thread = std::thread::Builder::new().spawn(move || play.run())?;
        Ok(Self { seen, extra, thread: Some(thread) })
    }

    /// What the camera saw so far.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Sends these bytes as a report of its own, before the next sample.
    pub fn send_also(&self, report: Vec<u8>) {
        self.extra.lock().unwrap_or_else(PoisonError::into_inner).push_back(report);
    }

    /// Falls silent until it is started again.
    pub fn stumble(&self) {
        self.seen.stumble.store(true, Ordering::Relaxed);
    }

    /// Leaves feature reports unanswered, or answers them (late) and all that follow.
    pub fn be_deaf(&self, deaf: bool) {
        self.seen.deaf.store(deaf, Ordering::Relaxed);
    }

    /// Pulls the plug.
    ///
    /// # Errors
    ///
    /// What went wrong while the camera played.
    pub fn unplug(mut self) -> io::Result<()> {
        self.end()
    }

    fn end(&mut self) -> io::Result<()> {
        self.seen.stop.store(true, Ordering::Relaxed);
        let played = self.thread.take().map(JoinHandle::join);
        played.map_or(Ok(()), |end| end.unwrap_or_else(|_| Err(io::Error::other("it panicked"))))
    }
}

impl Drop for VirtualZed2 {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

/// The camera's firmware.
struct Play {
    device: Device,
    mark: i16,
    seen: Arc<Seen>,
    extra: Arc<Mutex<VecDeque<Vec<u8>>>>,
    sample: u64,
    /// When the next sample is due; `None` while the stream is off.
    due: Option<Instant>,
    pinged: Instant,
    /// Feature reports that came while it was deaf.
    unanswered: Vec<Request>,
}

impl Play {
    fn run(mut self) -> io::Result<()> {
        // A starved reader loses samples, a starved camera only comes late: the reader goes first.
        rustix::process::setpriority_process(None, 19)?;
        while !self.seen.stop.load(Ordering::Relaxed) {
            self.wait()?;
            self.hear()?;
            self.expire();
            self.send_due()?;
        }
        Ok(())
    }

    /// Waits for a request or the next sample, but looks up now and then.
    fn wait(&self) -> io::Result<()> {
        let idle = Duration::from_millis(5);
        let left = self.due.map_or(idle, |due| due.saturating_duration_since(Instant::now()));
        let timeout = Timespec { tv_sec: 0, tv_nsec: i64::from(left.min(idle).subsec_nanos()) };
        let mut fds = [PollFd::new(&self.device, PollFlags::IN)];
        rustix::event::poll(&mut fds, Some(&timeout))?;
        Ok(())
    }

    fn hear(&mut self) -> io::Result<()> {
        while let Some(request) = self.device.next_request()? {
            self.unanswered.push(request);
        }
        if self.seen.deaf.load(Ordering::Relaxed) {
            return Ok(());
        }
        for request in std::mem::take(&mut self.unanswered) {
            match request {
                Request::Set { id, data } => {
                    let error = if self.obey(&data) { 0 } else { EIO };
                    self.device.answer_set(id, error)?;
                }
                Request::Get { id, report: 0x32 } => {
                    let state = u8::from(self.due.is_some());
                    self.device.answer_get(id, Ok(&[0x32, state]))?;
                }
                Request::Get { id, .. } => self.device.answer_get(id, Err(EIO))?,
                Request::Opened | Request::Closed | Request::Other => {}
            }
        }
        Ok(())
    }

    /// Does what a feature report says; whether it knows it.
    fn obey(&mut self, report: &[u8]) -> bool {
        let counter = match report {
            [0x32, 0x01] => {
                self.pinged = Instant::now();
                self.due = self.due.or(Some(self.pinged));
                &self.seen.starts
            }
            [0x32, 0x00] => {
                self.due = None;
                &self.seen.stops
            }
            [0x21, 0xf2] => {
                self.pinged = Instant::now();
                &self.seen.pings
            }
            _ => return false,
        };
        counter.fetch_add(1, Ordering::Relaxed);
        true
    }

    /// Stops the stream when nobody pinged, or when told to stumble.
    fn expire(&mut self) {
        if self.due.is_some() && self.pinged.elapsed() > PING_LIMIT {
            self.due = None;
            self.seen.expired.fetch_add(1, Ordering::Relaxed);
        }
        if self.seen.stumble.swap(false, Ordering::Relaxed) {
            self.due = None;
        }
    }

    /// Sends the samples that are due, none left out.
    fn send_due(&mut self) -> io::Result<()> {
        for _ in 0..BURST {
            let Some(due) = self.due.filter(|due| *due <= Instant::now()) else {
                return Ok(());
            };
            let extra = self.extra.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
            if let Some(report) = extra {
                self.device.input(&report)?;
            }
            self.device.input(&self.report().emit())?;
            self.seen.samples.fetch_add(1, Ordering::Relaxed);
            self.sample += 1;
            self.due = Some(due + SAMPLE_PERIOD);
        }
        self.due = Some(Instant::now() + SAMPLE_PERIOD);
        Ok(())
    }

    /// A level camera at rest, in a field of some 48 µT.
    fn report(&self) -> RawReport {
        let age = |every| if self.sample.is_multiple_of(every) { 2 } else { 1 };
        RawReport {
            struct_id: 1,
            ticks: self.sample * TICKS_PER_SAMPLE,
            gyro: [self.mark, 0, 0],
            accel: [-4096, 0, 0],
            imu_temperature: 3_150,
            mag_valid: age(MAG_EVERY),
            mag: [688, 0, 336],
            env_valid: age(2 * MAG_EVERY),
            temperature: 2_400,
            pressure: 9_600_000,
            humidity: 4_100,
            image_temperature: [4_000, 4_050],
            ..RawReport::default()
        }
    }
}
