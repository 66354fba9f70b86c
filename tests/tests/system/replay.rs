//! `lodestoned replay` on good recordings, and on streams with gaps.

use std::fs;
use std::io::Read;
use std::process::Stdio;

use glam::{DQuat, DVec3};
use lodestone_client::Status;
use lodestone_config::model::TrajectoryKind;
use lodestone_tests::system::{
    PoseLine, Recorded, Replayed, compressed, eventually, lodestoned, replay,
};
use rustix::process::{Pid, Signal, kill_process};

/// Replays rows of a recording.
fn replayed(recorded: &Recorded) -> Replayed {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("made.csv");
    recorded.write(&path);
    let replayed = replay(&path, &directory.path().join("poses"), &[]);
    assert_eq!(replayed.code, Some(0), "{}", replayed.log);
    replayed
}

/// A recording without the rows of a span of sensor time, s after the first row.
fn with_gap(recorded: &Recorded, from_s: f64, length_s: f64) -> Recorded {
    let begin = recorded.rows[0].time_ns;
    let inside = |time_ns: i64| {
        let t = (time_ns - begin) as f64 * 1e-9;
        t > from_s && t < from_s + length_s
    };
    let kept = recorded.rows.iter().zip(&recorded.truth).filter(|(row, _)| !inside(row.time_ns));
    let (rows, truth) = kept.map(|(row, truth)| (*row, *truth)).unzip();
    Recorded { rows, truth }
}

fn any_status(poses: &[PoseLine], status: Status) -> bool {
    poses.iter().any(|pose| Status::from_bits_retain(pose.status).contains(status))
}

#[test]
fn a_recording_gives_the_same_bytes_twice_plain_or_compressed_one_row_for_each_row() {
    let directory = tempfile::tempdir().unwrap();
    let recorded = Recorded::of(TrajectoryKind::Walk, 3, 12.0);
    let plain = directory.path().join("walk.csv");
    let packed = directory.path().join("packed.csv.zst");
    recorded.write(&plain);
    fs::write(&packed, compressed(recorded.csv().as_bytes())).unwrap();

    let first = replay(&plain, &directory.path().join("first"), &[]);
    let second = replay(&plain, &directory.path().join("second"), &[]);
    let third = replay(&packed, &directory.path().join("third"), &[]);

    assert_eq!(first.code, Some(0), "{}", first.log);
    assert_eq!(first.unbroken_poses().len(), recorded.rows.len());
    assert_eq!(first.count("rows"), recorded.rows.len() as u64);
    assert!(first.bytes == second.bytes, "two replays differ");
    assert!(first.bytes == third.bytes, "compression makes a difference");
}

#[test]
fn on_a_walk_the_orientation_stays_close_to_the_truth() {
    for seed in [1, 2] {
        let recorded = Recorded::of(TrajectoryKind::Walk, seed, 60.0);
        let poses = replayed(&recorded).unbroken_poses();
        let (mut tilt, mut heading, mut count) = (0.0, 0.0, 0.0);
        for (pose, truth) in poses.iter().zip(&recorded.truth) {
            let Some(estimate) = pose.orientation else { continue };
            let (t, h) = errors_deg(estimate, *truth);
            (tilt, heading, count) = (tilt + t * t, heading + h * h, count + 1.0);
        }
        let (tilt_deg, heading_deg) = ((tilt / count).sqrt(), (heading / count).sqrt());
        println!("seed {seed}: tilt {tilt_deg:.3}°, heading {heading_deg:.3}°");
        assert!(tilt_deg < 1.0, "seed {seed}: tilt {tilt_deg:.3}° RMS");
        assert!(heading_deg < 5.0, "seed {seed}: heading {heading_deg:.3}° RMS");
    }
}

/// Angles between the two up directions, and of the rest, degrees.
fn errors_deg(estimate: DQuat, truth: DQuat) -> (f64, f64) {
    let error = estimate * truth.conjugate();
    let tilt = (error * DVec3::Z).angle_between(DVec3::Z);
    let heading = 2.0 * error.z.abs().atan2(error.w.abs());
    (tilt.to_degrees(), heading.to_degrees())
}

