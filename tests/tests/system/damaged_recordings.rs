//! `lodestoned replay` on recordings that are damaged, or none at all.

use std::fs;
use std::path::Path;

use glam::DVec3;
use lodestone_config::model::TrajectoryKind;
use lodestone_tests::system::{Recorded, Replayed, compressed, lodestoned, replay, said};

fn standing() -> Recorded {
    Recorded::of(TrajectoryKind::Standing, 9, 5.0)
}

fn replay_text(name: &str, content: &[u8]) -> Replayed {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(name);
    fs::write(&path, content).unwrap();
    replay(&path, &directory.path().join("poses"), &[])
}

/// Replays rows and expects a good end with one pose for each.
fn good(recorded: &Recorded) -> Replayed {
    let replayed = replay_text("made.csv", recorded.csv().as_bytes());
    assert_eq!(replayed.code, Some(0), "{}", replayed.log);
    assert_eq!(replayed.unbroken_poses().len(), recorded.rows.len());
    replayed
}

/// Expects a refusal with exit code 1 that names the file and says this.
fn refused(name: &str, content: &[u8], because: &str) {
    let replayed = replay_text(name, content);
    assert_eq!(replayed.code, Some(1), "{name}: {}", replayed.log);
    assert!(replayed.log.contains(name), "{}", replayed.log);
    assert!(replayed.log.contains(because), "expected {because:?} in {}", replayed.log);
}

#[test]
fn values_that_are_no_measurement_are_counted_and_never_come_out_as_poses() {
    let mut recorded = standing();
    recorded.rows[1000].gyro.x = f64::NAN;
    recorded.rows[1010].accel = DVec3::splat(f64::INFINITY);
    recorded.rows[1020].gyro.z = f64::NEG_INFINITY;
    recorded.rows[1030].accel.y = 1e300;
    recorded.rows[1040].mag = Some(DVec3::splat(f64::INFINITY));
    assert_eq!(good(&recorded).count("invalid"), 5);
}

#[test]
fn rows_that_repeat_or_run_back_in_time_are_counted_and_change_nothing() {
    let clean = standing();
    let mut disordered = clean.clone();
    // Five rows come twice, and seven come once more, long after their time.
    let twice: Vec<_> = clean.rows[900..905].to_vec();
    for (n, row) in twice.iter().enumerate() {
        disordered.rows.insert(900 + 2 * n + 1, *row);
    }
    let late: Vec<_> = clean.rows[800..807].to_vec();
    disordered.rows.splice(1500..1500, late);

    let replayed = good(&disordered);

    assert_eq!(replayed.count("duplicates"), 5);
    assert_eq!(replayed.count("out_of_order"), 7);
    assert_eq!(replayed.count("lost"), 0);
    let last = |replayed: &Replayed| replayed.poses().last().unwrap().orientation;
    assert_eq!(last(&replayed), last(&good(&clean)));
}

#[test]
fn rows_that_cannot_be_read_are_counted_and_left_out() {
    let recorded = standing();
    let text = recorded.csv();
    let mut lines: Vec<&str> = text.lines().collect();
    let long = "1".repeat(100_000);
    let broken = [
        "",
        "1,2,3",
        "x,0,0,0,0,0,0,,,",
        "9.0,0,0,zero,0,0,9.8,,,",
        "9.0,0,0,0,0,0,9.8,1,,",
        "9.0,0,0,0,0,0,9.8,1,2,3,4",
        "\u{fffd}\u{0}",
        "1e400,0,0,0,0,0,9.8,,,",
        &long,
    ];
    lines.splice(1200..1200, broken);
    let replayed = replay_text("made.csv", (lines.join("\r\n") + "\r\n").as_bytes());
    assert_eq!(replayed.code, Some(0), "{}", replayed.log);
    // A blank line is no row.
    assert_eq!(replayed.count("malformed"), broken.len() as u64 - 1);
    assert_eq!(replayed.unbroken_poses().len(), recorded.rows.len());
}

