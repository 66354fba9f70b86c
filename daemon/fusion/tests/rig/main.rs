//! A rig as its user sees it: walks past steel, failing members, disturbances, honesty.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod consistency;
mod disturbances;
mod gradient;
mod members;
mod scene;
mod steel;
mod walk;
