use proptest::prelude::*;

use super::*;
use crate::driver::zed2::raw::REPORT_LEN;

fn level_camera() -> RawReport {
    RawReport {
        struct_id: 1,
        ticks: 25_600,
        gyro: [0, 0, 32_766],
        accel: [-4096, 0, 0],
        imu_temperature: 3_125,
        mag_valid: 2,
        mag: [-700, 16, 320],
        env_valid: 1,
        temperature: 2_050,
        pressure: 9_613_250,
        humidity: 4_500,
        image_temperature: [4_012, NO_TEMPERATURE],
        ..RawReport::default()
    }
}

#[test]
fn physical_units_follow_the_table() {
    let report = Report::from_raw(&level_camera(), Some(Firmware(0x0309))).unwrap();

    assert_eq!(report.sensor_time.as_nanos(), 1_000_000_000);
    assert!(report.imu_valid && !report.saturated);
    assert!((report.gyro.vector.z.to_degrees() - 999.938_964_843_75).abs() < 1e-9);
    assert!((report.accel.vector.x + 9.8189).abs() < 1e-12, "8 g over 32768 steps, 4096 is 1 g");
    assert_eq!(report.mag.fresh().map(|mag| mag.vector), Some(DVec3::new(-43.75, 1.0, 20.0)));
    assert_eq!(report.imu_temperature_c, Some(31.25));
    assert_eq!(report.image_temperature_c, [Some(40.12), None]);
    let Aged::Old(air) = report.environment else { panic!("{:?}", report.environment) };
    assert!((air.pressure_pa.unwrap() - 96_132.5).abs() < 1e-6);
    assert!((air.humidity_percent.unwrap() - 45.0).abs() < 1e-9);
}

#[test]
fn older_firmware_has_coarser_units_and_unknown_firmware_none() {
    let raw = RawReport { pressure: 96_132, humidity: 46_080, ..level_camera() };

    let of = |firmware| match Report::from_raw(&raw, firmware).unwrap().environment {
        Aged::Old(air) => (air.pressure_pa, air.humidity_percent),
        other => panic!("{other:?}"),
    };

    assert_eq!(of(Some(Firmware(0x0308))), (Some(96_132.0), Some(45.0)));
    assert_eq!(of(None), (None, None));
}

#[test]
fn an_odd_number_of_ticks_is_rounded_down_to_the_nanosecond() {
    let raw = RawReport { ticks: 3, ..level_camera() };
    assert_eq!(Report::from_raw(&raw, None).unwrap().sensor_time.as_nanos(), 117_187);
}

#[test]
fn a_mini_is_told_by_its_structure() {
    let raw = RawReport { struct_id: 0, ..level_camera() };
    let error = Report::from_raw(&raw, None).unwrap_err();
    assert_eq!(error, ReportError::StructId { found: 0 });
    assert!(error.to_string().contains("ZED Mini"), "{error}");
}

#[test]
fn every_end_of_every_range_is_noticed() {
    for end in [i16::MIN, -32767, 32767] {
        for axis in 0..3 {
            let (mut gyro, mut accel, mut mag) = (level_camera(), level_camera(), level_camera());
            gyro.gyro[axis] = end;
            accel.accel[axis] = end;
            mag.mag[axis] = end;
            for raw in [gyro, accel, mag] {
                assert!(Report::from_raw(&raw, None).unwrap().saturated, "{raw:?}");
            }
            let old_mag = RawReport { mag_valid: 1, ..mag };
            assert!(!Report::from_raw(&old_mag, None).unwrap().saturated);
        }
    }
}

#[test]
fn firmware_reads_as_people_write_it() {
    assert_eq!(Firmware(0x0309).to_string(), "3.9");
}

proptest! {
    #[test]
    fn any_bytes_of_any_length_are_a_report_or_an_error(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        firmware in prop::option::of(any::<u16>().prop_map(Firmware)),
    ) {
        match Report::parse(&bytes, firmware) {
            Err(ReportError::TooShort { found }) => {
                prop_assert!(found == bytes.len() && found < USED_LEN);
            }
            Err(ReportError::StructId { found }) => prop_assert!(found != STRUCT_ID),
            Err(ReportError::TimeOutOfRange { ticks }) => prop_assert!(ticks > 1 << 47),
            Ok(report) => prop_assert!(is_physical(&report)),
        }
    }

    #[test]
    fn any_64_bytes_with_the_right_structure_and_a_sane_time_are_a_report(
        mut bytes in prop::collection::vec(any::<u8>(), REPORT_LEN),
        ticks in 0_u64..1 << 47,
    ) {
        bytes[0] = STRUCT_ID;
        bytes[2..10].copy_from_slice(&ticks.to_le_bytes());

        let report = Report::parse(&bytes, Some(Firmware(0x0309)))?;

        prop_assert!(is_physical(&report));
        prop_assert_eq!(i128::from(report.sensor_time.as_nanos()), i128::from(ticks) * 78_125 / 2);
        prop_assert_eq!(report.imu_valid, bytes[1] != 1);
    }

    #[test]
    fn what_is_emitted_is_parsed_again(bytes in prop::collection::vec(any::<u8>(), REPORT_LEN)) {
        let raw = RawReport::parse(&bytes)?;
        let emitted = raw.emit();
        prop_assert_eq!(&emitted[..USED_LEN], &bytes[..USED_LEN], "no field is lost or moved");
        prop_assert_eq!(RawReport::parse(&emitted)?, raw);
    }
}

fn is_physical(report: &Report) -> bool {
    report.gyro.vector.abs().max_element() <= 1000_f64.to_radians() + 1e-9
        && report.accel.vector.abs().max_element() <= 8.0 * 9.8189 + 1e-9
        && report.mag.fresh().is_none_or(|mag| mag.vector.abs().max_element() <= 2048.0)
        && report.imu_temperature_c.is_none_or(|t| (-273.15..=327.67).contains(&t))
        && report.sensor_time.as_nanos() >= 0
}
