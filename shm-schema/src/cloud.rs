//! The cloud message: points that a depth source saw, as one slice in shared memory.

use bitflags::bitflags;
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::flags::code;
use crate::layout::assert_layout;

bitflags! {
    /// Which fields of a [`CloudPoint`] hold something.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct CloudFields: u32 {
        /// [`CloudPoint::colour`].
        const COLOUR = 1 << 0;
        /// [`CloudPoint::time_offset_ns`]; without it all points were seen at the cloud's time.
        const POINT_TIME = 1 << 1;
    }
}

code! {
    /// The frame in which a cloud's points are given.
    CloudFrame {
        /// The left optical frame of the camera: x right, y down, z forward.
        Optical = 0,
        /// The camera's IMU frame: x forward, y left, z up.
        Body = 1,
    }
}

/// What is true of a whole cloud; the user header of its sample.
///
/// A cloud is a sample of `[CloudPoint]` with this header, published under the name of the camera that
/// it was seen with. It is *organised* where `height` is above 1: row by row as an image, `width *
/// height` points, of which those without depth are `NaN`. Otherwise `height` is 1 and `width` counts
/// the points.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.CloudHeader")]
pub struct CloudHeader {
    /// Counts the clouds of this source from 0; a difference above 1 is what a consumer lost.
    pub sequence: u64,
    /// When the cloud was seen, `CLOCK_MONOTONIC`, ns; the times of points count from here.
    pub time_ns: i64,
    /// When the cloud was handed to the transport, `CLOCK_MONOTONIC`, ns.
    pub published_time_ns: i64,
    /// Points in a row.
    pub width: u32,
    /// Rows; 1 if the cloud is not organised.
    pub height: u32,
    /// Bits of [`CloudFields`].
    pub fields: u32,
    /// Standard deviation of a point's depth over the square of that depth, as of a stereo camera, 1/m;
    /// `NaN` if it is not known.
    pub depth_sigma_per_m: f32,
    /// Code of [`CloudFrame`].
    pub frame: u8,
    /// Zero.
    pub reserved: [u8; 7],
}

assert_layout!(
    CloudHeader,
    size = 48,
    sequence = 0,
    time_ns = 8,
    published_time_ns = 16,
    width = 24,
    height = 28,
    fields = 32,
    depth_sigma_per_m = 36,
    frame = 40,
    reserved = 41,
);

impl Default for CloudHeader {
    /// An empty cloud of which nothing is known; the transport begins a header with this.
    fn default() -> Self {
        Self {
            sequence: 0,
            time_ns: 0,
            published_time_ns: 0,
            width: 0,
            height: 1,
            fields: 0,
            depth_sigma_per_m: f32::NAN,
            frame: CloudFrame::Optical.code(),
            reserved: [0; 7],
        }
    }
}

/// One point of a cloud.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.CloudPoint")]
pub struct CloudPoint {
    /// Position in the cloud's frame, m; `NaN` where there is no depth.
    pub position_m: [f32; 3],
    /// When this point was seen, after [`CloudHeader::time_ns`], ns; 0 without [`CloudFields::POINT_TIME`].
    pub time_offset_ns: i32,
    /// Red, green, blue, opacity, 0 to 255; 0 without [`CloudFields::COLOUR`].
    pub colour: [u8; 4],
}

assert_layout!(CloudPoint, align = 4, size = 20, position_m = 0, time_offset_ns = 12, colour = 16,);

impl Default for CloudPoint {
    /// A point without depth; the transport fills a fresh cloud with it.
    fn default() -> Self {
        Self { position_m: [f32::NAN; 3], time_offset_ns: 0, colour: [0; 4] }
    }
}
