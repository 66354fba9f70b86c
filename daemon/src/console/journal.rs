//! The lanes in the log: a line for each now and then, and for each change of state.

use std::time::{Duration, Instant};

use lodestone_schema::{AlignmentWait, LaneState, Status};
use tracing::{info, warn};

use super::table::{heading, micros, number, position, state_word};
use crate::service::overview::LaneView;

/// Between two lines about a lane whose state does not change.
const INTERVAL: Duration = Duration::from_secs(10);

/// Remembers what was said of each lane.
#[derive(Debug, Default)]
pub struct Journal {
    last: Option<Instant>,
    states: Vec<(LaneState, AlignmentWait)>,
}

impl Journal {
    /// Says what is new, and every ten seconds how each lane is.
    pub fn note(&mut self, views: &[LaneView], now: Instant) {
        for (index, view) in views.iter().enumerate() {
            self.note_change(index, view);
        }
        let last = *self.last.get_or_insert(now);
        if now.duration_since(last) >= INTERVAL {
            self.last = Some(now);
            for view in views {
                info!("{}", summary(view));
            }
        }
    }

    fn note_change(&mut self, index: usize, view: &LaneView) {
        let known = self.states.get(index).copied();
        let now = (view.state, view.alignment_wait);
        if known == Some(now) {
            return;
        }
        match known {
            Some(_) => self.states[index] = now,
            None => self.states.push(now),
        }
        let (name, word) = (&view.name, state_word(view.state));
        match view.state {
            LaneState::Lost | LaneState::Degraded => warn!("{name}: {word}"),
            LaneState::Aligning => info!("{name}: {word}: {}", view.alignment_wait.advice()),
            _ => info!("{name}: {word}"),
        }
    }
}

const fn field_words(status: Status) -> &'static str {
    let unlike_earth = status.contains(Status::FIELD_UNLIKE_EARTH);
    match (status.contains(Status::MAGNETIC_DISTURBANCE), unlike_earth) {
        (true, true) => ", magnetic disturbance, the field fits neither the start nor the earth",
        (true, false) => ", magnetic disturbance",
        (false, true) => ", the field is not the earth's at the configured place",
        (false, false) => "",
    }
}

fn summary(view: &LaneView) -> String {
    let health = &view.health;
    format!(
        "{}: {}, {} Hz, latency {}/{} µs (p50/p99), heading {} °, position {} m{}, {} dropped, {} refused, {} publish errors",
        view.name,
        state_word(view.state),
        number(health.pose_rate_hz, 1),
        micros(health.latency_p50_s),
        micros(health.latency_p99_s),
        heading(&view.status),
        position(&view.status),
        field_words(view.status.status),
        health.ring_dropped + health.samples_lost,
        health.invalid + health.out_of_order + health.duplicates,
        health.publish_errors,
    )
}
