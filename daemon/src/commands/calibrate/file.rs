//! The outcome as a calibration file, and as JSON.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use glam::{DMat3, DVec3};
use lodestone_calibration::{Missing, Outcome, Refusal};
use lodestone_config::{
    AccelerometerCalibration, Calibration, Date, GyroCalibration, MagnetometerCalibration,
    TemperatureRange,
};
use serde_json::{Value, json};
use world_magnetic_model::time::OffsetDateTime;

use crate::cli::CalibrateArgs;

/// Why a calibration file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// There is one already.
    #[error("{}: exists and is not overwritten; allowed: --force, or another --out", .0.display())]
    Exists(PathBuf),
    /// The system refuses.
    #[error("{}: cannot write: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The result does not make a valid file: a mounting that is too long, or values beyond any sensor.
    #[error("cannot make a calibration file: {0}")]
    Invalid(String),
}

impl WriteError {
    /// 2 where the command line is to blame, else 1.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Exists(_) | Self::Invalid(_) => 2,
            Self::Io { .. } => 1,
        }
    }
}

/// Fails if writing would overwrite a file against the user's will.
pub(super) fn ensure_free(out: &Path, force: bool) -> Result<(), WriteError> {
    if !force && out.try_exists().unwrap_or(true) {
        return Err(WriteError::Exists(out.into()));
    }
    Ok(())
}

/// Writes the file, whole or not at all: beside it first, then in its place.
pub(super) fn write(
    out: &Path,
    args: &CalibrateArgs,
    serial: u64,
    outcome: &Outcome,
) -> Result<(), WriteError> {
    let text = text(&calibration_of(serial, args.mounting.clone(), outcome))?;
    let io = |source| WriteError::Io { path: out.into(), source };
    let mut beside = out.as_os_str().to_owned();
    beside.push(format!(".{}.new", std::process::id()));
    let beside = PathBuf::from(beside);
    let mut file = OpenOptions::new().write(true).create_new(true).open(&beside).map_err(io)?;
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    let placed = written.map_err(io).and_then(|()| place(&beside, out, args.force));
    if args.force && placed.is_ok() {
        return Ok(());
    }
    // A hard link was made, or nothing: the name beside it goes in either case.
    let _ = std::fs::remove_file(&beside);
    placed
}

/// Gives a written file its name; a link fails if the name was taken meanwhile.
fn place(beside: &Path, out: &Path, force: bool) -> Result<(), WriteError> {
    let placed = if force { std::fs::rename(beside, out) } else { std::fs::hard_link(beside, out) };
    placed.map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => WriteError::Exists(out.into()),
        _ => WriteError::Io { path: out.into(), source },
    })
}

/// The file's text, read back by the rules that hold for every calibration file.
fn text(calibration: &Calibration) -> Result<String, WriteError> {
    let text = calibration.to_toml().map_err(|e| WriteError::Invalid(e.to_string()))?;
    Calibration::from_toml("the result", &text).map_err(|errors| {
        let all: Vec<_> = errors.iter().map(ToString::to_string).collect();
        WriteError::Invalid(all.join("; "))
    })?;
    Ok(text)
}

/// What was found out, as a file has it.
pub(crate) fn calibration_of(
    serial: u64,
    mounting: Option<String>,
    outcome: &Outcome,
) -> Calibration {
    Calibration {
        serial,
        date: today(),
        mounting,
        temperature: outcome
            .temperature
            .map(|t| TemperatureRange { min_c: t.min_c, max_c: t.max_c }),
        magnetometer: Some(magnetometer(outcome)),
        gyro: Some(GyroCalibration {
            bias_rad_s: outcome.gyro.bias_rad_s.into(),
            bias_sigma_rad_s: Some(outcome.gyro.bias_sigma_rad_s.into()),
            bias_slope_rad_s_k: outcome.gyro.bias_slope_rad_s_k.map(DVec3::into),
            reference_temperature_c: reference_c(outcome),
        }),
        accelerometer: outcome.accelerometer.map(|a| AccelerometerCalibration {
            bias_m_s2: a.bias_m_s2.into(),
            bias_sigma_m_s2: Some(a.bias_sigma_m_s2.into()),
        }),
    }
}

