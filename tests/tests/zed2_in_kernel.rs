//! The ZED 2 driver against a real kernel's HID stack: hidraw, sysfs, devtmpfs, inotify.
//!
//! A user-mode Linux boots with one program, `zed2-guest`, that plays cameras over `/dev/uhid`
//! and runs the driver against them.

use std::io::Write;
use std::path::Path;
use std::time::Duration;

use lodestone_tests::kernel::Kernel;

/// Far beyond what it takes, and beyond the guest's own watchdog.
const LIMIT: Duration = Duration::from_mins(4);

const CHECKS: [&str; 14] = [
    "absent-is-explained",
    "mini-is-refused",
    "others-are-listed",
    "permission-is-explained",
    "streams",
    "pings",
    "garbage-is-survived",
    "blocked-commands-do-not-block",
    "silence-is-restarted",
    "unplug-is-noticed",
    "replug-resumes",
    "other-camera-is-untouched",
    "clean-stop",
    "waits-for-the-camera",
];

#[test]
fn the_driver_holds_its_promises_on_a_real_kernel() {
    let kernel = match Kernel::find() {
        Ok(kernel) => kernel,
        Err(missing) => {
            // Past the harness, which swallows what a passing test prints.
            let _ = writeln!(std::io::stderr(), "skipped: {missing}");
            return;
        }
    };
    let guest = Path::new(env!("CARGO_BIN_EXE_zed2-guest"));

    let output = kernel.boot(guest, LIMIT).expect("the kernel boots");

    println!("{}", output.console);
    assert!(!output.timed_out, "the kernel did not power off by itself");
    for check in CHECKS {
        let passed = output.console.lines().any(|line| line.starts_with(&format!("ok {check}:")));
        assert!(passed, "{check} failed or did not run; the console is above");
    }
    assert!(output.console.lines().any(|line| line == "done"), "the guest did not end well");
}
