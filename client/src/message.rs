//! What the streams need to know about a message.

use core::fmt::Debug;
use core::time::Duration;

use iceoryx2::prelude::ZeroCopySend;
use lodestone_schema::ServiceKind;

use crate::error::MessageError;

/// A checked message and the plain one it comes from.
pub trait Message: TryFrom<Self::Raw, Error = MessageError> {
    /// As it lies in shared memory.
    type Raw: Copy + Debug + ZeroCopySend + 'static;

    /// The service that carries it.
    const KIND: ServiceKind;

    /// After this long without a message the service is opened anew, in case it was replaced.
    const SILENCE: Duration;

    /// Number within the lane.
    fn sequence(raw: &Self::Raw) -> u64;

    /// Time on `CLOCK_MONOTONIC`, ns.
    fn time_ns(raw: &Self::Raw) -> i64;
}
