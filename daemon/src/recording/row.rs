//! One row.

use glam::DVec3;
use lodestone_fusion::{Accel, Body, Gyro, Mag, SensorTime};

use super::decimal;
use super::error::{Excerpt, RowFault};
use super::header::{
    ACCEL, COUNT, Columns, FIX, FIX_AGE, FIX_ROTATION, FIX_ROTATION_SIGMA, FIX_SIGMA, GYRO, MAG,
    NAMES, SPEED, SPEED_AGE, SPEED_SIGMA, TEMPERATURE, TIME, UNREAD,
};
use crate::reading::{RecordedAiding, RecordedFix, RecordedSpeed};

/// One row of a recording, in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Column `t`, exact to the nanosecond.
    pub time: SensorTime,
    /// Angular rate; may hold values that are not finite.
    pub gyro: Gyro<Body>,
    /// Specific force; may hold values that are not finite.
    pub accel: Accel<Body>,
    /// Magnetic field where the row has a reading; may be infinite.
    pub mag: Option<Mag<Body>>,
    /// Temperature, °C, where the row has one.
    pub temperature_c: Option<f32>,
    /// What others measured, where the row has it; may be infinite.
    pub aiding: RecordedAiding,
}

/// Reads one row; `line` is not empty and has no line end.
pub(super) fn parse(line: &[u8], columns: &Columns) -> Result<Row, RowFault> {
    let mut values = [f64::NAN; COUNT];
    let mut time = None;
    let mut fields = line.split(|&byte| byte == b',');
    for &role in columns.roles() {
        let field = fields.next().ok_or_else(|| wrong_count(line, columns))?;
        match usize::from(role) {
            TIME => time = Some(parse_time(field)?),
            role if role < COUNT => values[role] = parse_value(field, role)?,
            _ => debug_assert_eq!(role, UNREAD),
        }
    }
    if let Some(time) = time
        && fields.next().is_none()
    {
        return row(time, &values);
    }
    Err(wrong_count(line, columns))
}

fn row(time: SensorTime, values: &[f64; COUNT]) -> Result<Row, RowFault> {
    let vector = |first: usize| DVec3::from_slice(&values[first..first + 3]);
    let absent = values[MAG..MAG + 3].iter().filter(|value| value.is_nan()).count();
    let mag = match absent {
        0 => Some(Mag::new(vector(MAG))),
        3 => None,
        _ => return Err(RowFault::PartialMagnetometer),
    };
    Ok(Row {
        time,
        gyro: Gyro::new(vector(GYRO)),
        accel: Accel::new(vector(ACCEL)),
        mag,
        temperature_c: given(values, TEMPERATURE),
        aiding: RecordedAiding { speed: speed(values), fix: fix(values)? },
    })
}

/// A value of little precision, where the row has it.
fn given(values: &[f64; COUNT], at: usize) -> Option<f32> {
    (!values[at].is_nan()).then_some(values[at] as f32)
}

fn speed(values: &[f64; COUNT]) -> Option<RecordedSpeed> {
    (!values[SPEED].is_nan()).then(|| RecordedSpeed {
        speed_m_s: values[SPEED],
        sigma_m_s: given(values, SPEED_SIGMA),
        age_s: given(values, SPEED_AGE).unwrap_or(0.0),
    })
}

fn fix(values: &[f64; COUNT]) -> Result<Option<RecordedFix>, RowFault> {
    let absent = |from: usize, to: usize| values[from..to].iter().filter(|x| x.is_nan()).count();
    match absent(FIX, FIX_AGE) {
        4 => return Ok(None),
        0 => {}
        _ => return Err(RowFault::PartialFix),
    }
    let part = |k: usize| values[k] as f32;
    let orientation = match absent(FIX_ROTATION, COUNT) {
        0 => {
            let [w, x, y, z] = core::array::from_fn(|k| part(FIX_ROTATION + k));
            Some(([x, y, z, w], part(FIX_ROTATION_SIGMA)))
        }
        5 => None,
        _ => return Err(RowFault::PartialFix),
    };
    Ok(Some(RecordedFix {
        position_m: [values[FIX], values[FIX + 1], values[FIX + 2]],
        sigma_m: part(FIX_SIGMA),
        age_s: given(values, FIX_AGE).unwrap_or(0.0),
        orientation,
    }))
}

#[cold]
fn wrong_count(line: &[u8], columns: &Columns) -> RowFault {
    let found = line.split(|&byte| byte == b',').count();
    RowFault::FieldCount { found, expected: columns.roles().len() }
}

fn parse_time(field: &[u8]) -> Result<SensorTime, RowFault> {
    let field = field.trim_ascii();
    decimal::seconds_to_nanos(field)
        .map(SensorTime::from_nanos)
        .ok_or_else(|| RowFault::BadTime { text: Excerpt::new(field) })
}

fn parse_value(field: &[u8], role: usize) -> Result<f64, RowFault> {
    let field = field.trim_ascii();
    if field.is_empty() && role >= MAG {
        return Ok(f64::NAN);
    }
    std::str::from_utf8(field)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| RowFault::NotANumber { column: NAMES[role], text: Excerpt::new(field) })
}
