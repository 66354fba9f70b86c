//! How a member fixed the world.

use glam::{DQuat, DVec3};

use crate::reading::HostTime;

/// Number of 64-bit words of a [`Founding`].
pub(super) const WORDS: usize = 14;

/// What holds at t0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Founding {
    /// Epoch of the world that was fixed, from 1.
    pub epoch: u32,
    /// t0 on `CLOCK_MONOTONIC`: arrival of the sample that completed the alignment.
    pub time: HostTime,
    /// First camera's rotation body to world.
    pub orientation: DQuat,
    /// Standard deviation of its heading, rad.
    pub heading_sigma_rad: f64,
    /// Standard deviation of its tilt about the worse axis, rad.
    pub tilt_sigma_rad: f64,
    /// The field in the world, µT, if there is a magnetometer.
    pub field_ut: Option<DVec3>,
    /// What is at the world's origin (the magnetometer) in the first camera's axes, m.
    pub origin_in_body_m: DVec3,
}

impl Founding {
    pub(super) fn to_words(self) -> [u64; WORDS] {
        let [qx, qy, qz, qw] = self.orientation.to_array().map(f64::to_bits);
        let [bx, by, bz] = self.field_ut.unwrap_or(DVec3::NAN).to_array().map(f64::to_bits);
        let [ox, oy, oz] = self.origin_in_body_m.to_array().map(f64::to_bits);
        [
            self.epoch.into(),
            self.time.as_nanos().cast_unsigned(),
            qx,
            qy,
            qz,
            qw,
            self.heading_sigma_rad.to_bits(),
            self.tilt_sigma_rad.to_bits(),
            bx,
            by,
            bz,
            ox,
            oy,
            oz,
        ]
    }

    /// `None` while nothing was reported.
    pub(super) fn from_words(words: &[u64; WORDS]) -> Option<Self> {
        let epoch = words[0] as u32;
        let number = |at: usize| f64::from_bits(words[at]);
        let three = |at: usize| DVec3::new(number(at), number(at + 1), number(at + 2));
        (epoch > 0).then(|| Self {
            epoch,
            time: HostTime::from_nanos(words[1].cast_signed()),
            orientation: DQuat::from_xyzw(number(2), number(3), number(4), number(5)),
            heading_sigma_rad: number(6),
            tilt_sigma_rad: number(7),
            field_ut: Some(three(8)).filter(|field| field.is_finite()),
            origin_in_body_m: three(11),
        })
    }
}
