//! `lodestone merge` as a user runs it.

mod support;

use std::f64::consts::FRAC_PI_2;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use support::TestDomain;
use support::scanner::{Scanner, Setup, scan_as_ordered};

#[test]
#[ignore = "the source's side of the other tests, which start it themselves"]
fn scanner_process() {
    scan_as_ordered();
}

fn merge(domain: &TestDomain, directory: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_lodestone"))
        .args(["--prefix", &domain.prefix, "--root", &domain.root, "merge"])
        .args(arguments)
        .current_dir(directory)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts")
}

fn done(child: Child) -> Output {
    child.wait_with_output().expect("ends")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn two_cameras_become_two_files_and_a_report() {
    let domain = TestDomain::named("merge-two");
    let directory = tempfile::tempdir().unwrap();
    let _left = Scanner::start(&domain, "left", Setup::at([-2.0, 0.5], 1.2));
    let _right = Scanner::start(&domain, "right", Setup::at([1.5, -1.0], 1.9));
    let output = done(merge(
        &domain,
        directory.path(),
        &[
            "--duration",
            "3",
            "--min-clouds",
            "1",
            "--pcd",
            "m.pcd",
            "--json",
            "--poses",
            "left=left",
        ],
    ));
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains(" of 3 s; left "), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    for (index, name) in ["left", "right"].iter().enumerate() {
        let camera = &report["cameras"][index];
        assert_eq!(camera["camera"], *name);
        assert!(camera["clouds"].as_u64().unwrap() > 0, "{camera}");
        assert!(camera["late_p50_s"].is_f64() && camera["behind"].is_boolean());
    }
    // Then both files hold the wall, 2 m by 1 m, 5 m north
    for (index, name) in ["merged.ply", "m.pcd"].iter().enumerate() {
        let file = &report["files"][index];
        assert_eq!(file["path"], *name);
        let near = |value: &Value, to: f64| (value.as_f64().unwrap() - to).abs() < 0.03;
        assert!(near(&file["from_m"][0], -1.0) && near(&file["to_m"][0], 1.0), "{file}");
        assert!(near(&file["from_m"][1], 5.0) && near(&file["to_m"][2], 0.5), "{file}");
        let points = file["points"].as_u64().unwrap();
        let head = text(&fs::read(directory.path().join(name)).unwrap()[..400]);
        let told = [format!("element vertex {points}\n"), format!("WIDTH {points}\n")];
        assert!(head.contains(&told[index]), "{head}");
    }
}

#[test]
fn ctrl_c_ends_it_and_the_file_is_written() {
    let domain = TestDomain::named("merge-stop");
    let directory = tempfile::tempdir().unwrap();
    let _scanner = Scanner::start(&domain, "front", Setup::at([0.0, 0.0], FRAC_PI_2));
    let child =
        merge(&domain, directory.path(), &["front", "--min-clouds", "1", "--out", "stopped.ply"]);
    std::thread::sleep(Duration::from_secs(2));
    let id = Pid::from_raw(child.id().cast_signed()).unwrap();
    kill_process(id, Signal::INT).unwrap();
    let output = done(child);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("stopped.ply: "), "{}", text(&output.stdout));
    let names: Vec<_> = fs::read_dir(directory.path()).unwrap().flatten().collect();
    assert_eq!(names.len(), 1, "no half file beside it: {names:?}");
}

#[test]
fn what_cannot_be_merged_is_said_and_no_file_is_left() {
    let domain = TestDomain::named("merge-none");
    let directory = tempfile::tempdir().unwrap();
    let fails = |arguments: &[&str], code: i32, what: &str| {
        let output = done(merge(&domain, directory.path(), arguments));
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.contains(what), "{said}");
    };
    fails(&[], 1, "no daemon in domain");
    let setup = Setup { poses: false, ..Setup::at([0.0, 0.0], FRAC_PI_2) };
    let _scanner = Scanner::start(&domain, "poseless", setup);
    fails(&["rear"], 1, "no clouds of camera \"rear\"; there are those of: poseless");
    fails(&["../rear"], 2, "cannot name a camera");
    fails(&["--voxel-m", "0"], 2, "voxels of 0 m; allowed");
    fails(&["--poses", "rear=front"], 2, "--poses");
    fails(&["--poses", "rear"], 2, "front=front_gyro");
    fails(&["--duration", "1"], 1, "clouds without pose: not connected");
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}
