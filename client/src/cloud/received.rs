//! A cloud as it lies in shared memory.

use core::fmt;
use core::ops::Deref;

use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;
use lodestone_schema::{CloudHeader, CloudPoint};

use super::header::CloudInfo;

/// A cloud, borrowed from shared memory without a copy; a slice of [`CloudPoint`] with a checked header.
///
/// Its place is free for the source again when this is dropped. A stream lends two at a time, so do not
/// keep it: place its points, or copy what is needed. Points themselves are not checked: a position may be
/// `NaN` (no depth) or anything else that fits three f32.
pub struct Cloud {
    sample: Sample<ipc::Service, [CloudPoint], CloudHeader>,
    info: CloudInfo,
}

impl Cloud {
    pub(super) const fn new(
        sample: Sample<ipc::Service, [CloudPoint], CloudHeader>,
        info: CloudInfo,
    ) -> Self {
        Self { sample, info }
    }

    /// What is true of all points.
    pub const fn info(&self) -> &CloudInfo {
        &self.info
    }

    /// The points, row by row.
    pub fn points(&self) -> &[CloudPoint] {
        self.sample.payload()
    }
}

impl Deref for Cloud {
    type Target = [CloudPoint];

    fn deref(&self) -> &[CloudPoint] {
        self.points()
    }
}

impl fmt::Debug for Cloud {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Cloud").field("info", &self.info).finish_non_exhaustive()
    }
}
