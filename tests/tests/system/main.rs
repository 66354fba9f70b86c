//! The two programs as a user meets them: processes, files and shared memory.
//!
//! A test never asserts how fast something is; it waits for steps, sequence numbers and sensor
//! time, and gives up only where it would hang.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod broad;
mod check;
mod consumers;
mod damaged_recordings;
mod demo;
mod realtime;
mod replay;
mod rig;
mod service;
mod walks;
mod world;
