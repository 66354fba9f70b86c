//! Rooms seen from two places.

mod room;
mod scene;
mod stories;
