//! The computer that latencies were measured on, as far as they depend on it.

use std::fs;

use serde::Serialize;

/// What a reader of figures must know of the computer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Machine {
    /// The processor's name.
    pub cpu: String,
    /// Processors that are on.
    pub cores: usize,
    /// Whether a hypervisor runs it.
    pub virtual_machine: bool,
    /// Name, release and flavour of the kernel.
    pub kernel: String,
    /// The frequency governor of the first processor, where there is one.
    pub governor: Option<String>,
    /// What the kernel's clock runs on.
    pub clock_source: Option<String>,
}

impl Machine {
    /// This computer.
    pub fn observed() -> Self {
        let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let governor = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
        let clock = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
        let uname = rustix::system::uname();
        let words = [uname.sysname(), uname.release(), uname.version()];
        Self {
            cpu: field(&info, "model name").unwrap_or_else(|| "unknown processor".into()),
            cores: info.lines().filter(|line| line.starts_with("processor")).count(),
            virtual_machine: field(&info, "flags")
                .is_some_and(|flags| flags.split(' ').any(|flag| flag == "hypervisor")),
            kernel: words.map(|word| word.to_string_lossy().into_owned()).join(" "),
            governor: one_line(governor),
            clock_source: one_line(clock),
        }
    }

    /// One line for people.
    pub fn told(&self) -> String {
        let kind = if self.virtual_machine { ", virtual machine" } else { "" };
        format!("{}, {} cores{kind}; {}", self.cpu, self.cores, self.kernel)
    }

    /// What makes latencies worse here than they need be.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Some(governor) = self.governor.as_deref().filter(|name| *name != "performance") {
            warnings.push(format!(
                "frequency governor {governor:?}: processors slow down between poses; \
                 \"performance\" keeps them awake"
            ));
        }
        if let Some(clock) = self.clock_source.as_deref().filter(|name| !is_fast_clock(name)) {
            warnings.push(format!("clock source {clock:?}: each stamp costs a system call"));
        }
        if self.cores < 2 {
            warnings.push("one processor: whoever polls keeps the lane from it".into());
        }
        warnings
    }
}

/// Whether a process reads this clock source of the kernel without a system call.
pub fn is_fast_clock(source: &str) -> bool {
    ["tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page", "riscv_clocksource"]
        .contains(&source)
}

fn field(info: &str, name: &str) -> Option<String> {
    let line = info.lines().find(|line| line.split(':').next().map(str::trim) == Some(name))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

fn one_line(path: &str) -> Option<String> {
    Some(fs::read_to_string(path).ok()?.trim().to_owned())
}

/// How the kernel schedules one thread.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ThreadSchedule {
    /// The thread's name, as the kernel cuts it.
    pub name: String,
    /// It has a real-time policy (`SCHED_FIFO` or `SCHED_RR`).
    pub real_time: bool,
    /// The processors it may run on, as the kernel writes them: `0`, `0-3,8`.
    pub processors: String,
}

impl ThreadSchedule {
    /// Whether it may run on one processor only.
    pub fn is_pinned(&self) -> bool {
        self.processors.parse::<u32>().is_ok()
    }
}

/// The lanes of a daemon, by its process number; none if it is gone.
pub fn lane_threads(pid: u32) -> Vec<ThreadSchedule> {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).into_iter().flatten().flatten();
    let mut lanes: Vec<ThreadSchedule> = tasks
        .filter_map(|task| {
            let read = |file: &str| fs::read_to_string(task.path().join(file)).ok();
            schedule_of(&read("stat")?, &read("status")?)
        })
        .filter(|thread| thread.name.starts_with("lane-"))
        .collect();
    lanes.sort_by(|a, b| a.name.cmp(&b.name));
    lanes
}

/// Reads `/proc/PID/task/TID/stat` and `status` (`proc_pid_stat(5)`).
fn schedule_of(stat: &str, status: &str) -> Option<ThreadSchedule> {
    // The name stands in brackets and may hold brackets and spaces itself.
    let (name, rest) = stat.split_once('(')?.1.rsplit_once(") ")?;
    // `rest` begins with field 3; policy is field 41.
    let policy = rest.split(' ').nth(41 - 3)?;
    Some(ThreadSchedule {
        name: name.into(),
        real_time: matches!(policy, "1" | "2"),
        processors: field(status, "Cpus_allowed_list")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAT: &str = "4242 (lane-a) b) S 1 1 1 0 -1 4194368 0 0 0 0 0 0 0 0 -51 0 5 0 100 0 0 \
                        18446744073709551615 0 0 0 0 0 0 0 0 0 0 0 0 -1 1 50 1 0 0 0 0 0 0 0 0 0 0 0";

    #[test]
    fn policy_and_processors_are_read_past_any_name() {
        let status = "Name:\tlane-a) b\nCpus_allowed:\t2\nCpus_allowed_list:\t1\n";
        let thread = schedule_of(STAT, status).expect("reads");
        assert_eq!(thread.name, "lane-a) b");
        assert!(thread.real_time && thread.is_pinned());
        let ordinary = STAT.replace(" 50 1 0", " 0 0 0");
        let both = status.replace("list:\t1", "list:\t0-1");
        let thread = schedule_of(&ordinary, &both).expect("reads");
        assert!(!thread.real_time && !thread.is_pinned());
        assert_eq!(schedule_of("", ""), None);
    }

    #[test]
    fn this_computer_has_a_name_and_processors() {
        let machine = Machine::observed();
        assert!(machine.cores >= 1, "{machine:?}");
        assert!(machine.told().contains(&machine.kernel));
    }

    #[test]
    fn a_machine_that_saves_power_is_warned_of() {
        let good = Machine {
            cpu: "x".into(),
            cores: 2,
            virtual_machine: false,
            kernel: "Linux".into(),
            governor: Some("performance".into()),
            clock_source: Some("tsc".into()),
        };
        assert_eq!(good.warnings(), [""; 0]);
        let bad = Machine {
            cores: 1,
            governor: Some("powersave".into()),
            clock_source: Some("hpet".into()),
            ..good
        };
        assert_eq!(bad.warnings().len(), 3);
    }
}
