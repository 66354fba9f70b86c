//! The poses of one camera: the latest, all, the next, and the one at a time.

use core::time::Duration;

use lodestone_schema::{Pose, ServiceKind, Status, Validity};

use crate::batch::Batch;
use crate::client::Client;
use crate::error::{LookupError, StreamError};
use crate::history::History;
use crate::limits::LookupLimits;
use crate::message::Message;
use crate::pace::Vigil;
use crate::pose::CameraPose;
use crate::stream::nothing;
use crate::subscription::Subscription;
use crate::time::{Time, age_of, monotonic_now_ns};
use crate::track::Counts;

impl Message for CameraPose {
    type Raw = Pose;
    const KIND: ServiceKind = ServiceKind::Pose;
    const SILENCE: Duration = Duration::from_secs(1);

    fn sequence(raw: &Pose) -> u64 {
        raw.sequence
    }

    fn time_ns(raw: &Pose) -> i64 {
        raw.time_ns
    }
}

/// Settings of a [`PoseStream`].
///
/// ```
/// use std::time::Duration;
/// use lodestone_client::{Client, LookupLimits};
///
/// # let client = Client::builder().prefix("doctest_").root("/dev/shm/lodestone_doctest/").connect()?;
/// let poses = client
///     .pose_stream("front")?
///     .capacity(4000)
///     .limits(LookupLimits { prediction: Duration::from_millis(20), ..LookupLimits::default() })
///     .open();
/// assert!(poses.is_stale());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PoseStreamBuilder {
    client: Client,
    camera: String,
    capacity: usize,
    limits: LookupLimits,
    stale_after: Duration,
    kind: ServiceKind,
}

impl PoseStreamBuilder {
    pub(crate) fn new(client: Client, camera: String) -> Self {
        let stale_after = Duration::from_millis(100);
        let (limits, kind) = (LookupLimits::default(), ServiceKind::Pose);
        Self { client, camera, capacity: 1024, limits, stale_after, kind }
    }

    /// Follows the truth of a synthetic camera instead of its estimate, to compare with.
    #[must_use]
    pub const fn truth(mut self) -> Self {
        self.kind = ServiceKind::Truth;
        self
    }

    /// Poses kept for lookups, at 368 bytes each; default 1024, which is 2.5 s at 400 Hz.
    #[must_use]
    pub const fn capacity(mut self, poses: usize) -> Self {
        self.capacity = poses;
        self
    }

    /// Bounds on interpolation and prediction.
    #[must_use]
    pub const fn limits(mut self, limits: LookupLimits) -> Self {
        self.limits = limits;
        self
    }

    /// Age from which the newest pose counts as stale; default 100 ms.
    #[must_use]
    pub const fn stale_after(mut self, age: Duration) -> Self {
        self.stale_after = age;
        self
    }

    /// Makes the stream, which connects when it is first asked for something.
    pub fn open(self) -> PoseStream {
        PoseStream {
            subscription: Subscription::of_kind(self.client, self.camera, self.kind),
            history: History::new(self.capacity, self.limits),
            stale_after: self.stale_after,
            unread: 0,
            unseen: 0,
            reported: Counts::default(),
            is_ready_for: 0,
            vigil: Vigil::default(),
        }
    }
}

/// The poses of one camera.
///
/// May be made before the daemon runs; connects by itself, and again after a restart of the
/// daemon. While the service is missing or being replaced, a call may take up to 0.2 s; otherwise
/// none but [`PoseStream::wait`] waits. Stays on the thread that made it.
///
/// ```no_run
/// use std::time::Duration;
/// # let client = lodestone_client::Client::connect()?;
/// let mut poses = client.poses("front")?;
/// loop {
///     poses.wait(Duration::from_secs(1))?;
///     let batch = poses.all();
///     if batch.lost > 0 {
///         eprintln!("{} poses lost", batch.lost);
///     }
///     for pose in batch {
///         println!("{} {:?}", pose.time_ns(), pose.position_m());
///     }
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PoseStream {
    subscription: Subscription<CameraPose>,
    history: History,
    stale_after: Duration,
    /// Number (of the history) of the first pose that [`PoseStream::all`] has not given.
    unread: u64,
    /// Number of the first pose that neither `latest` nor `wait` has given.
    unseen: u64,
    reported: Counts,
    /// Number of the pose for which the history has made itself ready.
    is_ready_for: u64,
    vigil: Vigil,
}

impl PoseStream {
    /// The camera.
    pub fn camera(&self) -> &str {
        self.subscription.camera()
    }

    /// What this stream has seen.
    pub const fn counts(&self) -> Counts {
        self.subscription.tracker().counts
    }

    /// The poses kept, as far as they were taken by earlier calls.
    pub const fn history(&self) -> &History {
        &self.history
    }

