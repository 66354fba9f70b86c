//! Lodestone's daemon as a library: drivers, lane, publisher, service.
//!
//! The way of one sample is the way through these modules: [`driver`] → [`ring`] → loop → publisher.

pub mod clock;
pub mod driver;
pub mod poses_csv;
pub mod reading;
pub mod recording;
pub mod ring;
