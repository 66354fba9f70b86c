//! Consumers that are stopped and killed, and a daemon that is.

use lodestone_tests::system::{Daemon, Follower, MOST_CONSUMERS, TestDomain, eventually};
use rustix::process::Signal;

const TWO_CAMERAS: &str = r#"
[[camera]]
name = "front"
driver = "synthetic"
synthetic = { rest_s = 1.0, seed = 1 }

[[camera]]
name = "rear"
driver = "synthetic"
synthetic = { rest_s = 1.0, seed = 2 }
"#;

/// More poses than the daemon keeps for a consumer that sleeps.
const MORE_THAN_KEPT: u64 = 700;

/// Every pose came or was told to be lost.
fn assert_nothing_lost_silently(follower: &Follower) {
    eventually("the account of lost poses is complete", || {
        let before = follower.tally();
        let told = follower.told_lost();
        // A complaint and the pose after it come through two pipes.
        (before == follower.tally() && told == before.missing()).then_some(())
    });
}

#[test]
fn given_three_consumers_when_one_sleeps_and_one_is_killed_then_only_they_miss_poses() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(TWO_CAMERAS);
    let daemon = Daemon::start(&configuration);
    let steady = Follower::start(&domain, "front");
    let sleeper = Follower::start(&domain, "front");
    let doomed = Follower::start(&domain, "rear");
    for follower in [&steady, &sleeper, &doomed] {
        follower.await_more(50);
    }

    sleeper.signal(Signal::STOP);
    doomed.kill();
    let successor = Follower::start(&domain, "rear");
    steady.await_more(MORE_THAN_KEPT);
    successor.await_more(50);
    let behind = steady.tally().last_sequence.unwrap();
    sleeper.signal(Signal::CONT);
    sleeper.await_sequence(behind);

    assert!(sleeper.told_lost() > 0, "{}", sleeper.complaints());
    assert!(steady.told_lost() < sleeper.told_lost());
    for follower in [steady, sleeper, successor] {
        assert!(!follower.complaints().contains("restarted"), "{}", follower.complaints());
        assert_nothing_lost_silently(&follower);
        assert_eq!(follower.tally().runs_after_first, 0);
        assert_eq!(follower.stop(), Some(0));
    }
    daemon.signal(Signal::TERM);
    let (code, log) = daemon.ended();
    assert_eq!(code, Some(0), "{log}");
    assert!(!log.contains("WARN") && !log.contains("ERROR"), "{log}");
}

#[test]
fn given_consumers_when_the_daemon_is_killed_and_started_again_then_they_go_on_by_themselves() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(TWO_CAMERAS);
    let first = Daemon::start(&configuration);
    let front = Follower::start(&domain, "front");
    let rear = Follower::start(&domain, "rear");
    let sleeper = Follower::start(&domain, "rear");
    for follower in [&front, &rear, &sleeper] {
        follower.await_more(50);
    }

    sleeper.signal(Signal::STOP);
    first.kill();
    let second = Daemon::start(&configuration);
    for follower in [&front, &rear] {
        eventually("poses of the new run", || {
            let tally = follower.tally();
            (tally.runs_after_first == 1 && tally.poses_of_run >= 50).then_some(())
        });
    }
    sleeper.signal(Signal::CONT);

    for follower in [&front, &rear, &sleeper] {
        eventually("the restart is told", || {
            follower.complaints().contains("the daemon has restarted").then_some(())
        });
        follower.await_more(50);
        assert_nothing_lost_silently(follower);
    }
    second.signal(Signal::TERM);
    assert_eq!(second.ended().0, Some(0));
}

#[test]
fn given_five_rounds_of_kill_and_restart_then_nothing_that_is_left_behind_grows() {
    let domain = TestDomain::new();
    let configuration = domain.configuration(TWO_CAMERAS);
    let witness = {
        let daemon = Daemon::start(&configuration);
        let witness = Follower::start(&domain, "front");
        witness.await_more(10);
        daemon.kill();
        witness
    };
    let mut served = Vec::new();
    for _ in 0..5 {
        let daemon = Daemon::start(&configuration);
        let doomed = Follower::start(&domain, "rear");
        doomed.await_more(10);
        witness.await_more(10);
        doomed.kill();
        // Housekeeping clears up after dead consumers once a second.
        let most = served.first().copied().unwrap_or(usize::MAX);
        served.push(eventually("no more files than in the first round", || {
            let files = domain.all_files().len();
            (files <= most).then_some(files)
        }));
        daemon.kill();
    }
    println!("files in each round: {served:?}");
    let last = Daemon::start(&configuration);
    assert_eq!(witness.stop(), Some(0));
    last.signal(Signal::TERM);
    assert_eq!(last.ended().0, Some(0));
    assert_eq!(domain.memory_in_use(), [""; 0]);
}

#[test]
fn given_more_consumers_than_allowed_then_the_last_is_told_and_comes_in_once_another_goes() {
    let domain = TestDomain::new();
    let daemon = Daemon::start(&domain.configuration(TWO_CAMERAS));
    let mut consumers: Vec<Follower> = Vec::new();
    for _ in 0..MOST_CONSUMERS {
        consumers.push(Follower::start(&domain, "front"));
    }
    for consumer in &consumers {
        consumer.await_more(1);
    }

    let last = Follower::start(&domain, "front");
    eventually("the last one is told", || {
        last.complaints().contains("as many consumers as the daemon allows").then_some(())
    });
    assert_eq!(last.tally().poses, 0);
    let leaving = consumers.swap_remove(0);
    leaving.kill();
    last.await_more(10);

    for consumer in &consumers {
        consumer.await_more(10);
    }
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.ended().0, Some(0));
}
