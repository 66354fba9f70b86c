#![allow(clippy::float_cmp, reason = "values that pass through unchanged")]

use std::fmt::Write as _;
use std::path::PathBuf;

use glam::DVec3;
use lodestone_fusion::{Accel, Gyro, Mag, SensorTime};
use proptest::prelude::*;
use tempfile::TempDir;

use super::*;
use crate::reading::{RecordedAiding, RecordedFix, RecordedSpeed};

const HEADER: &str = "t,gx,gy,gz,ax,ay,az,mx,my,mz,temp";

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, content: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path
    }
}

fn open_bytes(content: &[u8]) -> Result<Recording, RecordingError> {
    let folder = Folder::new();
    Recording::open(&folder.file("walk.csv", content))
}

fn all(mut recording: Recording) -> Vec<Result<Row, RowError>> {
    std::iter::from_fn(|| recording.next_row()).collect()
}

fn rows_of(content: &str) -> Vec<Row> {
    all(open_bytes(content.as_bytes()).unwrap()).into_iter().map(Result::unwrap).collect()
}

fn compressed(content: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(content, ruzstd::encoding::CompressionLevel::Fastest)
}

/// A recording of `rows` rows, 2 ms apart, whose values tell their row.
fn numbered(rows: u32) -> String {
    let mut text = format!("{HEADER}\n");
    for row in 0..rows {
        let t = f64::from(row) * 0.002;
        writeln!(text, "{t:.6},{row},0,0,0,0,9.81,,,,").unwrap();
    }
    text
}

fn gyro_x(rows: &[Result<Row, RowError>]) -> Vec<f64> {
    rows.iter().flatten().map(|row| row.gyro.vector.x).collect()
}

#[test]
fn columns_are_found_by_name_in_any_order() {
    let text = "qw,az,ay,ax,foo,gz,gy,gx,t,mz,my,mx,\"temp\"\r\n\
                1,6,5,4,?,3,2,1,0.5,9,8,7,21.5\r\n\
                1,6,5,4,?,3,2,1,0.502,,NaN,nan,\r\n";
    let recording = open_bytes(text.as_bytes()).unwrap();
    assert_eq!(recording.unknown_columns(), ["foo"]);
    assert!(recording.has_magnetometer());
    assert!((recording.nominal_rate_hz() - 500.0).abs() < 1e-9);
    let rows: Vec<_> = all(recording).into_iter().map(Result::unwrap).collect();
    assert_eq!(rows[0].time.as_nanos(), 500_000_000);
    assert_eq!(rows[0].gyro.vector, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(rows[0].accel.vector, DVec3::new(4.0, 5.0, 6.0));
    assert_eq!(rows[0].mag.unwrap().vector, DVec3::new(7.0, 8.0, 9.0));
    assert_eq!(rows[0].temperature_c, Some(21.5));
    assert_eq!((rows[1].mag, rows[1].temperature_c), (None, None));
}

#[test]
fn byte_order_mark_blank_lines_and_missing_last_line_end_are_tolerated() {
    let rows = rows_of("\u{FEFF}t,gx,gy,gz,ax,ay,az\n\n0,1,0,0,0,0,0\n\r\n0.1, 2 ,0,0,0,0,0");
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1].gyro.vector.x, 2.0);
}

#[test]
fn values_that_are_not_finite_are_handed_on() {
    let rows =
        rows_of("t,gx,gy,gz,ax,ay,az,mx,my,mz\n0,nan,inf,0,-inf,0,0,inf,0,0\n1,0,0,0,0,0,0,,,\n");
    assert!(rows[0].gyro.vector.x.is_nan());
    assert_eq!(rows[0].gyro.vector.y, f64::INFINITY);
    assert_eq!(rows[0].accel.vector.x, f64::NEG_INFINITY);
    assert_eq!(rows[0].mag.unwrap().vector.x, f64::INFINITY);
}

