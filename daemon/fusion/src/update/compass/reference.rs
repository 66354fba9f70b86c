//! The field that the compass expects.

use glam::DVec3;

/// The undisturbed field, as learnt at the alignment and followed slowly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldReference {
    /// Strength, µT.
    pub norm_ut: f64,
    /// Upward part, µT (negative in the north).
    pub vertical_ut: f64,
}

impl FieldReference {
    /// The reference that a field given in levelled coordinates makes.
    pub fn of(field: DVec3) -> Self {
        Self { norm_ut: libm::sqrt(field.length_squared()), vertical_ut: field.z }
    }

    /// Horizontal part, µT.
    pub fn horizontal_ut(&self) -> f64 {
        let squared = self.norm_ut * self.norm_ut - self.vertical_ut * self.vertical_ut;
        libm::sqrt(squared.max(0.0))
    }

    /// The field in the world, µT, where it points to a bearing, east of the world's north, rad.
    pub fn in_world(&self, bearing_rad: f64) -> DVec3 {
        let horizontal_ut = self.horizontal_ut();
        DVec3::new(
            horizontal_ut * libm::sin(bearing_rad),
            horizontal_ut * libm::cos(bearing_rad),
            self.vertical_ut,
        )
    }

    /// How badly a field in the world fits, µT: the root of the squared misfits in strength and
    /// vertical part.
    pub fn mismatch_ut(&self, field: DVec3) -> f64 {
        self.distance_ut(&Self::of(field))
    }

    /// Distance of strength and vertical part, µT.
    pub fn distance_ut(&self, other: &Self) -> f64 {
        let (norm, vertical) = (other.norm_ut - self.norm_ut, other.vertical_ut - self.vertical_ut);
        libm::sqrt(norm * norm + vertical * vertical)
    }

    pub(super) fn follow(&mut self, field: DVec3, share: f64) {
        let new = Self::of(field);
        self.norm_ut += share * (new.norm_ut - self.norm_ut);
        self.vertical_ut += share * (new.vertical_ut - self.vertical_ut);
    }
}
