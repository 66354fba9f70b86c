//! Lodestone's configuration.

pub mod model;