#[test]
fn given_bad_rows_then_each_is_named_and_the_others_are_read() {
    let long = "9".repeat(MAX_LINE_BYTES + 1);
    let mut text = format!(
        "{HEADER}\n0,0,0,0,0,0,0,,,,\n0.1,0,0,0,0,0,0\n0.2,0,0,0,0,0,0,,,,,\n0.3,x,0,0,0,0,0,,,,\n\
         0.4,,0,0,0,0,0,,,,\n0.5,0,0,0,0,0,0,1,2,,\n,0,0,0,0,0,0,,,,\nnan,0,0,0,0,0,0,,,,\n{long}\n"
    )
    .into_bytes();
    text.extend(b"0.6,\xFF\0,0,0,0,0,0,,,,\n0.7,7,0,0,0,0,0,,,,\n");
    let rows = all(open_bytes(&text).unwrap());
    assert_eq!(gyro_x(&rows), [0.0, 7.0]);
    let errors: Vec<String> = rows
        .iter()
        .filter_map(|row| row.as_ref().err())
        .map(|error| format!("{}: {}", error.line, error.fault))
        .collect();
    assert_eq!(
        errors,
        [
            "3: 7 fields; the header names 11",
            "4: 12 fields; the header names 11",
            "5: column gx: 'x' is not a decimal number",
            "6: column gx: '' is not a decimal number",
            "7: columns mx my mz: all three must hold a number, or none",
            "8: column t: '' is not a time; a decimal number of seconds within ±9e9 is allowed",
            "9: column t: 'nan' is not a time; a decimal number of seconds within ±9e9 is allowed",
            "10: longer than 65536 bytes",
            "11: column gx: '\\xff\\x00' is not a decimal number",
        ]
    );
}

#[test]
fn a_header_that_will_not_do_says_what_is_missing() {
    let message = |text: &[u8]| {
        let error = open_bytes(text).unwrap_err().to_string();
        error.split_once("walk.csv: ").unwrap().1.to_owned()
    };
    assert!(message(b"").starts_with("empty;"));
    assert!(message(b"t,gx,gy,az,my\n").starts_with("line 1: no column gz ax ay mx mz;"));
    assert!(message(b"t,gx,gx\n").starts_with("line 1: column gx is named twice"));
    assert!(message(b"\xFF\xFE\0").starts_with("line 1: not a CSV header"));
    assert!(message(&vec![b'a'; MAX_LINE_BYTES + 1]).starts_with("line 1: not a CSV header"));
    let header_only = message(b"t,gx,gy,gz,ax,ay,az\n");
    assert!(header_only.starts_with("0 readable row(s)"), "{header_only}");
    let bad = message(b"t,gx,gy,gz,ax,ay,az\n1,2\n");
    assert!(bad.ends_with("(line 2: 2 fields; the header names 7)"), "{bad}");
    let still = message(b"t,gx,gy,gz,ax,ay,az\n1,0,0,0,0,0,0\n1,0,0,0,0,0,0\n0.5,0,0,0,0,0,0\n");
    assert!(still.starts_with("3 readable row(s)"), "{still}");
}

#[test]
fn a_file_that_is_not_there_or_a_folder_is_an_error() {
    let folder = Folder::new();
    for path in [folder.0.path().join("none.csv"), folder.0.path().to_path_buf()] {
        assert!(matches!(Recording::open(&path), Err(RecordingError::Unreadable { .. })));
    }
}

#[test]
fn the_rate_is_the_median_and_survives_gaps_and_duplicates() {
    let mut text = format!("{HEADER}\n");
    for row in 0..300 {
        let gap = if row > 20 { 5.0 } else { 0.0 };
        let t = f64::from(row) * 0.0025 + gap;
        let line = format!("{t:.6},0,0,0,0,0,0,,,,\n");
        text.push_str(&line.repeat(if row % 10 == 0 { 2 } else { 1 }));
    }
    let recording = open_bytes(text.as_bytes()).unwrap();
    assert!((recording.nominal_rate_hz() - 400.0).abs() < 1e-6);
    assert_eq!(all(recording).len(), 330);
}

#[test]
fn compressed_recordings_are_told_by_content() {
    let folder = Folder::new();
    let text = numbered(1000);
    for name in ["walk.csv.zst", "walk.csv"] {
        let recording = Recording::open(&folder.file(name, &compressed(text.as_bytes()))).unwrap();
        let rows = all(recording);
        assert_eq!(gyro_x(&rows), (0..1000).map(f64::from).collect::<Vec<_>>());
    }
    let plain = folder.file("named.csv.zst", text.as_bytes());
    assert!(matches!(Recording::open(&plain), Err(RecordingError::NotZstandard { .. })));
}

