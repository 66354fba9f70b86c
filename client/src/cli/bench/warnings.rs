//! What makes the figures worse than they need be.

use lodestone_client::latency::{Machine, ThreadSchedule, lane_threads};

use super::super::session::Session;
use super::super::world::patiently;

/// Warnings of the machine and of how the daemon's lanes are scheduled.
pub(super) fn of_system(machine: &Machine, session: &Session, cameras: &[String]) -> Vec<String> {
    let mut warnings = machine.warnings();
    match daemon_pid(session, cameras) {
        Some(pid) => warnings.extend(of_lanes(&lane_threads(pid))),
        None => {
            warnings.push("no health message came: how the lanes are scheduled is unknown".into());
        }
    }
    warnings
}

fn daemon_pid(session: &Session, cameras: &[String]) -> Option<u32> {
    let mut health = session.client.health(cameras.first()?).ok()?;
    patiently(session, || health.latest()).ok().map(|health| health.message().daemon_pid)
}

fn of_lanes(lanes: &[ThreadSchedule]) -> Vec<String> {
    if lanes.is_empty() {
        return vec![
            "the daemon's threads cannot be seen (another container?): how the lanes are \
                     scheduled is unknown"
                .into(),
        ];
    }
    let named = |bad: fn(&ThreadSchedule) -> bool| {
        let names: Vec<&str> = lanes.iter().filter(|l| bad(l)).map(|l| l.name.as_str()).collect();
        (!names.is_empty()).then(|| names.join(", "))
    };
    let unpinned =
        named(|lane| !lane.is_pinned()).map(|names| format!("not pinned to a processor: {names}"));
    let ordinary = named(|lane| !lane.real_time)
        .map(|names| format!("without real-time priority (SCHED_FIFO): {names}"));
    unpinned.into_iter().chain(ordinary).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_that_are_not_pinned_or_not_real_time_are_named() {
        let lane = |name: &str, real_time, processors: &str| ThreadSchedule {
            name: name.into(),
            real_time,
            processors: processors.into(),
        };
        let good = lane("lane-front", true, "1");
        assert_eq!(of_lanes(std::slice::from_ref(&good)), [""; 0]);
        let warnings = of_lanes(&[good, lane("lane-rear", false, "0-1")]);
        assert_eq!(warnings.len(), 2);
        assert!(warnings.iter().all(|w| w.contains("lane-rear") && !w.contains("lane-front")));
        assert!(of_lanes(&[])[0].contains("unknown"));
    }
}
