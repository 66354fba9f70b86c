//! The estimator as its user sees it: stories, hostile streams, honesty of the covariance.

mod consistency;
mod magnetism;
mod relative;
mod scene;
mod simulation;
mod starts;
mod stories;
mod streams;
