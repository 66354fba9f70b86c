//! The request message: what a consumer asks the daemon for.

use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::flags::code;
use crate::layout::assert_layout;

code! {
    /// What is asked for.
    RequestKind {
        /// Define the world anew: [`crate::World::epoch`] is raised once it is done.
        ReinitialiseWorld = 1,
    }
}

/// A request to the daemon. There is no answer; its effect is published.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, ZeroCopySend)]
#[type_name("lodestone.v2.Request")]
pub struct Request {
    /// When it was made, `CLOCK_MONOTONIC`, ns.
    pub time_ns: i64,
    /// Process that asks, for the daemon's log.
    pub process_id: u32,
    /// Code of [`RequestKind`].
    pub kind: u8,
    /// Zero.
    pub reserved: [u8; 3],
}

assert_layout!(Request, size = 16, time_ns = 0, process_id = 8, kind = 12, reserved = 13);
