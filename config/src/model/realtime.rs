//! How the threads of the lanes run.

use serde::{Deserialize, Serialize};

/// How the kernel schedules the threads of the lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Policy {
    /// Fair shares with every other process (`SCHED_OTHER`): needs no rights.
    #[default]
    Other,
    /// Before all processes without real-time priority (`SCHED_FIFO`).
    Fifo,
}

/// Real time: what is asked for is tried on each thread it concerns; what is refused is reported, and the
/// lanes run on without it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Realtime {
    /// How the lanes' threads are scheduled; housekeeping and console never are so.
    pub policy: Policy,
    /// Priority under [`Policy::Fifo`], 1 to 98.
    pub priority: u8,
    /// Whether all memory is kept from being paged out.
    pub lock_memory: bool,
    /// How late the kernel may end a sleep of a lane's thread to save a wake-up, ns.
    pub timer_slack_ns: u32,
    /// Stack of each lane's thread that is touched before the first sample, KiB.
    pub prefault_stack_kib: u32,
}

impl Default for Realtime {
    /// What needs no rights.
    fn default() -> Self {
        Self {
            policy: Policy::Other,
            priority: 50,
            lock_memory: false,
            timer_slack_ns: 1000,
            prefault_stack_kib: 128,
        }
    }
}
