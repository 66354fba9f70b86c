//! What the kernel refused, why, and which limit to raise.

use lodestone_schema::RealTimeFlags;
use rustix::io::Errno;

/// Something that was asked for and not granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Real-time priority.
    #[error("SCHED_FIFO {priority} was refused ({errno}): {}", priority_advice(*.priority, *.limit))]
    Scheduling {
        /// The priority asked for.
        priority: u8,
        /// `RLIMIT_RTPRIO`; nothing for no limit.
        limit: Option<u64>,
        /// What the kernel said.
        errno: Errno,
    },
    /// Locked memory.
    #[error("memory is not locked ({errno}): {}", memory_advice(*.limit))]
    MemoryLock {
        /// `RLIMIT_MEMLOCK`, bytes; nothing for no limit.
        limit: Option<u64>,
        /// What the kernel said.
        errno: Errno,
    },
    /// A processor to stay on.
    #[error(
        "cpu {cpu} was refused ({errno}): it is missing, off-line, or outside this service's cpuset \
         (see /sys/devices/system/cpu/online, and AllowedCPUs= of the unit)"
    )]
    Affinity {
        /// The processor asked for.
        cpu: u16,
        /// What the kernel said.
        errno: Errno,
    },
    /// Timer slack.
    #[error("timer slack of {slack_ns} ns was refused ({errno})")]
    TimerSlack {
        /// The slack asked for, ns.
        slack_ns: u32,
        /// What the kernel said.
        errno: Errno,
    },
}

impl Refusal {
    /// The bit that stands for it in health.
    pub const fn flag(&self) -> RealTimeFlags {
        match self {
            Self::Scheduling { .. } => RealTimeFlags::SCHEDULING,
            Self::MemoryLock { .. } => RealTimeFlags::MEMORY_LOCK,
            Self::Affinity { .. } => RealTimeFlags::AFFINITY,
            Self::TimerSlack { .. } => RealTimeFlags::TIMER_SLACK,
        }
    }
}

fn priority_advice(priority: u8, limit: Option<u64>) -> String {
    match limit {
        Some(limit) if limit < u64::from(priority) => format!(
            "RLIMIT_RTPRIO is {limit}; raise it to {priority} (LimitRTPRIO={priority} in the unit, or rtprio in \
             /etc/security/limits.d), or give CAP_SYS_NICE"
        ),
        // A limit that is high enough was not what refused.
        _ => "no limit forbids it: look for a control group without real-time runtime \
              (cpu.rt_runtime_us), or a system call filter"
            .into(),
    }
}

fn memory_advice(limit: Option<u64>) -> String {
    match limit {
        Some(bytes) => format!(
            "RLIMIT_MEMLOCK is {} KiB; raise it (LimitMEMLOCK=infinity in the unit, or memlock in \
             /etc/security/limits.d), or give CAP_IPC_LOCK",
            bytes / 1024
        ),
        None => "no limit forbids it: there is too little memory, or a system call filter".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_limit_is_named_with_what_to_raise_it_to() {
        let refusal = Refusal::Scheduling { priority: 50, limit: Some(0), errno: Errno::PERM };
        let text = refusal.to_string();
        assert!(text.contains("RLIMIT_RTPRIO is 0") && text.contains("LimitRTPRIO=50"), "{text}");
        assert_eq!(refusal.flag(), RealTimeFlags::SCHEDULING);
    }

    #[test]
    fn a_limit_that_would_have_allowed_it_is_not_blamed() {
        for limit in [None, Some(50), Some(99)] {
            let refusal = Refusal::Scheduling { priority: 50, limit, errno: Errno::PERM };
            assert!(!refusal.to_string().contains("raise"), "{refusal}");
        }
    }

    #[test]
    fn locked_memory_names_its_limit_in_kib() {
        let refusal = Refusal::MemoryLock { limit: Some(65_536), errno: Errno::NOMEM };
        assert!(refusal.to_string().contains("RLIMIT_MEMLOCK is 64 KiB"), "{refusal}");
    }
}
