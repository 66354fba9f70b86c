//! Every key of real time, and those that pin threads.

use super::Kind::{Choice, Switch, Whole};
use super::{Key, key};

/// The largest number of a processor that Linux knows, with its usual limit of 1024.
const LAST_CPU: i64 = 1023;

pub(super) const REALTIME: &[Key] = &[
    key(
        "policy",
        Choice(&["other", "fifo"]),
        "",
        "How the lanes' threads are scheduled: fairly with everything else, or before every process \
         without real-time priority (SCHED_FIFO), which needs RLIMIT_RTPRIO or CAP_SYS_NICE. \
         Housekeeping and console stay with \"other\".",
    ),
    key(
        "priority",
        Whole(1, 98),
        "",
        "Priority with policy \"fifo\". Threads of the kernel that serve interrupts have 50 under \
         PREEMPT_RT: below that the lanes wait for them. 99 is the kernel's own.",
    ),
    key(
        "lock_memory",
        Switch,
        "",
        "Whether all memory is kept from being paged out (mlockall), which needs RLIMIT_MEMLOCK or \
         CAP_IPC_LOCK. Without it, a machine that is short of memory stalls a lane by milliseconds.",
    ),
    key(
        "timer_slack_ns",
        Whole(1, 10_000_000),
        "ns",
        "How late the kernel may end a sleep of a lane's thread. Small: less delay. Large: fewer \
         wake-ups. The system's own is 50000; SCHED_FIFO has none.",
    ),
    key(
        "prefault_stack_kib",
        Whole(0, 1024),
        "KiB",
        "How much of its stack a lane's thread touches before the first sample, so that it takes no page \
         fault later. 0 touches none.",
    ),
];

pub(super) const CAMERA_CPU: Key = key(
    "cpu",
    Whole(0, LAST_CPU),
    "",
    "Processor that the threads of the camera's lane stay on, counted from 0; any if absent. One that \
     the machine does not have is reported, and the lane runs anywhere.",
);

pub(super) const BODY_CPU: Key = key(
    "cpu",
    Whole(0, LAST_CPU),
    "",
    "Processor that the thread of its cameras' common filter stays on, counted from 0; any if absent. \
     The threads that read the cameras have camera.cpu.",
);
