//! The ways to get from samples to positions that are compared.

use serde::Serialize;

use super::dead_reckoning::{Preparation, integrate};
use super::filtered::{FilterError, Variant, follow};
use super::run::Heard;
use super::track::Track;

/// One way to a position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Samples integrated as they come.
    Raw,
    /// The offsets of a rest taken off before.
    OffsetCorrected,
    /// The same through a low-pass.
    LowPassed,
    /// Lodestone's filter, which learns nothing from standstills.
    LodestoneUnaided,
    /// Lodestone's filter as it is shipped.
    Lodestone,
    /// The same with a calibration of the unit.
    LodestoneCalibrated,
}

impl Method {
    /// All of them, in the order of the paper's sentence.
    pub const ALL: [Self; 6] = [
        Self::Raw,
        Self::OffsetCorrected,
        Self::LowPassed,
        Self::LodestoneUnaided,
        Self::Lodestone,
        Self::LodestoneCalibrated,
    ];

    /// What it makes of what was heard.
    ///
    /// # Errors
    /// [`FilterError`] if Lodestone's filter has no pose.
    pub fn follow(self, heard: &Heard) -> Result<Track, FilterError> {
        match self {
            Self::Raw => Ok(integrate(heard, Preparation::Raw)),
            Self::OffsetCorrected => Ok(integrate(heard, Preparation::Offset)),
            Self::LowPassed => Ok(integrate(heard, Preparation::OffsetAndLowPass)),
            Self::LodestoneUnaided => follow(heard, Variant::Unaided),
            Self::Lodestone => follow(heard, Variant::AsShipped),
            Self::LodestoneCalibrated => follow(heard, Variant::Calibrated),
        }
    }
}
