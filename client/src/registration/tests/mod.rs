//! Rooms seen from two places.

mod monte_carlo;
mod room;
mod scene;
mod stories;
