//! The relative message: one camera as another one has it.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::layout::assert_layout;
use crate::name::NAME_BYTES;

/// Camera b in the body frame of camera a, at one instant: `p_a = R_ab p_b + D_ab`.
///
/// Its covariance is not the sum of the two poses': what both share (the field's common error, the
/// reference's) cancels. Published about ten times a second for each pair, a before b in the
/// configuration.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.Relative")]
pub struct Relative {
    /// Counts the messages of all pairs from 0.
    pub sequence: u64,
    /// The instant, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// Index of camera a in the daemon's configuration; bodies count on after the cameras.
    pub camera_a: u32,
    /// Index of camera b.
    pub camera_b: u32,
    /// Name of camera a. See [`crate::name_of`].
    pub name_a: [u8; NAME_BYTES],
    /// Name of camera b.
    pub name_b: [u8; NAME_BYTES],
    /// Epoch of the world in which both poses are.
    pub world_epoch: u32,
    /// Pairs that are published, to know when all were seen.
    pub pair_count: u32,
    /// Bits of [`crate::Validity`]: `TILT` and `HEADING`, both or none, for the rotation; `POSITION` for
    /// the distance.
    pub validity: u32,
    /// Code of [`crate::DistanceSource`].
    pub distance_source: u8,
    /// 1 if both are mounted on one body: the rotation is that of the mounting.
    pub rigid: u8,
    /// Zero.
    pub reserved: [u8; 2],
    /// Correlation of the parts of the two heading errors that come from the field at the cameras' place,
    /// 0 to 1; `NaN` when unknown.
    pub field_correlation: f64,
    /// `R_ab`, rotation of b's body axes to a's, unit quaternion `x y z w`; `NaN` when unknown.
    pub orientation: [f64; 4],
    /// Covariance of `R_ab` as a small rotation vector about a's body axes, rad².
    pub orientation_covariance_rad2: [f64; 6],
    /// `D_ab`, from a's body origin to b's, in a's body axes, m; `NaN` when unknown.
    pub distance_m: [f64; 3],
    /// Covariance of `distance_m` in a's body axes, m²; infinite or `NaN` when unknown.
    pub distance_covariance_m2: [f64; 6],
}

assert_layout!(
    Relative,
    size = 328,
    sequence = 0,
    time_ns = 8,
    camera_a = 16,
    camera_b = 20,
    name_a = 24,
    name_b = 88,
    world_epoch = 152,
    pair_count = 156,
    validity = 160,
    distance_source = 164,
    rigid = 165,
    reserved = 166,
    field_correlation = 168,
    orientation = 176,
    orientation_covariance_rad2 = 208,
    distance_m = 256,
    distance_covariance_m2 = 280,
);