fn magnetometer(outcome: &Outcome) -> MagnetometerCalibration {
    let m = &outcome.magnetometer;
    MagnetometerCalibration {
        hard_iron_ut: m.hard_iron_ut.into(),
        hard_iron_slope_ut_k: m.hard_iron_slope_ut_k.unwrap_or_default().into(),
        reference_temperature_c: reference_c(outcome),
        soft_iron: rows(m.soft_iron),
        heading_sigma_deg: Some(m.heading_sigma_deg),
        level_heading_sigma_deg: Some(m.level_heading_sigma_deg),
        residual_ut: Some(m.residual_ut),
        field_ut: Some(m.field.strength_ut),
        field_sigma_ut: Some(m.field.strength_sigma_ut),
        dip_deg: Some(m.field.dip_deg),
        dip_sigma_deg: Some(m.field.dip_sigma_deg),
        covariance: Some(m.covariance.clone()),
    }
}

/// Where there was no temperature no slope is written, and the reference means nothing.
fn reference_c(outcome: &Outcome) -> f64 {
    outcome.temperature.map_or(25.0, |t| t.reference_c)
}

fn rows(matrix: DMat3) -> [[f64; 3]; 3] {
    matrix.transpose().to_cols_array_2d()
}

/// In UTC; a clock before 1970 gives its first day.
fn today() -> Date {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let now = i64::try_from(since.as_secs()).ok().map(OffsetDateTime::from_unix_timestamp);
    let now = now.and_then(Result::ok).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    let (year, month) = (now.year().clamp(0, 9999) as u16, u8::from(now.month()));
    Date { year, month, day: now.day() }
}

/// Numbers for programs; what is unknown is `null`.
pub(super) fn json(serial: u64, attempt: &Result<Outcome, Refusal>) -> Value {
    match attempt {
        Ok(outcome) => accepted(serial, outcome),
        Err(refusal) => json!({
            "serial": serial,
            "accepted": false,
            "missing": refusal.missing.iter().map(Missing::to_string).collect::<Vec<_>>(),
            "heading_sigma_deg": refusal.heading_sigma_deg,
            "coverage": coverage(&refusal.coverage),
        }),
    }
}

fn accepted(serial: u64, outcome: &Outcome) -> Value {
    let m = &outcome.magnetometer;
    json!({
        "serial": serial,
        "accepted": true,
        "heading_sigma_deg": m.heading_sigma_deg,
        "level_heading_sigma_deg": m.level_heading_sigma_deg,
        "residual_ut": m.residual_ut,
        "field_ut": m.field.strength_ut,
        "dip_deg": m.field.dip_deg,
        "hard_iron_ut": m.hard_iron_ut.to_array(),
        "hard_iron_slope_ut_k": m.hard_iron_slope_ut_k.map(|v| v.to_array()),
        "soft_iron": rows(m.soft_iron),
        "gyro_bias_rad_s": outcome.gyro.bias_rad_s.to_array(),
        "gyro_bias_slope_rad_s_k": outcome.gyro.bias_slope_rad_s_k.map(|v| v.to_array()),
        "accel_bias_m_s2": outcome.accelerometer.map(|a| a.bias_m_s2.to_array()),
        "coverage": coverage(&outcome.coverage),
    })
}

fn coverage(c: &lodestone_calibration::Coverage) -> Value {
    json!({
        "duration_s": c.duration_s,
        "circle_deg": c.circle_deg,
        "turns": c.turns,
        "tilt_deg": c.tilt_deg,
        "rest_s": c.rest_s,
        "mag_readings": c.mag_readings,
    })
}