#[test]
fn several_frames_and_skippable_ones_are_read_through() {
    let text = numbered(600);
    let (first, second) = text.split_at(5000);
    let note = [&0x184D_2A53_u32.to_le_bytes()[..], &4_u32.to_le_bytes(), b"note"].concat();
    let (first, second) = (compressed(first.as_bytes()), compressed(second.as_bytes()));
    let file = [&note[..], &first, &note, &second].concat();
    let rows = all(open_bytes(&file).unwrap());
    assert_eq!(gyro_x(&rows), (0..600).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn given_a_truncated_compressed_recording_then_its_rows_come_and_one_fatal_error_ends_it() {
    let whole = compressed(numbered(20_000).as_bytes());
    let mut rows = all(open_bytes(&whole[..whole.len() / 2]).unwrap());
    let last = rows.pop().unwrap().unwrap_err();
    assert!(last.is_fatal(), "{last}");
    assert!(last.to_string().contains("damaged or cut short"), "{last}");
    assert!(rows.len() > 1000);
    assert!(rows.iter().all(Result::is_ok));
}

#[test]
fn given_trailing_garbage_behind_the_compressed_data_then_it_is_reported() {
    let file = [compressed(numbered(500).as_bytes()), b"garbage".to_vec()].concat();
    let mut rows = all(open_bytes(&file).unwrap());
    assert!(rows.pop().unwrap().unwrap_err().is_fatal());
    assert_eq!(rows.len(), 500);
}

#[test]
fn given_a_wrong_checksum_then_it_is_reported() {
    let mut file = compressed(numbered(500).as_bytes());
    *file.last_mut().unwrap() ^= 1;
    let mut rows = all(open_bytes(&file).unwrap());
    let last = rows.pop().unwrap().unwrap_err();
    assert!(last.to_string().contains("checksum"), "{last}");
}

fn drain(content: &[u8]) {
    if let Ok(recording) = open_bytes(content) {
        for row in all(recording) {
            let _ = row.map_err(|error| error.to_string());
        }
    }
}

fn any_row() -> impl Strategy<Value = Row> {
    let time = -9_000_000_000_000_000_000_i64..9_000_000_000_000_000_000;
    let vector = || prop::array::uniform3(prop::num::f64::NORMAL).prop_map(DVec3::from_array);
    let mag = prop::option::of(vector());
    let temperature = prop::option::of(-50.0_f32..100.0);
    (time, vector(), vector(), mag, temperature).prop_map(|(time, gyro, accel, mag, temp)| Row {
        time: SensorTime::from_nanos(time),
        gyro: Gyro::new(gyro),
        accel: Accel::new(accel),
        mag: mag.map(Mag::new),
        temperature_c: temp,
        aiding: RecordedAiding::NONE,
    })
}

fn write_row(text: &mut String, row: &Row) {
    let nanos = row.time.as_nanos();
    let sign = if nanos < 0 { "-" } else { "" };
    let (seconds, rest) = (nanos.abs() / 1_000_000_000, nanos.abs() % 1_000_000_000);
    let (g, a) = (row.gyro.vector, row.accel.vector);
    write!(text, "{sign}{seconds}.{rest:09},{},{},{},{},{},{}", g.x, g.y, g.z, a.x, a.y, a.z)
        .unwrap();
    match row.mag {
        Some(mag) => write!(text, ",{:e},{},{}", mag.vector.x, mag.vector.y, mag.vector.z),
        None => write!(text, ",,nan,"),
    }
    .unwrap();
    let temp = row.temperature_c.map_or(String::new(), |value| value.to_string());
    writeln!(text, ",{temp}").unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn arbitrary_bytes_never_panic(content in prop::collection::vec(any::<u8>(), 0..2000)) {
        drain(&content);
        drain(&[&b"t,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,0\n1,0,0,0,0,0,0\n"[..], &content].concat());
        drain(&[&0xFD2F_B528_u32.to_le_bytes()[..], &content].concat());
    }

    #[test]
    fn arbitrary_csv_text_never_panics(content in "[-+0-9.,eEnaif \r\n]{0,400}") {
        drain(format!("t,gx,gy,gz,ax,ay,az\n{content}").as_bytes());
    }

    #[test]
    fn flipped_bits_in_compressed_data_never_panic(at in any::<prop::sample::Index>(), bit in 0_u32..8) {
        let mut file = compressed(numbered(300).as_bytes());
        let at = at.index(file.len());
        file[at] ^= 1_u8 << bit;
        drain(&file);
    }

    #[test]
    fn what_was_written_is_read(mut rows in prop::collection::vec(any_row(), 2..20)) {
        rows.sort_by_key(|row| row.time);
        rows.dedup_by_key(|row| row.time);
        prop_assume!(rows.len() >= 2);
        let mut text = format!("{HEADER}\n");
        for row in &rows {
            write_row(&mut text, row);
        }
        prop_assert_eq!(rows_of(&text), rows);
    }
}

const WITH_AIDS: &str = "t,gx,gy,gz,ax,ay,az,speed,speed_sigma,speed_age,fix_x,fix_y,fix_z,fix_sigma,\
    fix_qw,fix_qx,fix_qy,fix_qz,fix_rot_sigma,fix_age";

#[test]
fn what_others_measured_is_read_where_it_is_given() {
    let rows = rows_of(&format!(
        "{WITH_AIDS}\n\
         0,0,0,0,0,0,9.81,,,,,,,,,,,,,\n\
         0.01,0,0,0,0,0,9.81,-1.5,,,,,,,,,,,,\n\
         0.02,0,0,0,0,0,9.81,2.5,0.125,0.25,1,2,3,0.5,,,,,,0.5\n\
         0.03,0,0,0,0,0,9.81,,,,1,2,3,0.5,1,0,0,0.25,0.0625,\n"
    ));
    assert_eq!(rows[0].aiding, RecordedAiding::NONE);
    let speed = RecordedSpeed { speed_m_s: -1.5, sigma_m_s: None, age_s: 0.0 };
    assert_eq!(rows[1].aiding, RecordedAiding { speed: Some(speed), fix: None });
    let speed = RecordedSpeed { speed_m_s: 2.5, sigma_m_s: Some(0.125), age_s: 0.25 };
    let fix =
        RecordedFix { position_m: [1.0, 2.0, 3.0], sigma_m: 0.5, age_s: 0.5, orientation: None };
    assert_eq!(rows[2].aiding, RecordedAiding { speed: Some(speed), fix: Some(fix) });
    let turned = Some(([0.0, 0.0, 0.25, 1.0], 0.0625));
    let fix = RecordedFix { orientation: turned, age_s: 0.0, ..fix };
    assert_eq!(rows[3].aiding, RecordedAiding { speed: None, fix: Some(fix) });
}

#[test]
fn half_a_fix_is_no_fix() {
    for fields in ["1,2,,0.5,,,,,,", "1,2,3,,,,,,,", "1,2,3,0.5,1,0,0,,0.1,", ",,,,1,0,0,0,,"] {
        let text = format!(
            "{WITH_AIDS}\n0,0,0,0,0,0,9.81,,,,,,,,,,,,,\n0.01,0,0,0,0,0,9.81,,,,,,,,,,,,,\n\
             0.02,0,0,0,0,0,9.81,,,,{fields}\n"
        );
        let rows = all(open_bytes(text.as_bytes()).unwrap());
        let whole = rows[2].as_ref().is_ok_and(|row| row.aiding == RecordedAiding::NONE);
        let refused = matches!(&rows[2], Err(error) if matches!(error.fault, RowFault::PartialFix));
        assert!(refused || whole, "{fields}: {:?}", rows[2]);
    }
}

#[test]
fn a_column_about_a_speed_or_fix_needs_the_speed_or_fix() {
    let missing = |columns: &str| {
        let text = format!("t,gx,gy,gz,ax,ay,az,{columns}\n");
        match open_bytes(text.as_bytes()) {
            Err(RecordingError::MissingColumns { missing, .. }) => missing,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(missing("speed_sigma"), "speed");
    assert_eq!(missing("fix_x,fix_y"), "fix_z fix_sigma");
    assert_eq!(missing("fix_x,fix_y,fix_z,fix_sigma,fix_qw"), "fix_qx fix_qy fix_qz fix_rot_sigma");
    assert_eq!(missing("fix_age"), "fix_x fix_y fix_z fix_sigma");
}
