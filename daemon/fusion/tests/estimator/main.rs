//! The estimator as its user sees it: stories, hostile streams, honesty of the covariance.

mod consistency;
mod simulation;
mod stories;
mod streams;
