//! The thread that looks after one camera: finds it, opens it, starts its stream, pings it.
//!
//! A feature report can block for 5 s in the kernel, and while it does, opening and closing any
//! hidraw device blocks as well (one lock for all minors). So everything that can block happens
//! here, the closing of a lost device's descriptor included; the driver's poll only ever waits on
//! a descriptor that this thread handed to it.
//!
//! Feature reports and time-out: zed-open-capture, `include/sensorcapture_def.hpp:48-70`.

use std::ffi::CStr;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use hidapi::{HidDevice, HidError};
use rustix::event::{EventfdFlags, PollFd, PollFlags, Timespec};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;

use super::discovery::{self, Found, OpenError};
use super::hotplug::Watch;

const REPORT_STREAM: u8 = 0x32;
const STREAM_ON: [u8; 2] = [REPORT_STREAM, 0x01];
const STREAM_OFF: [u8; 2] = [REPORT_STREAM, 0x00];
const PING: [u8; 2] = [0x21, 0xf2];

/// The stream stops 6 s after the last ping; the vendor's library pings every second.
const PING_PERIOD: Duration = Duration::from_secs(1);

/// How often to look for a lost camera if `/dev` gives no notice.
const RESCAN_PERIOD: Duration = Duration::from_secs(1);

/// An open camera, ready to be read.
pub(super) struct Link {
    /// Its hidraw descriptor, not blocking.
    pub(super) fd: OwnedFd,
    /// What was opened.
    pub(super) camera: Found,
}

/// What the driver asks for.
pub(super) enum Command {
    /// Start the stream again.
    Restart,
    /// The link is dead: close it and look for the camera again.
    Reopen(Link),
}

/// What the thread counted.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Pings the device took.
    pub(super) pings: AtomicU64,
    /// Pings that failed.
    pub(super) pings_failed: AtomicU64,
}

/// The driver's end of the thread.
pub(super) struct Attendant {
    /// `None` only while it is dropped: hanging up is how the thread is told to stop.
    commands: Option<SyncSender<Command>>,
    wake: Arc<OwnedFd>,
    links: Receiver<Link>,
    counts: Arc<Counts>,
    thread: Option<JoinHandle<()>>,
}

impl Attendant {
    /// Starts the thread, which begins to look for the camera.
    ///
    /// # Errors
    ///
    /// [`OpenError::Thread`] if threads or descriptors are used up.
    pub(super) fn start(serial: u64) -> Result<Self, OpenError> {
        let flags = EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK;
        let wake = rustix::event::eventfd(0, flags).map_err(|e| OpenError::Thread(e.into()))?;
        let wake = Arc::new(wake);
        let (command_sender, commands) = sync_channel(4);
        let (link_sender, links) = sync_channel(1);
        let counts = Arc::new(Counts::default());
        let duty = Duty {
            serial,
            commands,
            wake: Arc::clone(&wake),
            links: link_sender,
            counts: Arc::clone(&counts),
            watch: None,
            complaint: String::new(),
        };
        let thread = std::thread::Builder::new()
            .name("zed2-attendant".into())
            .spawn(move || duty.run())
            .map_err(OpenError::Thread)?;
        Ok(Self { commands: Some(command_sender), wake, links, counts, thread: Some(thread) })
    }

    /// Asks for something; never blocks.
    pub(super) fn ask(&self, command: Command) {
        if let Some(commands) = &self.commands {
            // The channel holds more than one link can ask for; a dead thread takes nothing.
            let _ = commands.try_send(command);
            self.ring();
        }
    }

    /// Waits at most `timeout` for an open camera.
    pub(super) fn wait_for_link(&self, timeout: Duration) -> Option<Link> {
        self.links.recv_timeout(timeout).ok()
    }

    /// What the thread counted.
    pub(super) fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Wakes the thread; a full eventfd means it is awake already.
    fn ring(&self) {
        let _ = rustix::io::write(&self.wake, &1_u64.to_ne_bytes());
    }
}

impl Drop for Attendant {
    /// Stops the stream and joins the thread; a feature report under way takes up to 5 s.
    fn drop(&mut self) {
        self.commands = None;
        self.ring();
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread of a ZED 2 panicked");
        }
    }
}

/// Why a wait ended.
enum Woken {
    /// The driver asked for something.
    Command(Command),
    /// The driver is gone.
    Stop,
    /// Time is up, or `/dev` gave notice.
    Due,
}

/// The thread's own state.
struct Duty {
    serial: u64,
    commands: Receiver<Command>,
    wake: Arc<OwnedFd>,
    links: SyncSender<Link>,
    counts: Arc<Counts>,
    /// Watches `/dev` while the camera is looked for.
    watch: Option<Watch>,
    /// What was logged last, so that a rescan repeats nothing.
    complaint: String,
}

impl Duty {
    fn run(mut self) {
        while let Some((device, link)) = self.find() {
            if self.links.send(link).is_err() || !self.attend(&device) {
                break;
            }
        }
    }

    /// Looks for the camera until it is open; `None` when the driver is gone.
    fn find(&mut self) -> Option<(HidDevice, Link)> {
        // Watch first, then look: a camera that comes in between is not missed.
        self.watch = Watch::new("/dev").map_err(|e| self.complain(&e)).ok();
        let opened = loop {
            tracing::debug!(serial = self.serial, "looks for the camera");
            match open(self.serial) {
                Ok(opened) => break opened,
                Err(error) => self.complain(&error),
            }
            if let Woken::Stop = self.wait(Instant::now() + RESCAN_PERIOD) {
                return None;
            }
        };
        self.watch = None;
        self.complaint.clear();
        tracing::info!(camera = %opened.1.camera, "opened");
        Some(opened)
    }

