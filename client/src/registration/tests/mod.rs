//! Rooms seen from two places.

mod cost;
mod monte_carlo;
mod room;
mod scene;
mod stories;
