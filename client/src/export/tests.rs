use std::fs;
use std::io::Cursor;

use pcd_rs::{DynReader, Field};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};
use tempfile::tempdir;

use super::{ExportFilter, ExportPoint, export_points, write_pcd, write_ply};
use crate::merge::samples::{placed, point};
use crate::merge::{VoxelMap, VoxelMapSettings};

fn points() -> Vec<ExportPoint> {
    let seen = |i: u8| ExportPoint {
        position_m: [f32::from(i), -0.5, 1e3],
        colour: (i != 1).then_some([i, 0, 255]),
        count: u32::from(i) + 7,
        cameras: 1 << i,
    };
    (0..3).map(seen).collect()
}

#[test]
fn a_ply_file_read_back_has_every_point_with_its_colour_and_count() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("merged.ply");
    write_ply(&path, &points()).unwrap();
    let bytes = fs::read(&path).unwrap();
    let ply = Parser::<DefaultElement>::new().read_ply(&mut Cursor::new(bytes)).unwrap();
    let vertices = &ply.payload["vertex"];
    assert_eq!(vertices.len(), 3);
    assert_eq!(vertices[2]["x"], Property::Float(2.0));
    assert_eq!(vertices[2]["z"], Property::Float(1e3));
    assert_eq!(vertices[2]["blue"], Property::UChar(255));
    assert_eq!(vertices[2]["count"], Property::UInt(9));
    assert_eq!(vertices[2]["cameras"], Property::UShort(4));
    assert_eq!(vertices[1]["red"], Property::UChar(128), "a colour that nobody gave is grey");
}

#[test]
fn a_pcd_file_read_back_has_every_point_with_its_colour_and_count() {
    let directory = tempdir().unwrap();
    let path = directory.path().join("merged.pcd");
    write_pcd(&path, &points()).unwrap();
    let reader = DynReader::open(&path).unwrap();
    let records: Vec<_> = reader.map(|record| record.unwrap().0).collect();
    assert_eq!(records.len(), 3);
    let [_, _, z, rgb, count] = &records[2][..] else { panic!("{records:?}") };
    assert_eq!((z, count), (&Field::F32(vec![1e3]), &Field::U32(vec![9])));
    assert_eq!(rgb, &Field::F32(vec![pcd_rs::rgb_to_float(2, 0, 255)]));
}

#[test]
fn clouds_without_colour_make_files_without_colour_and_none_makes_an_empty_one() {
    let directory = tempdir().unwrap();
    let plain: Vec<_> = points().into_iter().map(|p| ExportPoint { colour: None, ..p }).collect();
    for points in [&plain[..], &[]] {
        let (ply, pcd) = (directory.path().join("a.ply"), directory.path().join("a.pcd"));
        write_ply(&ply, points).unwrap();
        write_pcd(&pcd, points).unwrap();
        let head = |path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
        assert!(!head(&ply).contains("red") && !head(&pcd).contains("rgb"));
        assert!(head(&ply).contains(&format!("element vertex {}", points.len())));
        assert_eq!(DynReader::open(&pcd).unwrap().count(), points.len());
    }
}

#[test]
fn a_file_that_cannot_be_written_is_named_and_nothing_is_left_behind() {
    let directory = tempdir().unwrap();
    // Given a directory where the file should be
    let path = directory.path().join("taken");
    fs::create_dir_all(path.join("full")).unwrap();
    for error in [write_ply(&path, &points()), write_pcd(&path, &points())] {
        assert!(error.unwrap_err().to_string().contains("taken"));
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1, "no half file");
}

#[test]
fn what_was_seen_briefly_is_left_out() {
    // Given a wall seen in five clouds, and something that passed in one, of many points
    let mut map = VoxelMap::new(VoxelMapSettings { voxel_m: 0.1, max_voxels: 100 }).unwrap();
    for cloud in 0..5_i64 {
        let mut seen = vec![point([2.0, 0.0, 0.0])];
        if cloud == 2 {
            seen.extend([point([1.0, 0.0, 0.0]); 50]);
        }
        map.insert(&placed(0, 1_000_000_000 + cloud * 66_000_000, glam::DVec3::ZERO, &seen));
    }
    let kept = export_points(&map, ExportFilter::default());
    assert_eq!(kept.iter().map(|p| p.position_m[0]).collect::<Vec<_>>(), [2.0]);
    let all = export_points(&map, ExportFilter { min_points: 1, min_clouds: 1 });
    assert_eq!(all.len(), 2);
}
