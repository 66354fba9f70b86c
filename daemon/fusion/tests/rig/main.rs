//! A rig as its user sees it: walks past steel, failing members, disturbances, honesty.

mod consistency;
mod disturbances;
mod gradient;
mod members;
mod scene;
mod steel;
mod walk;
