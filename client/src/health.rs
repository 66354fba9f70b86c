//! The health of a lane, checked.

use core::time::Duration;

use lodestone_schema::{
    AidFlags, AlignmentWait, AnchorRefusal, HeadingSource, Health, LaneState, PositionSource,
    RealTimeFlags, ServiceKind, Status, Validity,
};

use crate::error::MessageError;
use crate::message::Message;

/// The health of one lane: state, rates and counters.
///
/// Numbers that are not known are `None`; counters are read from [`LaneHealth::message`].
///
/// ```
/// use lodestone_client::{Health, LaneHealth, LaneState, MessageError};
///
/// fn show(message: Health) -> Result<(), MessageError> {
///     let health = LaneHealth::try_from(message)?;
///     if health.state() == LaneState::Degraded {
///         println!("{} samples lost", health.message().samples_lost);
///     }
///     Ok(())
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneHealth {
    message: Health,
    state: LaneState,
    heading_source: HeadingSource,
    position_source: PositionSource,
    alignment_wait: AlignmentWait,
    anchor_refusal: AnchorRefusal,
}

impl TryFrom<Health> for LaneHealth {
    type Error = MessageError;

    fn try_from(message: Health) -> Result<Self, MessageError> {
        let unknown = |field, code| MessageError::UnknownCode { field, code };
        let state =
            LaneState::from_code(message.state).ok_or_else(|| unknown("state", message.state))?;
        let heading_source = HeadingSource::from_code(message.heading_source)
            .ok_or_else(|| unknown("heading_source", message.heading_source))?;
        let position_source = PositionSource::from_code(message.position_source)
            .ok_or_else(|| unknown("position_source", message.position_source))?;
        let alignment_wait = AlignmentWait::from_code(message.alignment_wait)
            .ok_or_else(|| unknown("alignment_wait", message.alignment_wait))?;
        let anchor_refusal = AnchorRefusal::from_code(message.anchor_refusal)
            .ok_or_else(|| unknown("anchor_refusal", message.anchor_refusal))?;
        Ok(Self { message, state, heading_source, position_source, alignment_wait, anchor_refusal })
    }
}

impl Message for LaneHealth {
    type Raw = Health;
    const KIND: ServiceKind = ServiceKind::Health;
    const SILENCE: Duration = Duration::from_secs(5);

    fn sequence(raw: &Health) -> u64 {
        raw.sequence
    }

    fn time_ns(raw: &Health) -> i64 {
        raw.time_ns
    }
}

/// Declares an accessor that turns `NaN` and infinity into `None`.
macro_rules! known {
    ($($(#[$doc:meta])* $name:ident),+ $(,)?) => {$(
        $(#[$doc])*
        pub fn $name(&self) -> Option<f64> {
            Some(self.message.$name).filter(|value| value.is_finite())
        }
    )+};
}

impl LaneHealth {
    /// The message, with all counters.
    pub const fn message(&self) -> &Health {
        &self.message
    }

    /// What the lane is doing.
    pub const fn state(&self) -> LaneState {
        self.state
    }

    /// Why a lane that aligns has no pose yet.
    pub const fn alignment_wait(&self) -> AlignmentWait {
        self.alignment_wait
    }

    /// Why the last measurement against another camera was not used; `None` if it was, or none came.
    pub fn anchor_refusal(&self) -> Option<AnchorRefusal> {
        Some(self.anchor_refusal).filter(|refusal| *refusal != AnchorRefusal::None)
    }

    /// What the lane says about its latest pose.
    pub const fn status(&self) -> Status {
        Status::from_bits_truncate(self.message.status)
    }

    /// Which fields of the latest pose are known.
    pub const fn validity(&self) -> Validity {
        Validity::from_bits_truncate(self.message.validity)
    }

    /// Where the heading comes from.
    pub const fn heading_source(&self) -> HeadingSource {
        self.heading_source
    }

    /// Where the position comes from.
    pub const fn position_source(&self) -> PositionSource {
        self.position_source
    }

    /// What corrected the latest pose within its last second.
    pub const fn aids_used(&self) -> AidFlags {
        AidFlags::from_bits_truncate(self.message.aids_used)
    }

    /// What was refused by its gate within that second.
    pub const fn aids_refused(&self) -> AidFlags {
        AidFlags::from_bits_truncate(self.message.aids_refused)
    }

    /// What the configuration asks of the system for this lane, and the system refused.
    pub const fn real_time_refused(&self) -> RealTimeFlags {
        RealTimeFlags::from_bits_truncate(self.message.real_time_refused)
    }

    /// Members of a rigid body, and whether each is in use; empty for a camera of its own.
    pub fn members_in_use(&self) -> impl Iterator<Item = bool> + use<> {
        let bits = self.message.members_in_use;
        (0..u32::from(self.message.member_count))
            .map(move |member| bits.checked_shr(member).is_some_and(|rest| rest & 1 == 1))
    }

    known! {
        /// Delay of the low-pass, which the pose has made up for, s; 0 without one.
        group_delay_s,
        /// Samples per second over the last interval.
        sample_rate_hz,
        /// Poses per second over the last interval.
        pose_rate_hz,
        /// Median of arrival to published, s.
        latency_p50_s,
        /// 99th percentile of arrival to published, s.
        latency_p99_s,
        /// Temperature of the IMU, °C.
        temperature_c,
        /// Standard deviation of the heading, rad.
        heading_sigma_rad,
        /// Norm of the last magnetometer reading, µT.
        magnetic_norm_ut,
        /// Rate of the sensor clock against `CLOCK_MONOTONIC`, minus one.
        clock_drift,
    }
}
