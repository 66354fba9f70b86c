//! Lodestone's daemon as a library: drivers, lane, publisher, service.
//!
//! The way of one sample is the way through these modules: [`driver`] → [`ring`] → [`lane`] →
//! [`publisher`]; [`pipeline`] wires them for one camera.

pub mod cli;
pub mod clock;
pub mod commands;
pub mod console;
mod csv_file;
pub mod demo;
pub mod driver;
pub mod evaluation;
mod handover;
pub mod hindsight;
pub mod lane;
pub mod logging;
pub mod picture;
pub mod pipeline;
pub mod pose_axes;
pub mod poses_csv;
pub mod publisher;
pub mod reading;
pub mod realtime;
pub mod recording;
pub mod report;
pub mod rig;
pub mod ring;
pub mod scene;
mod seqlock;
pub mod service;
pub mod source;
pub mod status_board;
mod triple_buffer;
pub mod world;
