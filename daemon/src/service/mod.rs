//! What makes a process of the lanes: one instance, enough memory, signals, housekeeping.

pub mod housekeeping;
pub mod instance;
pub mod leftovers;
pub mod overview;
pub mod prefault;
pub mod signals;
pub mod space;
mod world_duty;
