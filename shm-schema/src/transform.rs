//! The static transform message: one edge of the tree of frames.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::flags::code;
use crate::layout::assert_layout;
use crate::name::NAME_BYTES;

code! {
    /// Whether an edge of the tree moves.
    TransformKind {
        /// It never changes; the message holds it.
        Fixed = 1,
        /// The child moves in its parent: the pose of that name holds it, here it is `NaN`.
        Moving = 2,
    }
}

/// One edge of the tree of frames: `p_parent = R p_child + t`.
///
/// Frames are named `world`, as the camera or body (its body axes), `<camera>/optical` (the left
/// lens: x right, y down, z forward) and `<camera>/magnetometer` (body axes).
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("lodestone.v2.StaticTransform")]
pub struct StaticTransform {
    /// Counts the messages of this service from 0.
    pub sequence: u64,
    /// When this message was made, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// Index of this edge in the tree, a parent's before its children's.
    pub index: u32,
    /// Edges of the tree, to know when all were seen.
    pub count: u32,
    /// Code of [`TransformKind`].
    pub kind: u8,
    /// Zero.
    pub reserved: [u8; 7],
    /// Name of the parent. See [`crate::name_of`].
    pub parent: [u8; NAME_BYTES],
    /// Name of the child.
    pub child: [u8; NAME_BYTES],
    /// Origin of the child in the parent's axes, m; `NaN` when not known.
    pub translation_m: [f64; 3],
    /// Rotation child to parent, unit quaternion `x y z w`.
    pub rotation: [f64; 4],
}

assert_layout!(
    StaticTransform,
    size = 216,
    sequence = 0,
    time_ns = 8,
    index = 16,
    count = 20,
    kind = 24,
    reserved = 25,
    parent = 32,
    child = 96,
    translation_m = 160,
    rotation = 184,
);
