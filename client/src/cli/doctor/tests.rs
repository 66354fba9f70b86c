//! The checks together, on machines that are made up.

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use lodestone_client::Domain;
use proptest::prelude::*;

use super::examine;
use super::finding::{Finding, Verdict};
use super::machine::Machine;

static MADE: AtomicU32 = AtomicU32::new(0);

/// A directory with files of a machine; it goes with this value.
struct MadeUp(PathBuf);

impl MadeUp {
    fn new(files: &[(&str, &[u8])]) -> Self {
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let name = format!("lodestone-doctor-{}-{number}", std::process::id());
        let root = std::env::temp_dir().join(name);
        for (path, text) in files {
            let path = root.join(path.trim_start_matches('/'));
            fs::create_dir_all(path.parent().expect("a directory")).expect("makes");
            fs::write(path, text).expect("writes");
        }
        fs::create_dir_all(root.join("dev/shm")).expect("makes");
        Self(root)
    }

    fn examine(&self) -> Vec<Finding> {
        let domain = Domain { prefix: "t_".into(), root: "/dev/shm/t/".into() };
        examine(&Machine::at(&self.0), &domain, false)
    }
}

impl Drop for MadeUp {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn found<'f>(findings: &'f [Finding], check: &str) -> &'f Finding {
    findings.iter().find(|f| f.check == check).unwrap_or_else(|| panic!("no check {check}"))
}

/// Every file that a check looks at, in a machine with everything.
const FILES: [(&str, &[u8]); 22] = [
    (
        "/proc/self/limits",
        b"Max locked memory unlimited unlimited bytes\nMax realtime priority 99 99\n",
    ),
    ("/proc/self/status", b"CapEff:\t0000000000000000\n"),
    ("/proc/self/timerslack_ns", b"50000\n"),
    ("/proc/version", b"Linux version 6.12.9-rt (x) #1 SMP PREEMPT_RT\n"),
    ("/proc/sys/kernel/sched_rt_runtime_us", b"950000\n"),
    ("/proc/sys/kernel/sched_rt_period_us", b"1000000\n"),
    ("/proc/swaps", b"Filename Type Size Used Priority\n"),
    ("/sys/kernel/realtime", b"1\n"),
    ("/sys/kernel/mm/transparent_hugepage/enabled", b"always [madvise] never\n"),
    ("/sys/devices/system/cpu/isolated", b"3\n"),
    ("/sys/devices/system/cpu/nohz_full", b"3\n"),
    ("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", b"performance\n"),
    ("/sys/devices/system/clocksource/clocksource0/current_clocksource", b"tsc\n"),
    ("/sys/class/hidraw/hidraw0/device/uevent", b"HID_ID=0003:00002B03:0000F781\nHID_UNIQ=7\n"),
    ("/etc/iceoryx2/iceoryx2.toml", b"[global]\n"),
    ("/etc/systemd/logind.conf", b"[Login]\nRemoveIPC=no\n"),
    ("/run/systemd/system/x", b""),
    ("/etc/udev/rules.d/60-lodestone-zed2.rules", b""),
    ("/dev/shm/t/lodestoned.lock", b"pid 41\nsince_unix_s 1\n"),
    ("/proc/41/status", b"VmLck:\t 8192 kB\n"),
    ("/proc/41/limits", b"Max realtime priority 99 99\n"),
    ("/proc/41/task/42/comm", b"lane-front\n"),
];

#[test]
fn a_machine_that_is_set_up_has_nothing_to_change() {
    let stat = format!("42 (lane-front) S {}50 1 0", "0 ".repeat(36));
    let mut files: Vec<(&str, &[u8])> =
        FILES.into_iter().filter(|(path, _)| !path.contains("iceoryx2")).collect();
    files.push(("/proc/41/task/42/stat", stat.as_bytes()));
    files.push(("/proc/41/task/42/status", b"Cpus_allowed_list:\t3\n"));
    files.push(("/dev/hidraw0", b""));
    let machine = MadeUp::new(&files);
    let findings = machine.examine();
    for check in [
        "rtprio",
        "memlock",
        "preemption",
        "rt throttling",
        "isolated cpus",
        "clock source",
        "timer slack",
        "governor",
        "swap",
        "huge pages",
        "iceoryx2",
        "leftovers",
        "RemoveIPC",
        "udev rules",
        "daemon",
        "lanes",
        "locked memory",
    ] {
        assert_eq!(found(&findings, check).verdict, Verdict::Ok, "{:?}", found(&findings, check));
    }
    assert!(found(&findings, "lanes").found.contains("lane-front FIFO 50 on cpu 3"));
    assert!(found(&findings, "camera").found.contains("ZED 2 serial 7 at /dev/hidraw0"));
}

#[test]
fn where_nothing_can_be_read_nothing_is_called_bad() {
    let machine = MadeUp::new(&[]);
    let findings = machine.examine();
    let bad: Vec<_> = findings.iter().filter(|f| f.verdict == Verdict::Bad).collect();
    // The room in /dev/shm is that of the file system the test runs on.
    assert!(bad.iter().all(|f| f.check == "shared memory"), "{bad:?}");
    assert_eq!(found(&findings, "rtprio").verdict, Verdict::Unknown);
    assert!(found(&findings, "clock source").found.contains("not there"));
}

#[test]
fn whatever_is_not_good_says_what_it_means_and_what_to_change() {
    let poor: [(&str, &[u8]); 12] = [
        ("/proc/self/limits", b"Max locked memory 65536 65536 bytes\nMax realtime priority 0 0\n"),
        ("/proc/version", b"Linux version 6.1.0 (x) #1 SMP\n"),
        ("/proc/sys/kernel/sched_rt_runtime_us", b"0\n"),
        ("/proc/self/timerslack_ns", b"40000000\n"),
        ("/proc/swaps", b"Filename\n/dev/sda2 partition\n"),
        ("/sys/kernel/mm/transparent_hugepage/enabled", b"[always]\n"),
        ("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", b"powersave\n"),
        ("/sys/devices/system/clocksource/clocksource0/current_clocksource", b"hpet\n"),
        ("/sys/class/hidraw/hidraw0/device/uevent", b"HID_ID=0003:00002B03:0000F781\n"),
        ("/etc/iceoryx2/iceoryx2.toml", b"global = 3\n"),
        ("/run/systemd/system/x", b""),
        ("/dev/hidraw9", b""),
    ];
    let findings = MadeUp::new(&poor).examine();
    let wrong: Vec<_> = findings.iter().filter(|f| f.verdict >= Verdict::Better).collect();
    assert!(wrong.len() >= 12, "{wrong:?}");
    for finding in wrong.iter().filter(|f| f.check != "shared memory") {
        assert!(finding.means.is_some() && finding.change.is_some(), "{finding:?}");
        assert!(finding.to_text().contains(finding.check));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn garbage_in_any_file_never_panics(
        texts in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..80), FILES.len()),
        // Garbage alone, or behind what the file should say.
        behind in any::<bool>(),
    ) {
        let texts: Vec<Vec<u8>> = FILES
            .iter()
            .zip(&texts)
            .map(|((_, good), garbage)| if behind { [*good, garbage].concat() } else { garbage.clone() })
            .collect();
        let files: Vec<(&str, &[u8])> =
            FILES.iter().zip(&texts).map(|((path, _), text)| (*path, text.as_slice())).collect();
        let machine = MadeUp::new(&files);
        prop_assert!(machine.examine().len() >= 15);
    }
}
