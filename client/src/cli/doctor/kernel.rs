//! How the kernel schedules: preemption, throttling, processors set apart.

use super::finding::Finding;
use super::machine::Machine;

/// Fewer processors leave none to spare.
const ENOUGH_TO_SPARE: usize = 4;

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let read = |path| machine.read(path).ok();
    let throttling = throttling(
        machine.read("/proc/sys/kernel/sched_rt_runtime_us"),
        read("/proc/sys/kernel/sched_rt_period_us").as_deref(),
    );
    let preemption =
        preemption(read("/sys/kernel/realtime").as_deref(), machine.read("/proc/version"));
    let isolated = read("/sys/devices/system/cpu/isolated");
    let without_tick = read("/sys/devices/system/cpu/nohz_full");
    let processors = machine.processors().len();
    vec![preemption, throttling, apart(processors, isolated.as_deref(), without_tick.as_deref())]
}

fn preemption(realtime: Option<&str>, version: Result<String, String>) -> Finding {
    const NAME: &str = "preemption";
    let version = match version {
        Ok(version) => version,
        Err(why) => return Finding::unknown(NAME, why),
    };
    let release = version.split_whitespace().nth(2).unwrap_or("?").to_owned();
    if realtime == Some("1") || version.contains("PREEMPT_RT") {
        return Finding::ok(NAME, format!("PREEMPT_RT kernel {release}"));
    }
    Finding::better(NAME, format!("kernel {release} is not PREEMPT_RT"))
        .means("the kernel's own work can delay a lane, by milliseconds under load")
        .change("sudo apt install linux-image-rt-amd64 (Debian), sudo pro enable realtime-kernel (Ubuntu)")
}

fn throttling(runtime: Result<String, String>, period: Option<&str>) -> Finding {
    const NAME: &str = "rt throttling";
    const RESET: &str = "sudo sysctl kernel.sched_rt_runtime_us=950000";
    let runtime_us: i64 = match runtime.map(|text| text.parse()) {
        Ok(Ok(us)) => us,
        Ok(Err(_)) => return Finding::unknown(NAME, "sched_rt_runtime_us is not a number"),
        Err(why) => return Finding::unknown(NAME, why),
    };
    let period_us = period.and_then(|text| text.parse().ok()).unwrap_or(1_000_000_i64).max(1);
    let found = format!("real-time threads may have {runtime_us} of every {period_us} µs");
    match runtime_us {
        ..=-1 => Finding::ok(NAME, "off: real-time threads are never stopped"),
        0 => {
            Finding::bad(NAME, found).means("no thread runs with real-time priority").change(RESET)
        }
        us if us.saturating_mul(2) < period_us => Finding::better(NAME, found)
            .means("several busy lanes on one processor may be stopped for the rest of each period")
            .change(RESET),
        _ => {
            Finding::ok(NAME, format!("{found}; a lane sleeps between samples and stays far below"))
        }
    }
}

fn apart(processors: usize, isolated: Option<&str>, without_tick: Option<&str>) -> Finding {
    const NAME: &str = "isolated cpus";
    let set =
        |list: Option<&str>| list.filter(|l| !l.is_empty() && *l != "(null)").map(str::to_owned);
    let without_tick = set(without_tick).map_or_else(String::new, |l| format!(", nohz_full {l}"));
    match (set(isolated), processors) {
        (Some(list), _) => Finding::ok(NAME, format!("{list}{without_tick}: use as camera.cpu")),
        (None, 0) => Finding::unknown(NAME, "/sys/devices/system/cpu: not there"),
        (None, few @ ..ENOUGH_TO_SPARE) => {
            Finding::ok(NAME, format!("none; of {few} there is none to spare{without_tick}"))
        }
        (None, many) => {
            let last = many - 1;
            Finding::better(NAME, format!("none of {many}{without_tick}"))
                .means("other processes and interrupts share the lanes' processor")
                .change(format!(
                    "isolcpus=domain,managed_irq,{last} nohz_full={last} on the kernel's command line, then \
                     camera.cpu = {last}"
                ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn a_real_time_kernel_is_known_by_either_sign() {
        let version = || Ok("Linux version 6.12.9-rt-amd64 (x) #1 SMP PREEMPT_RT".to_owned());
        assert_eq!(preemption(None, version()).verdict, Verdict::Ok);
        let plain = || Ok("Linux version 6.12.9-amd64 (x) #1 SMP PREEMPT_DYNAMIC".to_owned());
        assert_eq!(preemption(Some("1"), plain()).verdict, Verdict::Ok);
        let found = preemption(None, plain());
        assert_eq!(found.verdict, Verdict::Better);
        assert!(found.found.contains("6.12.9-amd64"));
    }

    #[test]
    fn throttling_is_judged_by_the_share_it_leaves() {
        use Verdict::{Bad, Better, Ok as Good, Unknown};
        let of = |runtime: &str| throttling(Ok(runtime.into()), Some("1000000")).verdict;
        let verdicts = ["-1", "950000", "100000", "0", "much"].map(of);
        assert_eq!(verdicts, [Good, Good, Better, Bad, Unknown]);
    }

    #[test]
    fn setting_processors_apart_is_advised_where_there_are_enough() {
        assert_eq!(apart(2, Some(""), None).verdict, Verdict::Ok);
        assert_eq!(apart(8, Some("7"), Some("7")).verdict, Verdict::Ok);
        let found = apart(8, Some(""), Some("(null)"));
        assert_eq!(found.verdict, Verdict::Better);
        assert!(found.change.unwrap().contains("nohz_full=7"));
    }
}