#[test]
fn given_a_gap_of_50_ms_then_it_is_bridged_and_counted() {
    let whole = Recorded::of(TrajectoryKind::Walk, 5, 10.0);
    let gappy = with_gap(&whole, 6.0, 0.05);
    let lost = whole.rows.len() - gappy.rows.len();
    let replayed = replayed(&gappy);
    let poses = replayed.unbroken_poses();
    assert_eq!(replayed.count("lost"), lost as u64);
    assert_eq!(replayed.count("resets"), 0);
    assert!(any_status(&poses, Status::BRIDGED) && !any_status(&poses, Status::DEGRADED));
}

#[test]
fn given_a_gap_of_half_a_second_then_the_filter_goes_on_degraded() {
    let whole = Recorded::of(TrajectoryKind::Walk, 5, 10.0);
    let gappy = with_gap(&whole, 6.0, 0.5);
    let replayed = replayed(&gappy);
    let poses = replayed.unbroken_poses();
    assert_eq!(poses.len(), gappy.rows.len());
    assert_eq!(replayed.count("lost"), (whole.rows.len() - gappy.rows.len()) as u64);
    assert_eq!(replayed.count("resets"), 0);
    assert!(any_status(&poses, Status::DEGRADED));
}

#[test]
fn given_a_gap_of_three_seconds_then_the_filter_starts_anew_and_aligns_again() {
    let whole = Recorded::of(TrajectoryKind::Standing, 5, 12.0);
    let gappy = with_gap(&whole, 4.0, 3.0);
    let replayed = replayed(&gappy);
    let poses = replayed.poses();
    assert_eq!(poses.len(), gappy.rows.len());
    assert_eq!(replayed.count("resets"), 1);
    // The rows between the gap and the alignment have their poses from looking back: they are those of
    // the camera that stood all the while, not of the filter before the gap.
    let after = poses.iter().position(|p| p.time_s - poses[0].time_s > 6.9).unwrap();
    let found = poses[after].orientation.expect("found looking back");
    let last = poses.last().unwrap().orientation.expect("aligned again");
    assert!(found.angle_between(last).to_degrees() < 0.1, "{found} then, {last} later");
    assert!(poses[after - 1].orientation.is_some());
}

#[test]
fn without_a_magnetometer_tilt_is_known_and_the_heading_is_not_claimed() {
    let recorded = Recorded::of(TrajectoryKind::Walk, 7, 12.0);
    let mut empty = recorded.clone();
    empty.rows.iter_mut().for_each(|row| row.mag = None);
    for text in [recorded.csv_without_magnetometer(), empty.csv()] {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("made.csv");
        fs::write(&path, text).unwrap();
        let replayed = replay(&path, &directory.path().join("poses"), &[]);
        assert_eq!(replayed.code, Some(0), "{}", replayed.log);
        let poses = replayed.unbroken_poses();
        assert_eq!(poses.len(), recorded.rows.len());
        assert!(replayed.log.contains("no magnetometer"), "{}", replayed.log);
        let last = poses.last().unwrap().orientation.unwrap();
        let tilt_deg = errors_deg(last, *recorded.truth.last().unwrap()).0;
        assert!(tilt_deg < 2.0, "tilt {tilt_deg:.3}°");
        let text = String::from_utf8_lossy(&replayed.bytes);
        // Without a heading its standard deviation is empty and its source is none.
        assert!(text.lines().skip(1).all(|row| row.split(',').nth(11) == Some("")));
        assert!(text.lines().skip(1).all(|row| row.split(',').nth(17) == Some("0")));
    }
}

#[test]
fn given_a_signal_then_a_replay_says_that_its_poses_are_not_complete() {
    let directory = tempfile::tempdir().unwrap();
    let (file, out) = (directory.path().join("walk.csv"), directory.path().join("poses"));
    Recorded::of(TrajectoryKind::Walk, 3, 60.0).write(&file);
    let arguments = ["replay", "--speed", "1", "--out"];
    let mut replay =
        lodestoned().args(arguments).args([&out, &file]).stderr(Stdio::piped()).spawn().unwrap();
    eventually("the replay begins", || out.join("walk.csv").exists().then_some(()));
    kill_process(Pid::from_child(&replay), Signal::INT).unwrap();
    let code = eventually("the replay ends", || replay.try_wait().unwrap()).code();
    let mut log = String::new();
    replay.stderr.take().unwrap().read_to_string(&mut log).unwrap();
    assert_eq!(code, Some(1), "{log}");
    assert!(log.contains("is not complete") && !log.contains("panicked"), "{log}");
}
