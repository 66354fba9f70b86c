//! Clock source, timer slack, and the processors' own clocks.

use std::collections::BTreeSet;

use lodestone_client::latency::is_fast_clock;

use super::finding::Finding;
use super::machine::Machine;

/// A process's slack unless it sets another, ns.
const USUAL_SLACK_NS: u64 = 50_000;

pub(super) fn check(machine: &Machine) -> Vec<Finding> {
    let source = "/sys/devices/system/clocksource/clocksource0";
    let current = machine.read(&format!("{source}/current_clocksource"));
    let available = machine.read(&format!("{source}/available_clocksource")).unwrap_or_default();
    let slack = machine.read("/proc/self/timerslack_ns");
    vec![clock_source(current, &available), timer_slack(slack), governor(machine)]
}

fn clock_source(current: Result<String, String>, available: &str) -> Finding {
    const NAME: &str = "clock source";
    let current = match current {
        Ok(current) => current,
        Err(why) => return Finding::unknown(NAME, why),
    };
    if is_fast_clock(&current) {
        return Finding::ok(NAME, current);
    }
    let faster = available.split_whitespace().find(|source| is_fast_clock(source));
    let means =
        "reading the clock is a system call of a microsecond or more, several times a sample";
    Finding::bad(NAME, current).means(means).change(match faster {
        Some(source) => format!(
            "echo {source} | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource"
        ),
        None => "clocksource=tsc tsc=reliable on the kernel's command line, if the processor's counter is \
                 steady (constant_tsc nonstop_tsc in /proc/cpuinfo)"
            .into(),
    })
}

fn timer_slack(slack: Result<String, String>) -> Finding {
    const NAME: &str = "timer slack";
    match slack.map(|text| text.parse::<u64>()) {
        Err(why) => Finding::unknown(NAME, why),
        Ok(Err(_)) => Finding::unknown(NAME, "/proc/self/timerslack_ns is not a number"),
        Ok(Ok(ns)) if ns <= USUAL_SLACK_NS => {
            Finding::ok(NAME, format!("{ns} ns; lanes and waiting consumers set their own"))
        }
        Ok(Ok(ns)) => Finding::better(NAME, format!("{ns} ns"))
            .means("sleeps of other threads of a consumer end up to that much late")
            .change("TimerSlackNSec=50us in the service that starts it"),
    }
}

/// What decides how fast a processor runs when it has just been woken.
fn governor(machine: &Machine) -> Finding {
    const NAME: &str = "governor";
    let of = |cpu: u32| {
        machine.read(&format!("/sys/devices/system/cpu/cpu{cpu}/cpufreq/scaling_governor")).ok()
    };
    judge_governors(&machine.processors().into_iter().filter_map(of).collect(), NAME)
}

fn judge_governors(governors: &BTreeSet<String>, name: &'static str) -> Finding {
    let list = governors.iter().cloned().collect::<Vec<_>>().join(", ");
    match governors.iter().all(|governor| governor == "performance") {
        _ if governors.is_empty() => {
            Finding::unknown(name, "no frequency scaling to be seen (a virtual machine?)")
        }
        true => Finding::ok(name, list),
        false => Finding::better(name, list)
            .means("a lane that sleeps between samples is woken on a slow processor, and its steps take longer")
            .change("sudo cpupower frequency-set -g performance"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    #[test]
    fn a_slow_clock_is_bad_and_a_faster_one_that_is_there_is_named() {
        assert_eq!(clock_source(Ok("kvm-clock".into()), "").verdict, Verdict::Ok);
        let found = clock_source(Ok("hpet".into()), "tsc hpet acpi_pm");
        assert_eq!(found.verdict, Verdict::Bad);
        assert!(found.change.unwrap().starts_with("echo tsc"));
        let none = clock_source(Ok("acpi_pm".into()), "acpi_pm");
        assert!(none.change.unwrap().contains("command line"));
    }

    #[test]
    fn one_processor_that_saves_power_is_enough() {
        let judge = |names: &[&str]| {
            judge_governors(&names.iter().map(|name| (*name).to_owned()).collect(), "g").verdict
        };
        assert_eq!(judge(&["performance"]), Verdict::Ok);
        assert_eq!(judge(&["performance", "powersave"]), Verdict::Better);
        assert_eq!(judge(&[]), Verdict::Unknown);
    }

    #[test]
    fn long_slack_could_be_better() {
        assert_eq!(timer_slack(Ok("50000".into())).verdict, Verdict::Ok);
        assert_eq!(timer_slack(Ok("40000000".into())).verdict, Verdict::Better);
        assert_eq!(timer_slack(Ok("-3".into())).verdict, Verdict::Unknown);
    }
}
