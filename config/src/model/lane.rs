//! How a lane runs and where its poses lie.

use serde::{Deserialize, Serialize};

/// Shared memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SharedMemory {
    /// First part of the name of every file that iceoryx2 makes; consumers need the same.
    pub prefix: String,
    /// Absolute directory of iceoryx2's service and node files; consumers need the same.
    pub root: String,
    /// Poses that a late or slow consumer still finds.
    pub pose_history: usize,
    /// Most consumers of one camera's poses at a time.
    pub max_subscribers: usize,
    /// Raise an iceoryx2 event with every pose, for consumers that want a wake-up.
    pub wake_events: bool,
    /// Publish calibrated sensor samples beside the poses.
    pub publish_samples: bool,
}

impl Default for SharedMemory {
    fn default() -> Self {
        Self {
            prefix: lodestone_schema::DEFAULT_PREFIX.into(),
            // Not under /tmp: cleaners delete the files that make a service findable.
            root: lodestone_schema::DEFAULT_ROOT.into(),
            pose_history: 512,
            max_subscribers: 16,
            wake_events: false,
            publish_samples: true,
        }
    }
}

/// Whether driver and fusion loop share a thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Threads {
    /// One thread reads, steps and publishes: no hand-over to wait for.
    #[default]
    One,
    /// A driver thread fills the ring, and wakes a loop thread that empties it.
    Two,
    /// As two, but the loop sleeps until just before the next reading is due, and then looks.
    Timed,
}

/// How a lane runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lane {
    /// Steps per second of the time grid; the source's nominal rate if absent.
    pub step_rate_hz: Option<f64>,
    /// Samples the ring holds before the oldest is dropped.
    pub ring_capacity: usize,
    /// Driver and loop on one thread or two.
    pub threads: Threads,
    /// Longest gap between samples that is bridged by interpolation, s.
    pub bridge_limit_s: f64,
    /// Silence after which a pose is marked stale, s.
    pub stale_after_s: f64,
    /// Gap after which the filter starts anew, s.
    pub reset_after_s: f64,
}

impl Default for Lane {
    fn default() -> Self {
        Self {
            step_rate_hz: None,
            ring_capacity: 256,
            threads: Threads::One,
            bridge_limit_s: 0.1,
            stale_after_s: 0.1,
            reset_after_s: 0.5,
        }
    }
}
