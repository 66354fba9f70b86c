//! Magnetised steel as point dipoles, in closed form.

use glam::DVec3;

/// A dipole.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dipole {
    /// m in the world.
    pub(crate) position: DVec3,
    /// A m².
    pub(crate) moment: DVec3,
}

/// The earth's field, µT.
pub(crate) const EARTH: DVec3 = DVec3::new(0.0, 21.0, -43.0);

/// `µ₀/4π (3 (m·r̂) r̂ − m) / r³`, µT.
pub(crate) fn dipole_field(dipole: &Dipole, place: DVec3) -> DVec3 {
    let r = place - dipole.position;
    let distance = r.length();
    let n = r / distance;
    (n * (3.0 * dipole.moment.dot(n)) - dipole.moment) * (0.1 / distance.powi(3))
}

/// The whole field at a place, µT.
pub(crate) fn field(steel: &[Dipole], place: DVec3) -> DVec3 {
    steel.iter().fold(EARTH, |sum, dipole| sum + dipole_field(dipole, place))
}

/// Frobenius norm of the gradient at a place, µT/m.
pub(crate) fn gradient_norm(steel: &[Dipole], place: DVec3) -> f64 {
    let h = 1e-3;
    let by = |d: DVec3| (field(steel, place + d * h) - field(steel, place - d * h)) / (2.0 * h);
    [DVec3::X, DVec3::Y, DVec3::Z].map(|d| by(d).length_squared()).iter().sum::<f64>().sqrt()
}
