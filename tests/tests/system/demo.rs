//! `lodestoned demo`: several processes that end together and leave files, and nothing else.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use lodestone_tests::system::{eventually, lodestoned, said};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

fn demo(out: &Path, duration_s: &str) -> Command {
    let mut command = lodestoned();
    command.args(["demo", "--json", "--duration", duration_s, "--out"]).arg(out);
    command
}

/// Command lines of living processes that name a directory.
fn processes_of(out: &Path) -> Vec<String> {
    let processes = fs::read_dir("/proc").unwrap().flatten();
    let lines = processes.filter_map(|process| fs::read(process.path().join("cmdline")).ok());
    let lines = lines.map(|line| String::from_utf8_lossy(&line).replace('\0', " "));
    lines.filter(|line| line.contains(&*out.to_string_lossy())).collect()
}

/// What a demo's process has in shared memory.
fn memory_of(pid: u32) -> Vec<String> {
    let files = fs::read_dir("/dev/shm").unwrap().flatten();
    let names = files.map(|file| file.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(&format!("lodestone_demo{pid}_"))).collect()
}

/// Vertices that a PLY file promises, and whether its length keeps the promise.
fn vertices(path: &Path) -> u64 {
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let header_length = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let header = String::from_utf8_lossy(&bytes[..header_length]).into_owned();
    let count = header.lines().find_map(|line| line.strip_prefix("element vertex ")).unwrap();
    let count: u64 = count.parse().unwrap();
    let size = |line: &str| match line.split(' ').nth(1) {
        Some("float" | "uint" | "int") => 4,
        Some("ushort") => 2,
        Some("uchar") => 1,
        other => panic!("{other:?}"),
    };
    let row: u64 = header.lines().filter(|line| line.starts_with("property ")).map(size).sum();
    assert_eq!(bytes.len() as u64, header_length as u64 + count * row, "{header}");
    count
}

#[test]
fn it_leaves_clouds_a_picture_and_numbers_that_agree_and_no_process() {
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().join("demo");
    // When it has run for some seconds
    let child = demo(&out, "3").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let pid = child.id();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", said(&output));

    // Then its output is what its file says
    let text = fs::read_to_string(out.join("demo.json")).unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout), text);
    let outcome: Value = serde_json::from_str(&text).unwrap();

    // And each cloud has the voxels that were counted, and a distance from the truth
    let rows = outcome["clouds"].as_array().unwrap();
    assert_eq!(rows.len(), 6);
    let row = |name: &str| rows.iter().find(|row| row["variant"] == name).unwrap();
    let rmse = |name: &str| row(name)["score"]["in_world"]["rmse_m"].as_f64().unwrap();
    for (name, file) in [
        ("front_alone", "front.ply"),
        ("rear_alone", "rear.ply"),
        ("lodestone", "merged-lodestone.ply"),
        ("refined", "merged.ply"),
        ("perfect", "merged-perfect-poses.ply"),
    ] {
        assert_eq!(row(name)["voxels"], vertices(&out.join(file)), "{name}");
        assert!(rmse(name) > 0.0, "{name}");
    }
    let points = |name: &str| row(name)["points"].as_u64().unwrap();
    assert_eq!(points("front_alone") + points("rear_alone"), points("lodestone"));

    // And without its magnetometer no camera knows how it is turned to the other
    assert!(rmse("without_magnetometer") > 3.0 * rmse("lodestone"), "{text}");
    let ratio = outcome["targets"][0]["measured"].as_f64().unwrap();
    assert!((ratio - rmse("refined") / rmse("perfect")).abs() < 1e-9);

    let picture = fs::read(out.join("clouds.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG\r\n\x1a\n") && picture.len() > 50_000);
    assert_eq!(processes_of(&out), Vec::<String>::new());
    assert_eq!(memory_of(pid), Vec::<String>::new());
}

/// A demo in the middle of its work.
fn in_the_middle(out: &Path) -> Child {
    let mut child = demo(out, "600").stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.any(|line| line.unwrap().starts_with("merging")), "it ended before it merged");
    assert!(processes_of(out).len() > 1);
    assert!(!memory_of(child.id()).is_empty());
    child
}

#[test]
fn interrupted_in_the_middle_it_ends_everything() {
    for signal in [Signal::INT, Signal::TERM] {
        let directory = tempfile::tempdir().unwrap();
        let mut child = in_the_middle(directory.path());
        kill_process(Pid::from_child(&child), signal).unwrap();
        let status = eventually("the demo ends", || child.try_wait().unwrap());
        assert_eq!(status.code(), Some(1));
        assert_eq!(processes_of(directory.path()), Vec::<String>::new());
        assert_eq!(memory_of(child.id()), Vec::<String>::new());
    }
}

#[test]
fn killed_it_takes_its_processes_with_it_and_the_next_one_clears_up() {
    let directory = tempfile::tempdir().unwrap();
    let mut child = in_the_middle(directory.path());
    child.kill().unwrap();
    child.wait().unwrap();
    eventually("its processes end", || processes_of(directory.path()).is_empty().then_some(()));

    let mut next = in_the_middle(directory.path());
    assert_eq!(memory_of(child.id()), Vec::<String>::new());
    kill_process(Pid::from_child(&next), Signal::INT).unwrap();
    eventually("the next one ends", || next.try_wait().unwrap());
}

#[test]
fn a_directory_that_cannot_be_made_is_said() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("file");
    fs::write(&file, "").unwrap();
    let output = demo(&file.join("demo"), "3").output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("cannot be written"), "{}", said(&output));

    let output = demo(directory.path(), "3").args(["--config", "a.toml"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}
