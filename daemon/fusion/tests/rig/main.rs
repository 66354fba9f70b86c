//! A rig as its user sees it: walks past steel, failing members, disturbances, honesty.

mod explore;
mod gradient;
mod scene;
mod steel;
mod walk;
