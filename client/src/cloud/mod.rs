//! Clouds of depth sources: receiving them without a copy, publishing them, and laying them into the
//! world by the poses of the camera that saw them.

mod error;
mod header;
mod lens;
mod motion;
mod publisher;
mod received;
mod stream;

pub use error::{CloudHeaderError, PublishError};
pub use header::CloudInfo;
pub use lens::{Lens, LensPlace};
pub use motion::{KNOT_STEP_NS, MOST_OFFSET_NS, Motion, MotionError};
pub use publisher::{CloudLoan, CloudPublisher};
pub use received::Cloud;
pub use stream::CloudStream;
