//! Lodestone's calibration: recorded movement in, errors of the sensors out, with their covariance.
//!
//! A magnetometer on a vehicle reads `m = A Rᵀ h + b + b₁ (T − T₀)`: the earth's field `h`, turned
//! into the sensor by the attitude `R`, distorted by soft iron `A`, shifted by hard iron `b`. The
//! norm of the field alone cannot tell `A` and `b` on a vehicle that tilts little. So the attitude
//! is estimated along with them, from gyroscope and accelerometer, in one maximum a posteriori
//! fit over the whole recording. Its covariance says how well the heading will be known, and a
//! recording that cannot tell is refused with the movement that is missing.
//!
//! ```text
//! Sample… ─> intervals (gyro integrated, readings averaged) ─> start ─> fit ─> Outcome
//!     └────> Coverage ─────────────────────────────────────────────────────────┴─> or Refusal
//! ```
//!
//! No I/O, no clock, no log; the same samples give the same bits. All vectors are in the sensor's
//! own axes, whatever they are, as long as all three sensors share them.
#![forbid(unsafe_code)]

mod calibrate;
mod coverage;
mod heading;
mod levelling;
mod linear;
mod outcome;
mod progress;
mod refusal;
mod sample;
mod settings;
mod solve;
mod stream;
mod verdict;

pub use calibrate::calibrate;
pub use coverage::Coverage;
pub use outcome::{
    AccelerometerErrors, FieldFound, GyroErrors, MagnetometerErrors, Outcome, TemperatureSpan,
};
pub use progress::{Progress, thinned};
pub use refusal::{Missing, Refusal};
pub use sample::Sample;
pub use settings::{FieldPrior, Limits, SensorNoise, Settings};
