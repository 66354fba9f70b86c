//! The estimator as its user sees it: stories, hostile streams, honesty of the covariance.

mod city;
mod consistency;
mod magnetism;
mod scene;
mod simulation;
mod starts;
mod stories;
mod streams;
mod traffic;
