//! The estimator as its user sees it: stories, hostile streams, honesty of the covariance.

mod anchored;
mod city;
mod consistency;
mod fixes;
mod magnetism;
mod relative;
mod ride;
mod scene;
mod simulation;
mod standing;
mod starts;
mod stories;
mod streams;
mod traffic;