#[test]
fn what_is_no_recording_is_refused_by_name() {
    let junk: Vec<u8> =
        (0..50_000_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    refused("junk.csv", &junk, "line 1: not a CSV header");
    refused("junk.csv.zst", &junk, "does not begin as Zstandard data do");
    refused("empty.csv", b"", "empty");
    refused("empty.csv.zst", b"", "empty");
    refused("header.csv", b"t,gx,gy,gz,ax,ay,az\n", "readable row(s)");
    refused("short.csv", b"t,gx,gy,ax,ay,az\n0,0,0,0,0,0\n", "no column gz");
    refused("twice.csv", b"t,gx,gy,gz,ax,ay,az,gx\n0,0,0,0,0,0,0,0\n", "named twice");
    refused("half.csv", b"t,gx,gy,gz,ax,ay,az,mx\n0,0,0,0,0,0,0,0\n", "my mz");
    let mut magic = vec![0x28, 0xB5, 0x2F, 0xFD];
    magic.extend(&junk);
    refused("damaged.csv.zst", &magic, "damaged or cut short");
}

#[test]
fn a_recording_that_was_cut_short_gives_its_first_poses_and_an_error() {
    // Long enough for several blocks before the cut.
    let recorded = Recorded::of(TrajectoryKind::Walk, 4, 40.0);
    let packed = compressed(recorded.csv().as_bytes());
    let replayed = replay_text("cut.csv.zst", &packed[..packed.len() * 3 / 4]);
    assert_eq!(replayed.code, Some(1), "{}", replayed.log);
    assert!(replayed.log.contains("the poses up to there are in"), "{}", replayed.log);
    let whole = replay_text("whole.csv", recorded.csv().as_bytes());
    assert!(replayed.bytes.len() > 1000, "{}", replayed.log);
    assert!(whole.bytes.starts_with(&replayed.bytes), "poses before the cut differ");
}

#[test]
fn files_and_directories_that_cannot_be_used_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let (out, file) = (directory.path().join("poses"), directory.path().join("made.csv"));
    standing().write(&file);
    let missing = directory.path().join("missing.csv");
    for unreadable in [directory.path(), &missing, Path::new("/dev/null")] {
        let replayed = replay(unreadable, &out, &[]);
        assert_eq!(replayed.code, Some(1), "{}", replayed.log);
        assert!(replayed.log.contains(&unreadable.display().to_string()), "{}", replayed.log);
    }
    // Poses cannot go below a file, nor over their own recording, nor twice to one place.
    let below_file = replay(&file, &file.join("poses"), &[]);
    assert_eq!(below_file.code, Some(1), "{}", below_file.log);
    assert!(below_file.log.contains("cannot make the directory"), "{}", below_file.log);
    let onto_itself = replay(&file, directory.path(), &[]);
    assert_eq!(onto_itself.code, Some(2), "{}", onto_itself.log);
    assert_eq!(fs::read_to_string(&file).unwrap(), standing().csv(), "the recording has changed");
    let twice = lodestoned().args(["replay", "--out"]).args([&out, &file, &file]).output().unwrap();
    assert_eq!(twice.status.code(), Some(2), "{}", said(&twice));
}

#[test]
fn given_a_full_disk_then_the_replay_says_so() {
    let directory = tempfile::tempdir().unwrap();
    let (out, file) = (directory.path().join("poses"), directory.path().join("made.csv"));
    standing().write(&file);
    fs::create_dir(&out).unwrap();
    // Every write to this device fails as on a full disk.
    std::os::unix::fs::symlink("/dev/full", out.join("made.csv")).unwrap();
    let ended = lodestoned().arg("replay").arg(&file).arg("--out").arg(&out).output().unwrap();
    assert_eq!(ended.status.code(), Some(1), "{}", said(&ended));
    assert!(said(&ended).contains("cannot write poses"), "{}", said(&ended));
}
