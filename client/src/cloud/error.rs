//! Why a cloud is not used, and why one is not published.

use crate::error::{CameraNameError, ConnectError};

/// Why a cloud found in shared memory is not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CloudHeaderError {
    /// The header and the slice disagree about the number of points.
    #[error("the header says {width} by {height} points, the cloud has {points}; allowed: equal")]
    PointCount {
        /// Points in a row by the header.
        width: u32,
        /// Rows by the header.
        height: u32,
        /// Points found.
        points: usize,
    },
    /// No row.
    #[error("field height holds 0; allowed: 1 or more")]
    NoRow,
    /// A frame that this version does not know.
    #[error("field frame holds code {0}; allowed: 0 (optical), 1 (body)")]
    UnknownFrame(u8),
    /// A field that this version does not know: its points could mean something else.
    #[error("field fields holds the bits {0:#x}, of which this version knows 0x3 only")]
    UnknownFields(u32),
    /// A time before the clock's origin.
    #[error("field time_ns holds {0} ns; allowed: 0 or more")]
    NegativeTime(i64),
    /// A depth noise that is none.
    #[error("field depth_sigma_per_m is below zero or infinite; allowed: 0 or more, or NaN")]
    DepthSigma,
}

/// Why a cloud was not published.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
    /// The camera's name cannot be one.
    #[error(transparent)]
    Name(#[from] CameraNameError),
    /// The domain or its service cannot be entered; try again with the next cloud.
    #[error(transparent)]
    Connect(#[from] ConnectError),
    /// The cloud is larger than was asked for at the start.
    #[error(
        "a cloud of {width} by {height} points; allowed: {most} in all, as this publisher was made for"
    )]
    TooManyPoints {
        /// Points in a row.
        width: u32,
        /// Rows.
        height: u32,
        /// Most points of a cloud.
        most: usize,
    },
    /// No row, or a publisher for clouds without points.
    #[error("a cloud without a row of points; allowed: height 1 or more, most points 1 or more")]
    NoPoints,
    /// A time before the clock's origin.
    #[error("the cloud's time is {0} ns; allowed: 0 or more, of CLOCK_MONOTONIC")]
    NegativeTime(i64),
    /// Shared memory is nearly full.
    #[error(
        "clouds of {camera:?} take up to {needed_mb} MB of shared memory, of which {free_mb} MB are free: smaller clouds, or a larger /dev/shm"
    )]
    NoRoom {
        /// The camera.
        camera: String,
        /// What this publisher may come to use, MB.
        needed_mb: u64,
        /// What is free, MB.
        free_mb: u64,
    },
    /// The transport refused.
    #[error("cannot publish a cloud of {camera:?}: {what}")]
    Transport {
        /// The camera.
        camera: String,
        /// What iceoryx2 says.
        what: String,
    },
}
