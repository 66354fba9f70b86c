//! The dynamic part of the report: the paper's figures "Sensory Ground Truth" and "Trajectory
//! Representation of Climb Stairs", and what it says in words about double integration.

mod drift;
mod format;
mod method;
mod noise;
mod orientation;
mod projection;
mod recorded;
mod stairs;
mod stairs_numbers;
mod text;

pub(super) use format::length;
pub(super) use method::{emphasis, name};
pub(super) use text::tables;

use super::page::{list, section};
use crate::evaluation::dynamic::DynamicResult;

/// What a caption says of how it came about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Context {
    /// The evaluation's seed.
    pub(super) seed: u64,
    /// Runs of each scene.
    pub(super) runs: u32,
}

impl Context {
    /// The end of a caption: how many runs are seen, and how to see them again.
    fn repeat(self, shown: u32) -> String {
        let (seed, runs) = (self.seed, self.runs);
        let seen = if shown == 1 {
            format!("Run 1 of {runs}, the first, not the best.")
        } else {
            format!("{shown} runs.")
        };
        format!(
            "{seen} Again: <code>lodestoned evaluate dynamic --seed {seed} --runs {runs}</code>."
        )
    }
}

/// The dynamic part as sections of a page.
pub(super) fn sections(result: &DynamicResult, seed: u64) -> String {
    let context = Context { seed, runs: result.runs };
    section("noise", "Sensory ground truth", &noise::markup(&result.noise, &context))
        + &section("drift", "Double integration", &drift::markup(result, &context))
        + &section("stairs", "Climbing stairs", &climb(result, &context))
        + &section("harmonic", "Is the swing harmonic?", &harmonic(result, &context))
        + &recordings(result)
}

/// Nothing where no recording was given.
fn recordings(result: &DynamicResult) -> String {
    if result.recordings.is_empty() {
        return String::new();
    }
    section("recordings", "Real recordings", &recorded::markup(&result.recordings))
}

fn climb(result: &DynamicResult, context: &Context) -> String {
    stairs::pictures(result, context)
        + &stairs_numbers::scores(result)
        + &orientation::errors(result, context)
        + &stairs_numbers::compared(result)
}

fn harmonic(result: &DynamicResult, context: &Context) -> String {
    orientation::swing(result, context)
        + &stairs_numbers::swings(&result.stairs)
        + &stairs_numbers::harmony(&result.stairs)
}

/// How the dynamic numbers came about.
pub(super) fn method_notes() -> String {
    list(&[
        "Every run has another unit of the camera (biases at switch-on, noise) and another walker (heading, \
         pace, habits), all drawn from the seed. The magnetometer has 0.4 µT of hard iron and 1/f noise. Each scene begins with ten seconds of rest; time and positions count from \
         its end."
            .into(),
        "All integrations start with the attitude that the rest gives: up by the mean acceleration, north by \
         the mean field, the paper’s one-time initialisation. Then R ← R Exp(ω Δt), a = R f + g, and two \
         trapezoids. “Raw” takes the sensors at their word from there; “offset-corrected” takes off the \
         mean rate, and what the mean acceleration has beyond 9.81 m/s²; “low-pass” is a Butterworth of \
         second order at 10 Hz after that."
            .into(),
        "Lodestone is the lane of the daemon, fed with the same readings, with the defaults of a \
         configuration. It hears samples alone. In “no standstills” its zero-velocity and zero-rate updates \
         are switched off when the rest ends. “Calibrated” has in addition what <code>lodestoned \
         calibrate</code> made of a recording of the same unit, turned by hand for 80 s: chiefly the \
         accelerometer’s offsets, and the magnetometer’s. The integrations know only the rest, as the \
         paper’s offset does."
            .into(),
        "The truth is used for scores, to lay the drawing along the stairs, and to say when the walker is back \
         at the bottom. Position errors are of the displacement since the rest; a heading that is wrong \
         turns it, and counts."
            .into(),
        "Swing: roll, pitch and yaw on the first flight less a cubic trend; the part of the rest that the \
         stride’s first three harmonics explain, the stride’s frequency is that of the largest swing of the same roll."
            .into(),
    ])
}
