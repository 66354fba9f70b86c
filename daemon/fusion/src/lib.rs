//! Lodestone's estimator: a pure function of its inputs.
//!
//! No I/O, no clock, no log, no allocation, no `std`: time arrives inside the sample, decisions
//! leave as data.
#![no_std]
#![forbid(unsafe_code)]

mod frame;
mod quantity;
mod time;

pub use frame::{Body, Frame, Optical, Rotation, Sensor, Vehicle, World};
pub use quantity::{Accel, Gyro, Mag};
pub use time::{SensorSpan, SensorTime};
