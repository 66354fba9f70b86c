//! Flags and codes in words.

use core::fmt::Debug;

use bitflags::Flags;
use lodestone_client::{AlignmentWait, LaneHealth, LaneState, RealTimeFlags, Status};

/// The names of the bits set, in lower case.
pub(super) fn bits(flags: impl Flags + Copy) -> Vec<String> {
    flags.iter_names().map(|(name, _)| name.to_ascii_lowercase()).collect()
}

/// A variant's name in snake case.
pub(super) fn code(variant: impl Debug) -> String {
    let mut words = String::new();
    for letter in format!("{variant:?}").chars() {
        if letter.is_ascii_uppercase() && !words.is_empty() {
            words.push('_');
        }
        words.push(letter.to_ascii_lowercase());
    }
    words
}

/// What is wrong with a lane, by its status and counters.
pub(super) fn problems(health: Option<&LaneHealth>, status: Status) -> Vec<String> {
    const WARNINGS: [(Status, &str); 10] = [
        (Status::MAGNETIC_DISTURBANCE, "magnetic disturbance: the magnetometer is not trusted"),
        (
            Status::FIELD_UNLIKE_EARTH,
            "the field is not the earth's at the configured place: calibrate the magnetometer, keep \
             it away from iron, or correct [world]",
        ),
        (Status::SENSOR_STALE, "the sensor is silent"),
        (Status::BRIDGED, "samples are being lost and bridged"),
        (Status::SATURATED, "a sensor is at the end of its range"),
        (Status::DEGRADED, "a gap too long to bridge was crossed"),
        (
            Status::DISTURBANCE_LOCAL,
            "this camera alone sees the disturbance: something beside it is magnetic",
        ),
        (Status::MEMBER_OUT, "a camera of this body is voted out or silent"),
        (Status::POSITION_JUMPED, "the position was corrected by more than its sigma allowed"),
        (Status::GIMBAL_LOCK, "pitch is near ±90°: yaw and roll are not separate"),
    ];
    let set = WARNINGS.iter().filter(|(flag, _)| status.contains(*flag));
    let mut found: Vec<String> = set.map(|(_, words)| (*words).to_owned()).collect();
    found.extend(health.and_then(state_problem).map(str::to_owned));
    found.extend(health.map(refused).unwrap_or_default());
    let refusal = health.and_then(LaneHealth::anchor_refusal);
    found.extend(
        refusal.map(|why| format!("aiding against another camera refused: {}", why.advice())),
    );
    found.extend(health.map(counted).unwrap_or_default());
    found
}

/// What the system did not grant; `lodestone doctor` says which limit to raise.
fn refused(health: &LaneHealth) -> Vec<String> {
    const REFUSALS: [(RealTimeFlags, &str); 4] = [
        (RealTimeFlags::SCHEDULING, "no real-time priority"),
        (RealTimeFlags::MEMORY_LOCK, "memory is not locked"),
        (RealTimeFlags::AFFINITY, "not on its processor"),
        (RealTimeFlags::TIMER_SLACK, "timer slack not set"),
    ];
    let set = REFUSALS.iter().filter(|(flag, _)| health.real_time_refused().contains(*flag));
    set.map(|(_, words)| format!("{words}, though configured: see lodestone doctor")).collect()
}

fn state_problem(health: &LaneHealth) -> Option<&'static str> {
    let wait = health.alignment_wait();
    if health.state() == LaneState::Aligning && wait != AlignmentWait::None {
        return Some(wait.advice());
    }
    match health.state() {
        LaneState::Searching => Some("the device is being looked for"),
        LaneState::Aligning => Some("the initial alignment waits for rest"),
        LaneState::Lost => Some("the device is gone, or silent, or gives nothing that can be used"),
        LaneState::Ended => Some("the source has ended"),
        LaneState::Running | LaneState::Degraded => None,
    }
}

fn counted(health: &LaneHealth) -> Vec<String> {
    let m = health.message();
    let counters = [
        (m.samples_lost, "samples lost"),
        (m.ring_dropped, "samples dropped by a full ring"),
        (m.duplicates, "duplicate samples"),
        (m.out_of_order, "samples out of order"),
        (m.invalid, "invalid samples"),
        (m.reconnects, "reconnects"),
        (m.resets, "filter resets"),
        (m.publish_errors, "messages refused by the transport"),
        (m.aiding_refused, "aiding measurements refused"),
        (m.aiding_invalid, "aiding measurements not understood"),
    ];
    let nonzero = counters.iter().filter(|(count, _)| *count > 0);
    nonzero.map(|(count, what)| format!("{count} {what} since start")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_lower_case_words() {
        assert_eq!(
            bits(Status::INITIALISED | Status::SENSOR_STALE),
            ["initialised", "sensor_stale"]
        );
        assert_eq!(code(LaneState::Running), "running");
        assert_eq!(code(lodestone_client::HeadingSource::GyroscopeHeld), "gyroscope_held");
    }
}