    /// Streams and pings until the link is lost (true) or the driver is gone (false).
    fn attend(&mut self, device: &HidDevice) -> bool {
        self.start_stream(device);
        let mut next_ping = Instant::now();
        loop {
            match self.wait(next_ping) {
                Woken::Command(Command::Restart) => self.start_stream(device),
                Woken::Command(Command::Reopen(link)) => {
                    tracing::warn!(camera = %link.camera, "lost");
                    return true;
                }
                Woken::Stop => {
                    self.stop_stream(device);
                    return false;
                }
                Woken::Due => next_ping = self.ping(device, next_ping),
            }
        }
    }

    fn start_stream(&mut self, device: &HidDevice) {
        let started = device.send_feature_report(&STREAM_ON).and_then(|()| stream_state(device));
        match started {
            Ok(true) => self.complaint.clear(),
            Ok(false) => self.complain(&"the camera took the start command and does not stream"),
            Err(error) => self.complain(&error),
        }
    }

    fn stop_stream(&mut self, device: &HidDevice) {
        if let Err(error) = device.send_feature_report(&STREAM_OFF) {
            self.complain(&error);
        }
    }

    /// Pings and says when the next ping is due: by the clock, not a period after this answer.
    fn ping(&mut self, device: &HidDevice, due: Instant) -> Instant {
        match device.send_feature_report(&PING) {
            Ok(()) => self.counts.pings.fetch_add(1, Ordering::Relaxed),
            Err(error) => {
                self.complain(&error);
                self.counts.pings_failed.fetch_add(1, Ordering::Relaxed)
            }
        };
        // Pings that were missed while the device blocked are not made up for.
        (due + PING_PERIOD).max(Instant::now())
    }

    /// Waits for the driver, a notice from `/dev` (while it is watched) or the clock.
    fn wait(&self, until: Instant) -> Woken {
        loop {
            match self.commands.try_recv() {
                Ok(command) => return Woken::Command(command),
                Err(TryRecvError::Disconnected) => return Woken::Stop,
                Err(TryRecvError::Empty) => {}
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() || self.sleep(left) {
                return Woken::Due;
            }
        }
    }

    /// Sleeps; whether `/dev` gave notice of a hidraw node.
    fn sleep(&self, at_most: Duration) -> bool {
        let wake = PollFd::new(&*self.wake, PollFlags::IN);
        let watch = self.watch.as_ref().map_or(self.wake.as_fd(), AsFd::as_fd);
        let mut fds = [wake, PollFd::from_borrowed_fd(watch, PollFlags::IN)];
        // Interrupted or refused: the caller looks at the clock and comes again.
        let _ = rustix::event::poll(&mut fds, Some(&timespec(at_most)));
        let _ = rustix::io::read(&*self.wake, &mut [0; 8]);
        self.watch.as_ref().is_some_and(Watch::take)
    }

    /// Logs what is wrong, once for as long as it stays the same.
    fn complain(&mut self, problem: &dyn std::fmt::Display) {
        let text = problem.to_string();
        if text != self.complaint {
            tracing::warn!(serial = self.serial, "{text}");
            self.complaint = text;
        }
    }
}

/// Opens the camera twice: for feature reports (hidapi) and for reading (see [`super::reader`]).
fn open(serial: u64) -> Result<(HidDevice, Link), OpenError> {
    let (api, present) = discovery::scan()?;
    let camera = discovery::pick(serial, present)?;
    let fd = open_for_reading(&camera.path)?;
    let device = api
        .open_path(&camera.path)
        .map_err(|source| OpenError::Commands { path: node(&camera), source })?;
    Ok((device, Link { fd, camera }))
}

/// Tries whether the camera is there and may be opened, and closes it again.
pub(super) fn probe(serial: u64) -> Result<Found, OpenError> {
    let camera = discovery::pick(serial, discovery::list()?)?;
    open_for_reading(&camera.path)?;
    Ok(camera)
}

fn open_for_reading(path: &CStr) -> Result<OwnedFd, OpenError> {
    // Read and write, though only read: the rights that feature reports will need.
    let flags = OFlags::RDWR | OFlags::NONBLOCK | OFlags::CLOEXEC;
    rustix::fs::open(path, flags, Mode::empty()).map_err(|errno| {
        let path = path.to_string_lossy().into_owned();
        match errno {
            Errno::ACCESS | Errno::PERM => OpenError::Permission { path },
            other => OpenError::Open { path, source: other.into() },
        }
    })
}

fn node(camera: &Found) -> String {
    camera.path.to_string_lossy().into_owned()
}

/// Whether the camera says that it streams.
fn stream_state(device: &HidDevice) -> Result<bool, HidError> {
    let mut answer = [REPORT_STREAM, 0, 0, 0];
    let length = device.get_feature_report(&mut answer)?;
    Ok(length >= 2 && answer[1] == 1)
}

/// A span for `poll`, saturating.
pub(super) fn timespec(span: Duration) -> Timespec {
    Timespec {
        tv_sec: i64::try_from(span.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: i64::from(span.subsec_nanos()),
    }
}
