//! Lodestone's daemon as a library: drivers, lane, publisher, service.
//!
//! The way of one sample is the way through these modules: [`driver`] → ring → loop → [`publisher`].

pub mod driver;
pub mod publisher;
pub mod reading;
pub mod service;
pub mod status_board;
