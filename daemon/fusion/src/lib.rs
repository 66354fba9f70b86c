//! Lodestone's estimator: a pure function of its inputs.
//!
//! No I/O, no clock, no log, no allocation, no `std`: time arrives inside the sample, decisions
//! leave as data, and the same input gives the same bits. The way through:
//!
//! ```text
//! ImuSample ─> Grid ─> Step ─> Estimator: Alignment, then predict + updates ─> Estimate
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod aid_status;
mod aiding;
mod aids;
mod alignment;
mod covariance;
mod drift;
mod estimator;
mod frame;
mod grid;
mod hard_iron;
mod history;
mod low_pass;
mod parameters;
mod predict;
mod quantity;
pub mod relative;
mod rest;
pub mod rig;
mod sample;
pub mod so3;
mod state;
#[cfg(test)]
mod testing;
mod tie;
mod time;
pub mod update;

pub use aid_status::{AidFlags, AidKind, AidStatus, PositionOrigin};
pub use aiding::{Aid, AidRefusal, AidReport, Anchor, Measurement};
pub use alignment::{Aligned, Alignment, Waiting};
pub use covariance::{
    ACCEL_BIAS, Block, Covariance, DEVIATION, GYRO_BIAS, LEAKY_VELOCITY, MAG_DELAY, MOUNTING,
    ORIENTATION, POSITION, Row, SPEED_SCALE, STATES, VELOCITY,
};
pub use drift::{Drift, Drifted};
pub use estimator::place::{UNKNOWN_POSITION_SIGMA_M, is_position_known};
pub use estimator::{Estimate, Estimator, HeadingOrigin, StepReport};
pub use frame::{Body, Frame, Optical, Rotation, Sensor, Vehicle, World};
pub use grid::{Accepted, Grid, GridParameters, Increment, Refusal, Step};
pub use low_pass::LowPass;
pub use parameters::{
    AidingParameters, AlignmentParameters, CompassParameters, HardIronParameters, HeadingMode,
    LevellingParameters, Parameters, RestParameters, SensorNoise, StanceParameters, Stillness,
    VehicleParameters,
};
pub use quantity::{Accel, Gyro, Mag};
pub use rest::{RestDetector, Standing, WindowStatistics};
pub use sample::ImuSample;
pub use state::State;
pub use time::{SensorSpan, SensorTime};
pub use update::compass::FieldReference;
