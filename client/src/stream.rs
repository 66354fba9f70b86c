//! Messages as they come, and the latest one.

use std::vec;

use core::time::Duration;

use crate::batch::Batch;
use crate::client::Client;
use crate::error::StreamError;
use crate::health::LaneHealth;
use crate::message::Message;
use crate::sample::Sample;
use crate::subscription::Subscription;
use crate::time::age_of;
use crate::track::Counts;
use crate::world::WorldInfo;

/// The health of one lane.
///
/// ```no_run
/// # let client = lodestone_client::Client::connect()?;
/// let mut health = client.health("front")?;
/// let latest = health.latest()?;
/// println!("{:?} at {:?} Hz", latest.state(), latest.pose_rate_hz());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type HealthStream = Stream<LaneHealth>;

/// The calibrated samples of one camera.
///
/// ```no_run
/// # let client = lodestone_client::Client::connect()?;
/// let mut samples = client.samples("front")?;
/// let batch = samples.all();
/// println!("{} lost", batch.lost);
/// for sample in batch {
///     println!("{} rad/s", sample.angular_rate_rad_s());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type SampleStream = Stream<Sample>;

/// The world that all cameras share; see [`WorldInfo`].
pub type WorldStream = Stream<WorldInfo>;

/// Messages of one kind of one camera; connects by itself, also after a restart of the daemon.
///
/// Stays on the thread that made it.
#[derive(Debug)]
pub struct Stream<M: Message> {
    subscription: Subscription<M>,
    unread: Vec<M>,
    latest: Option<M>,
    reported: Counts,
}

impl<M: Message + Copy> Stream<M> {
    pub(crate) fn new(client: Client, camera: String) -> Self {
        let subscription = Subscription::new(client, camera);
        Self { subscription, unread: Vec::new(), latest: None, reported: Counts::default() }
    }

    /// The camera.
    pub fn camera(&self) -> &str {
        self.subscription.camera()
    }

    /// What this stream has seen.
    pub const fn counts(&self) -> Counts {
        self.subscription.tracker().counts
    }

    /// The newest message; those before it are passed over, [`Stream::all`] no longer sees them.
    ///
    /// # Errors
    /// [`StreamError`] if none ever came.
    pub fn latest(&mut self) -> Result<M, StreamError> {
        while let Some(received) = self.subscription.next() {
            self.latest = received.message.ok().or(self.latest);
        }
        self.latest.ok_or_else(|| nothing(&self.subscription))
    }

    /// Every message since the last call, oldest first, as far as the transport kept them.
    pub fn all(&mut self) -> Batch<vec::Drain<'_, M>> {
        self.unread.clear();
        while let Some(received) = self.subscription.next() {
            self.unread.extend(received.message);
        }
        self.latest = self.unread.last().copied().or(self.latest);
        let (now, before) = (self.counts(), self.reported);
        self.reported = now;
        Batch {
            messages: self.unread.drain(..),
            lost: now.lost - before.lost,
            restarts: now.restarts - before.restarts,
            invalid: now.invalid - before.invalid,
        }
    }

    /// How old the newest message is; `None` if none ever came.
    pub fn age(&self) -> Option<Duration> {
        self.latest?;
        self.subscription.tracker().last_time_ns().map(age_of)
    }
}

/// Why there is nothing.
pub(crate) fn nothing<M: Message>(subscription: &Subscription<M>) -> StreamError {
    match subscription.error() {
        Some(error) => StreamError::NotConnected(error),
        None => StreamError::NothingYet { camera: subscription.camera().into() },
    }
}
