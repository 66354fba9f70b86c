//! What each window of a rig's gradient found, as CSV.
//!
//! | column | unit | |
//! |---|---|---|
//! | `t` | s | end of the window |
//! | `verdict` | | `open`; `partial`, used, but not all directions are held; or why not |
//! | `vx vy vz` | m/s | velocity of the filter point, east, north, up whatever axes poses are written in |
//! | `velocity_sigma_m_s` | m/s | standard deviation along the best known direction |
//! | `directions` | | directions in which the gradient tells the velocity |
//! | `gradient_ut_m` `gradient_sigma_ut_m` | µT/m | size of the gradient and of its error |
//! | `nis` | | normalised innovation squared of the readings, mean |
//! | `excluded` | | members that do not count, one bit each, first member lowest |
//! | `alone` | | members whose magnetometer alone is disturbed, likewise |
//!
//! What the gate gives no velocity for is empty.

use std::path::Path;

use lodestone_fusion::SensorTime;
use lodestone_fusion::rig::{GradientReport, GradientVerdict, MemberStatus, RigReport};

use crate::csv_file::CsvFile;
use crate::poses_csv::PosesError;

const HEADER: &str = "t,verdict,vx,vy,vz,velocity_sigma_m_s,directions,gradient_ut_m,\
     gradient_sigma_ut_m,nis,excluded,alone\n";

/// Writes windows to a file.
#[derive(Debug)]
pub struct GradientWriter {
    file: CsvFile,
}

/// A verdict in one word.
pub const fn verdict_name(verdict: GradientVerdict) -> &'static str {
    match verdict {
        GradientVerdict::Collecting => "collecting",
        GradientVerdict::Open => "open",
        GradientVerdict::Partial => "partial",
        GradientVerdict::Array => "array",
        GradientVerdict::Uniform => "uniform",
        GradientVerdict::Still => "still",
        GradientVerdict::Rough => "rough",
        GradientVerdict::Uncalibrated => "uncalibrated",
        GradientVerdict::Contradicted => "contradicted",
    }
}

impl GradientWriter {
    /// Makes the file, or empties the one that is there, and writes the header.
    ///
    /// # Errors
    /// [`PosesError`] if the file cannot be made.
    pub fn create(path: &Path) -> Result<Self, PosesError> {
        Ok(Self { file: CsvFile::create(path, HEADER)? })
    }

    /// Writes a row if a window ended in a step.
    ///
    /// # Errors
    /// [`PosesError`] if the file takes no more.
    pub fn write(&mut self, report: &RigReport) -> Result<(), PosesError> {
        let Some(gradient) = &report.gradient else { return Ok(()) };
        let row = row(report.time, gradient, &report.members);
        self.file.write(row.as_bytes())
    }

    /// Hands all rows to the system.
    ///
    /// # Errors
    /// [`PosesError`] if the file does not take them.
    pub fn finish(self) -> Result<(), PosesError> {
        self.file.finish()
    }
}

fn row(time: SensorTime, gradient: &GradientReport, members: &[MemberStatus]) -> String {
    let bits = |of: fn(&MemberStatus) -> bool| {
        members.iter().enumerate().fold(0, |bits, (k, m)| bits | u32::from(of(m)) << k)
    };
    let v = gradient.velocity_m_s;
    let velocity = match gradient.best_sigma_m_s() {
        Some(sigma) => format!("{:.4},{:.4},{:.4},{sigma:.4}", v.x, v.y, v.z),
        None => ",,,".into(),
    };
    format!(
        "{:.9},{},{velocity},{},{:.3},{:.3},{:.3},{},{}\n",
        time.as_nanos() as f64 * 1e-9,
        verdict_name(gradient.verdict),
        gradient.directions,
        gradient.gradient_ut_m,
        gradient.gradient_sigma_ut_m,
        gradient.nis,
        bits(|m| m.exclusion.is_some()),
        bits(|m| m.magnetometer_alone),
    )
}
