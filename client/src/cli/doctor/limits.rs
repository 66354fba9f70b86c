//! What this user may ask for: real-time priority and locked memory.

use super::finding::Finding;
use super::machine::{Machine, field};

/// Bits of `CapEff`.
const CAP_IPC_LOCK: u32 = 14;
const CAP_SYS_NICE: u32 = 23;
/// The priority in the shipped vehicle configuration.
const WANTED_PRIORITY: u64 = 50;
/// A daemon with some cameras maps no more than this, without its reserve of address space, bytes.
const LEAST_LOCKED: u64 = 1 << 30;

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let limits = machine.read("/proc/self/limits");
    let status = machine.read("/proc/self/status").unwrap_or_default();
    match limits {
        Ok(limits) => vec![priority(&limits, &status), memory(&limits, &status)],
        Err(why) => vec![Finding::unknown("rtprio", why.clone()), Finding::unknown("memlock", why)],
    }
}

fn priority(limits: &str, status: &str) -> Finding {
    const NAME: &str = "rtprio";
    if has_capability(status, CAP_SYS_NICE) {
        return Finding::ok(NAME, "CAP_SYS_NICE: any real-time priority");
    }
    match soft_limit(limits, "Max realtime priority") {
        None => Finding::unknown(NAME, "/proc/self/limits does not say"),
        Some(limit) if limit >= WANTED_PRIORITY => {
            Finding::ok(NAME, format!("real-time priority up to {limit}"))
        }
        Some(limit) => Finding::better(NAME, format!("real-time priority up to {limit}"))
            .means("realtime.policy = \"fifo\" is refused: any process can delay a lane by milliseconds")
            .change(
                "LimitRTPRIO=90 in the service; for a login: \
                 echo '@lodestone - rtprio 90' | sudo tee /etc/security/limits.d/lodestone.conf",
            ),
    }
}

fn memory(limits: &str, status: &str) -> Finding {
    const NAME: &str = "memlock";
    if has_capability(status, CAP_IPC_LOCK) {
        return Finding::ok(NAME, "CAP_IPC_LOCK: memory may be locked without limit");
    }
    match soft_limit(limits, "Max locked memory") {
        None => Finding::unknown(NAME, "/proc/self/limits does not say"),
        Some(u64::MAX) => Finding::ok(NAME, "memory may be locked without limit"),
        Some(limit) if limit >= LEAST_LOCKED => {
            Finding::ok(NAME, format!("{} MiB may be locked", limit >> 20))
        }
        Some(limit) => Finding::better(NAME, format!("{} KiB may be locked", limit >> 10))
            .means("realtime.lock_memory is refused: under memory pressure a lane waits for the disk")
            .change(
                "LimitMEMLOCK=infinity in the service; for a login: \
                 echo '@lodestone - memlock unlimited' | sudo tee -a /etc/security/limits.d/lodestone.conf",
            ),
    }
}

/// The soft limit of a line in `/proc/PID/limits`; the largest number for none.
pub(super) fn soft_limit(limits: &str, name: &str) -> Option<u64> {
    let soft = field(limits, name)?.split_whitespace().next()?;
    if soft == "unlimited" { Some(u64::MAX) } else { soft.parse().ok() }
}

fn has_capability(status: &str, bit: u32) -> bool {
    let effective = field(status, "CapEff:").and_then(|hex| u64::from_str_radix(hex, 16).ok());
    effective.is_some_and(|bits| bits >> bit & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    const LIMITS: &str = "Limit                     Soft Limit           Hard Limit           Units\n\
        Max locked memory         8388608              8388608              bytes\n\
        Max realtime priority     0                    0\n";

    #[test]
    fn low_limits_are_named_with_what_to_write_where() {
        let found = [priority(LIMITS, "CapEff:\t0"), memory(LIMITS, "")];
        assert_eq!(found.each_ref().map(|f| f.verdict), [Verdict::Better; 2]);
        assert_eq!(found[1].found, "8192 KiB may be locked");
        assert!(found[0].change.as_ref().unwrap().contains("LimitRTPRIO"));
    }

    #[test]
    fn a_capability_goes_before_a_limit() {
        let all = "CapEff:\t000001ffffffffff";
        assert_eq!(priority(LIMITS, all).verdict, Verdict::Ok);
        assert_eq!(memory(LIMITS, all).verdict, Verdict::Ok);
    }

    #[test]
    fn high_limits_are_good_and_missing_ones_unknown() {
        let high =
            LIMITS.replace("8388608 ", "unlimited").replace("priority     0 ", "priority     99");
        assert_eq!(priority(&high, "").verdict, Verdict::Ok);
        assert_eq!(memory(&high, "").verdict, Verdict::Ok);
        assert_eq!(memory("nothing", "").verdict, Verdict::Unknown);
    }
}