    /// The newest pose, however old; see [`PoseStream::is_stale`].
    ///
    /// # Errors
    /// [`StreamError`] if none ever came.
    pub fn latest(&mut self) -> Result<CameraPose, StreamError> {
        self.take_waiting();
        self.unseen = self.history.taken();
        self.history.newest().copied().ok_or_else(|| nothing(&self.subscription))
    }

    /// Every pose since the last call, oldest first, and how many are missing.
    ///
    /// Independent of the other calls: what `latest` or `lookup` took is given here too.
    pub fn all(&mut self) -> Batch<impl ExactSizeIterator<Item = &CameraPose>> {
        self.take_waiting();
        let (now, before) = (self.counts(), self.reported);
        let (gone, messages) = self.history.since(self.unread);
        self.reported = now;
        self.unread = self.history.taken();
        Batch {
            messages,
            lost: now.lost - before.lost + gone,
            restarts: now.restarts - before.restarts,
            invalid: now.invalid - before.invalid,
        }
    }

    /// Waits for a pose newer than what `latest` or `wait` gave last, and gives the newest.
    ///
    /// Sleeps until shortly before the next pose is due, by the times at which the last 64 were published, and
    /// looks from then on; how early is what jitter and sleeps of this machine make worth while
    /// for less than 1 % of a processor spent on looking. A publisher that is late or stops is looked for less and
    /// less often, at last every 10 ms. While it sleeps the thread's timer slack is set to 1 ns.
    ///
    /// # Errors
    /// [`StreamError::TimedOut`], or [`StreamError::NotConnected`] if there is no connection when
    /// the time is over.
    pub fn wait(&mut self, timeout: Duration) -> Result<CameraPose, StreamError> {
        let timeout_ns = i64::try_from(timeout.as_nanos()).unwrap_or(i64::MAX);
        let latest_ns = monotonic_now_ns().saturating_add(timeout_ns);
        loop {
            self.take_waiting();
            if self.history.taken() > self.unseen {
                return self.latest();
            }
            if monotonic_now_ns() >= latest_ns {
                return Err(self.timed_out(timeout));
            }
            let connected = self.subscription.error().is_none();
            self.vigil.rest(&self.history, connected, latest_ns);
        }
    }

    /// The pose at a time, with tilt and time known; see [`PoseStream::lookup_with`].
    ///
    /// # Errors
    /// [`LookupError`].
    pub fn lookup(&mut self, time: Time) -> Result<CameraPose, LookupError> {
        self.lookup_with(time, Validity::empty())
    }

    /// The pose at a time, with these fields known besides tilt and time; see
    /// [`History::lookup_with`] for how it is worked out.
    ///
    /// # Errors
    /// [`LookupError`].
    pub fn lookup_with(&mut self, time: Time, fields: Validity) -> Result<CameraPose, LookupError> {
        self.take_waiting();
        let found = self.history.lookup_with(time, fields);
        match (found, self.subscription.error()) {
            (Err(LookupError::Empty), Some(error)) => Err(LookupError::NotConnected(error)),
            (found, _) => found,
        }
    }

    /// How old the newest pose taken is; `None` if none ever came.
    pub fn age(&self) -> Option<Duration> {
        self.history.newest().map(|pose| age_of(pose.time_ns()))
    }

    /// Whether there is no pose, the newest one taken is too old, or the lane says that its sensor
    /// is silent and vouches for nothing. The pose of a camera whose sensor is silent on a body that goes on
    /// without it is not stale.
    pub fn is_stale(&self) -> bool {
        let silent = |pose: &CameraPose| {
            pose.status().contains(Status::SENSOR_STALE)
                && !pose.validity().contains(Validity::TILT)
        };
        self.age().is_none_or(|age| age > self.stale_after)
            || self.history.newest().is_some_and(silent)
    }

    /// Why there is no connection; `None` while there is one.
    pub fn connection_error(&self) -> Option<std::sync::Arc<crate::ConnectError>> {
        self.subscription.error()
    }

    fn take_waiting(&mut self) {
        let before = self.history.taken();
        while let Some(received) = self.subscription.next() {
            if received.restart {
                self.history.break_off();
            }
            if let Ok(pose) = received.message {
                self.history.push(pose);
            }
        }
        let found_nothing = self.history.taken() == before;
        if found_nothing && self.is_ready_for != before {
            self.history.make_ready();
            self.is_ready_for = before;
        }
    }

    fn timed_out(&self, timeout: Duration) -> StreamError {
        match self.subscription.error() {
            Some(error) => StreamError::NotConnected(error),
            None => StreamError::TimedOut {
                camera: self.camera().into(),
                waited_ms: timeout.as_millis(),
            },
        }
    }
}
