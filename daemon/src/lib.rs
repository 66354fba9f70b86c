//! Lodestone's daemon as a library: drivers, lane, publisher, service.
//!
//! The way of one sample is the way through these modules: [`driver`] → ring → loop → [`publisher`].

pub mod cli;
pub mod commands;
pub mod console;
pub mod driver;
pub mod logging;
pub mod publisher;
pub mod reading;
pub mod service;
pub mod status_board;
