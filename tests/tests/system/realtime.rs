//! Real time, with and without the rights to it.

use std::fs;
use std::process::Command;

use lodestone_tests::system::{
    Daemon, Follower, TestDomain, eventually, lodestone, lodestoned, skipped, without_rights,
};
use rustix::thread::sched_getaffinity;
use serde_json::Value;

const CAMERA: &str =
    "driver = \"synthetic\"\nsynthetic = { trajectory = \"standing\", rest_s = 0.5 }\n";

/// Everything that needs rights, on one camera.
fn demanding(cpu: usize, threads: &str) -> String {
    format!(
        "[realtime]\npolicy = \"fifo\"\npriority = 42\nlock_memory = true\n\
         [lane]\nthreads = \"{threads}\"\n\
         [[camera]]\nname = \"front\"\ncpu = {cpu}\n{CAMERA}"
    )
}

/// The camera's status, once it has been aligned and health has come.
fn settled(domain: &TestDomain) -> Value {
    eventually("the camera is aligned", || {
        let output = lodestone()
            .args(["status", "--json", "--prefix", &domain.prefix, "--root", &domain.root])
            .output()
            .expect("runs");
        let report: Value = serde_json::from_slice(&output.stdout).ok()?;
        let state = report["state"].as_str()?;
        ["running", "degraded"].contains(&state).then_some(report)
    })
}

fn refused(report: &Value) -> Vec<&str> {
    let words = report["real_time_refused"].as_array().expect("health says it");
    words.iter().filter_map(Value::as_str).collect()
}

/// One thread of the daemon, by the kernel's account.
struct Thread {
    name: String,
    /// 1 is `SCHED_FIFO`.
    policy: u32,
    priority: u32,
    cpus: String,
}

fn threads(pid: u32) -> Vec<Thread> {
    let tasks = fs::read_dir(format!("/proc/{pid}/task")).expect("runs").flatten();
    tasks.filter_map(|task| thread(&task.path().display().to_string())).collect()
}

/// Nothing for one that has just ended.
fn thread(task: &str) -> Option<Thread> {
    let stat = fs::read_to_string(format!("{task}/stat")).ok()?;
    // Behind the name in brackets the third field follows; priority is the 40th, policy the 41st.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let status = fs::read_to_string(format!("{task}/status")).ok()?;
    let cpus = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:"))?.trim();
    Some(Thread {
        name: fs::read_to_string(format!("{task}/comm")).ok()?.trim().into(),
        policy: fields.get(38)?.parse().ok()?,
        priority: fields.get(37)?.parse().ok()?,
        cpus: cpus.into(),
    })
}

fn locked_kib(pid: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{pid}/status")).expect("runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmLck:")).expect("is there");
    line.trim().trim_end_matches(" kB").parse().expect("a number")
}

#[test]
fn without_rights_the_lane_runs_on_and_its_health_says_what_it_lacks() {
    let Some(program) = without_rights(&lodestoned()) else { return };
    let domain = TestDomain::new();
    let daemon = Daemon::start_by(program, &domain.configuration(&demanding(1023, "one")));
    let follower = Follower::start(&domain, "front");

    let report = settled(&domain);
    follower.await_more(100);

    assert_eq!(report["state"], "degraded", "{report}");
    assert_eq!(refused(&report), ["scheduling", "memory_lock", "affinity"]);
    let problems = report["problems"].to_string();
    assert!(problems.contains("no real-time priority, though configured"), "{problems}");
    for told in ["RLIMIT_RTPRIO is 0; raise it to 42", "RLIMIT_MEMLOCK is 64 KiB", "cpu 1023"] {
        assert!(daemon.log().contains(told), "no {told:?} in {}", daemon.log());
    }
    assert_eq!(locked_kib(daemon.pid()), 0);
    assert_eq!(follower.stop(), Some(0));
}

#[test]
fn with_rights_the_lanes_threads_have_priority_and_processor_and_no_other_thread_has() {
    let allowed_here = Command::new("chrt").args(["-f", "42", "true"]).output();
    if !allowed_here.is_ok_and(|output| output.status.success()) {
        return skipped("no right to SCHED_FIFO here (chrt -f 42 true)");
    }
    let own = sched_getaffinity(None).expect("can be asked");
    let cpu = (0..1024).rev().find(|cpu| own.is_set(*cpu)).expect("one at least");
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(&demanding(cpu, "two")));

    let report = settled(&domain);

    assert_eq!((refused(&report), &report["state"]), (vec![], &"running".into()), "{report}");
    let threads = threads(daemon.pid());
    let (lane, others): (Vec<_>, Vec<_>) =
        threads.iter().partition(|t| ["lane-front", "driver-front"].contains(&&*t.name));
    assert_eq!(lane.len(), 2, "driver and loop");
    for thread in lane {
        let told = (thread.policy, thread.priority, &*thread.cpus);
        assert_eq!(told, (1, 42, &*cpu.to_string()), "{}", thread.name);
    }
    assert!(others.iter().any(|thread| thread.name == "housekeeping"));
    for thread in others {
        assert_eq!((thread.policy, thread.priority), (0, 0), "{}", thread.name);
    }
    assert!(locked_kib(daemon.pid()) > 0);
}

#[test]
fn what_was_not_asked_for_is_not_refused() {
    let Some(program) = without_rights(&lodestoned()) else { return };
    let domain = TestDomain::new();
    let configuration = domain.configuration(&format!("[[camera]]\nname = \"front\"\n{CAMERA}"));
    let _daemon = Daemon::start_by(program, &configuration);
    let report = settled(&domain);
    assert_eq!((refused(&report), &report["state"]), (vec![], &"running".into()), "{report}");
}
