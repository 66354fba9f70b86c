//! The daemon that serves this domain: whether it got what makes it be in time.

use lodestone_client::Domain;
use lodestone_schema::transport::LOCK_FILE;

use super::finding::Finding;
use super::limits::soft_limit;
use super::machine::{Machine, field};

/// `SCHED_FIFO` and `SCHED_RR` in `/proc/PID/stat`.
const REAL_TIME: [&str; 2] = ["1", "2"];
/// How the lanes' threads begin their names.
const LANES: [&str; 2] = ["lane-", "driver-"];

pub(super) fn check(machine: &Machine, domain: &Domain) -> Vec<Finding> {
    const NAME: &str = "daemon";
    let lock = machine.read(&format!("{}/{LOCK_FILE}", domain.root.trim_end_matches('/')));
    let pid = lock.ok().and_then(|text| field(&text, "pid ")?.parse::<u32>().ok());
    let status = pid.and_then(|pid| machine.read(&format!("/proc/{pid}/status")).ok());
    let (Some(pid), Some(status)) = (pid, status) else {
        return vec![Finding::unknown(NAME, format!("none serves {}", domain.root))];
    };
    let limits = machine.read(&format!("/proc/{pid}/limits")).unwrap_or_default();
    let lanes = lanes(machine, pid);
    vec![
        Finding::ok(NAME, format!("process {pid} serves {}", domain.root)),
        scheduling(&lanes, &limits),
        locked(&status, &limits),
    ]
}

/// One thread on the way of samples.
#[derive(Clone, Debug, PartialEq, Eq)]
struct LaneThread {
    name: String,
    real_time: bool,
    priority: String,
    cpus: String,
}

fn lanes(machine: &Machine, pid: u32) -> Vec<LaneThread> {
    let of = |task: &String| {
        let read = |file| machine.read(&format!("/proc/{pid}/task/{task}/{file}")).ok();
        let name = read("comm")?;
        let (real_time, priority) = policy(&read("stat")?)?;
        let cpus = field(&read("status")?, "Cpus_allowed_list:")?.to_owned();
        let ours = LANES.iter().any(|prefix| name.starts_with(prefix));
        ours.then_some(LaneThread { name, real_time, priority, cpus })
    };
    machine.names_in(&format!("/proc/{pid}/task")).iter().filter_map(of).collect()
}

/// Whether a thread has real-time priority, and which: fields 41 and 40 of its `stat`.
fn policy(stat: &str) -> Option<(bool, String)> {
    // The name in brackets may hold anything; behind it the third field follows.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    Some((REAL_TIME.contains(fields.get(38)?), (*fields.get(37)?).to_owned()))
}

fn scheduling(lanes: &[LaneThread], limits: &str) -> Finding {
    const NAME: &str = "lanes";
    if lanes.is_empty() {
        return Finding::unknown(NAME, "its threads cannot be seen");
    }
    let show = |lane: &LaneThread| {
        let policy = if lane.real_time { "FIFO" } else { "other" };
        format!("{} {policy} {} on cpu {}", lane.name, lane.priority, lane.cpus)
    };
    let found = lanes.iter().map(show).collect::<Vec<_>>().join("; ");
    if lanes.iter().all(|lane| lane.real_time) {
        return Finding::ok(NAME, found);
    }
    let limit = soft_limit(limits, "Max realtime priority").unwrap_or(0);
    Finding::better(NAME, found)
        .means("any busy process delays them, by milliseconds at worst")
        .change(format!(
            "realtime.policy = \"fifo\" in its configuration, and LimitRTPRIO=90 in the service (its limit is \
             {limit})"
        ))
}

fn locked(status: &str, limits: &str) -> Finding {
    const NAME: &str = "locked memory";
    let kib = field(status, "VmLck:").and_then(|text| text.split_whitespace().next()?.parse().ok());
    match kib {
        None => Finding::unknown(NAME, "its status does not say"),
        Some(1_u64..) => Finding::ok(NAME, format!("{} MiB", kib.unwrap_or(0) >> 10)),
        Some(0) => {
            let limit = match soft_limit(limits, "Max locked memory") {
                Some(u64::MAX) => "none".into(),
                limit => format!("{} KiB", limit.unwrap_or(0) >> 10),
            };
            Finding::better(NAME, "none")
                .means("under memory pressure a lane waits for a disk")
                .change(format!(
                    "realtime.lock_memory = true in its configuration, and LimitMEMLOCK=infinity in the \
                     service (its limit is {limit})"
                ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    /// A thread's `stat` with priority and policy at their places.
    fn stat(priority: u32, policy: u32) -> String {
        let zeros = "0 ".repeat(36);
        format!("7 (lane-a) b) S {zeros}{priority} {policy} 0 0")
    }

    #[test]
    fn policy_and_priority_are_found_behind_any_name() {
        assert_eq!(policy(&stat(50, 1)), Some((true, "50".into())));
        assert_eq!(policy(&stat(0, 0)), Some((false, "0".into())));
        assert_eq!(policy("7 (lane-a S 1 2"), None);
        assert_eq!(policy(")"), None);
    }

    #[test]
    fn one_lane_without_priority_is_enough_to_say_so() {
        let lane = |real_time| LaneThread {
            name: "lane-front".into(),
            real_time,
            priority: "50".into(),
            cpus: "1".into(),
        };
        assert_eq!(scheduling(&[lane(true)], "").verdict, Verdict::Ok);
        let found = scheduling(&[lane(true), lane(false)], "Max realtime priority  20  20");
        assert_eq!(found.verdict, Verdict::Better);
        assert!(found.change.unwrap().contains("its limit is 20"));
        assert_eq!(scheduling(&[], "").verdict, Verdict::Unknown);
    }

    #[test]
    fn locked_memory_is_read_from_the_status() {
        assert_eq!(locked("VmLck:\t    4096 kB", "").found, "4 MiB");
        assert_eq!(locked("VmLck:\t 0 kB", "").verdict, Verdict::Better);
        assert_eq!(locked("VmLck: many", "").verdict, Verdict::Unknown);
    }
}
