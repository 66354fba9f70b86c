//! One camera as another one has it: relative orientation and distance, with covariance.
//!
//! Both poses are in one world, and their errors have parts in common, which cancel. With
//! `R_true = Exp(δθ) R` for each, the relative rotation `R_ab = R_aᵀ R_b` errs by
//! `R_aᵀ (δθ_b − δθ_a)` about a's body axes, so
//!
//! ```text
//! Cov(R_ab) = R_aᵀ (P_a + P_b − C − Cᵀ) R_a,   C = Cov(δθ_a, δθ_b)
//! ```
//!
//! **What is shared.** Each filter estimates the deviation d of the field at its place from the world's
//! north, and knows how its orientation error hangs on the error of that: `δθ = k δd + own`, with
//! `k = P_θd / P_dd`. At one place there is one d. Two filters that learnt of it by measurements of
//! their own, from the same prior variance σ², err by `δd_a` and `δd_b` with
//!
//! ```text
//! Cov(δd_a, δd_b) = ρ P_a,dd P_b,dd / σ²
//! ```
//!
//! (`E[d | y_a]` errs by `(P_a / σ²) d` and own noise): all of it is shared while neither has learnt
//! anything, next to nothing once both know it. ρ = exp(−|D| / way) counts how the deviation becomes
//! another one from place to place; a distance that is not known counts as far. So
//! `C = ρ P_a,θd P_b,θdᵀ / σ²`.
//!
//! An error of the world's north (of a declination) is in neither covariance, and cancels. What a
//! calibration left, and what an accelerometer's bias does to the tilt, is each camera's own.

use glam::{DMat3, DVec3};

use crate::estimator::place::is_position_known;
use crate::frame::{Body, Rotation, Vehicle, World};
use crate::so3;

mod tied;

pub use tied::{Apart, Tied, relative_by};

#[cfg(test)]
mod tests;

/// How an orientation's error hangs on the deviation of the field at the camera's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldTie {
    /// Covariance of the orientation's error about the world axes with the deviation's, rad².
    pub with_orientation_rad2: DVec3,
    /// Variance of the deviation's error, rad².
    pub variance_rad2: f64,
    /// Variance of a deviation of which nothing was learnt, rad².
    pub prior_variance_rad2: f64,
    /// Way after which the deviation is another one, m.
    pub way_m: f64,
}

/// One camera at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Body to world.
    pub orientation: Rotation<World, Body>,
    /// Covariance of the orientation error about the world axes, rad², all of it.
    pub orientation_covariance: DMat3,
    /// Angular rate in the body, rad/s.
    pub angular_rate: DVec3,
    /// Position in the world, m.
    pub position: DVec3,
    /// Covariance of the position, m².
    pub position_covariance: DMat3,
    /// Velocity in the world, m/s.
    pub velocity: DVec3,
    /// Covariance of the velocity, (m/s)².
    pub velocity_covariance: DMat3,
    /// The camera stands.
    pub at_rest: bool,
    /// What is shared with cameras nearby.
    pub field: FieldTie,
}

/// Camera b in the body axes of camera a: `p_a = R_ab p_b + D_ab`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relative {
    /// `R_ab`: b's body axes to a's.
    pub orientation: Rotation<Body, Body>,
    /// Covariance of `R_ab` as a small rotation vector about a's body axes, rad².
    pub orientation_covariance: DMat3,
    /// `D_ab`, from a's body origin to b's in a's body axes, m; `None` where it is not known.
    pub distance: Option<Distance>,
    /// ρ: how much of the field's deviation is common to both places, 0 to 1.
    pub field_correlation: f64,
}

/// A distance in the body axes of camera a.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// m.
    pub vector: DVec3,
    /// m².
    pub covariance: DMat3,
}

/// Angular acceleration and acceleration of a carried camera, 1σ: what carrying a pose ahead at its
/// rate and velocity overlooks.
const ANGULAR_ACCELERATION_RAD_S2: f64 = 20.0;
const ACCELERATION_M_S2: f64 = 5.0;

impl Station {
    /// The same camera a little later or earlier, s, at its rate and velocity.
    #[must_use]
    pub fn carried(&self, span_s: f64) -> Self {
        let square = |x: f64| DMat3::from_diagonal(DVec3::splat(x * x));
        let turned = self.orientation.quaternion() * so3::exp(self.angular_rate * span_s);
        // A camera that stands is not accelerated.
        let half_square = if self.at_rest { 0.0 } else { 0.5 * span_s * span_s };
        Self {
            orientation: Rotation::from_unit(so3::renormalise(turned)),
            orientation_covariance: self.orientation_covariance
                + square(ANGULAR_ACCELERATION_RAD_S2 * half_square),
            position: self.position + self.velocity * span_s,
            position_covariance: self.position_covariance
                + self.velocity_covariance * (span_s * span_s)
                + square(ACCELERATION_M_S2 * half_square),
            ..*self
        }
    }

    /// The distance to another one, if both positions are known.
    fn distance_to(&self, other: &Self) -> Option<Distance> {
        let known = is_position_known(self.position_covariance)
            && is_position_known(other.position_covariance);
        known.then(|| {
            let to_body = self.orientation.matrix().transpose();
            let vector = other.position - self.position;
            // An error of a's orientation turns the distance: δD = −δθ × D = [D]× δθ, in the world.
            let by_turn = so3::skew(vector);
            let turned = by_turn * self.orientation_covariance * by_turn.transpose();
            let covariance = self.position_covariance + other.position_covariance + turned;
            Distance {
                vector: to_body * vector,
                covariance: symmetric(to_body * covariance * to_body.transpose()),
            }
        })
    }
}

/// How a camera sits on a rigid body, as it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mount {
    /// The camera's axes to the body's.
    pub orientation: Rotation<Vehicle, Body>,
    /// Position on the body, in the body's axes, m.
    pub position: DVec3,
    /// How well the rotation is known about each axis, 1σ, rad.
    pub rotation_sigma_rad: f64,
    /// How well the position is known along each axis, 1σ, m.
    pub position_sigma_m: f64,
}

impl Mount {
    /// The camera as a station in the frame of its body, which stands still in it.
    fn on_body(&self) -> Station {
        let square = |x: f64| DMat3::from_diagonal(DVec3::splat(x * x));
        Station {
            orientation: Rotation::from_unit(self.orientation.quaternion()),
            orientation_covariance: square(self.rotation_sigma_rad),
            angular_rate: DVec3::ZERO,
            position: self.position,
            position_covariance: square(self.position_sigma_m),
            velocity: DVec3::ZERO,
            velocity_covariance: DMat3::ZERO,
            at_rest: true,
            field: FieldTie {
                with_orientation_rad2: DVec3::ZERO,
                variance_rad2: 0.0,
                prior_variance_rad2: 0.0,
                way_m: 1.0,
            },
        }
    }

    /// A camera that sits so on a body that is known: where it is and how it moves, its mounting's
    /// errors included.
    pub fn carried_by(&self, body: &Station) -> Station {
        let turn = body.orientation.matrix();
        let arm = turn * self.position;
        let rate = turn * body.angular_rate;
        let by_turn = so3::skew(arm);
        let square = |x: f64| DMat3::from_diagonal(DVec3::splat(x * x));
        let turned = by_turn * body.orientation_covariance * by_turn.transpose();
        let camera = self.orientation.quaternion();
        Station {
            orientation: Rotation::from_unit(body.orientation.quaternion() * camera),
            orientation_covariance: body.orientation_covariance + square(self.rotation_sigma_rad),
            angular_rate: camera.conjugate() * body.angular_rate,
            position: body.position + arm,
            position_covariance: body.position_covariance + turned + square(self.position_sigma_m),
            velocity: body.velocity + rate.cross(arm),
            ..*body
        }
    }
}

/// Camera b as camera a has it, where both sit on one rigid body: as they were mounted, whatever the
/// body does.
pub fn mounted(a: &Mount, b: &Mount) -> Relative {
    Relative { field_correlation: 1.0, ..relative(&a.on_body(), &b.on_body()) }
}

/// Camera b as camera a has it; both at the same instant.
pub fn relative(a: &Station, b: &Station) -> Relative {
    let to_body = a.orientation.matrix().transpose();
    let distance = a.distance_to(b);
    let field_correlation = distance.map_or(0.0, |d| correlation(&d, &a.field, &b.field));
    let shared = shared(&a.field, &b.field, field_correlation);
    let covariance =
        a.orientation_covariance + b.orientation_covariance - shared - shared.transpose();
    let orientation = a.orientation.inverse() * b.orientation;
    Relative {
        orientation: Rotation::from_unit(so3::renormalise(orientation.quaternion())),
        orientation_covariance: symmetric(to_body * covariance * to_body.transpose()),
        distance,
        field_correlation,
    }
}

/// `Cov(δθ_a, δθ_b)`, rad².
fn shared(a: &FieldTie, b: &FieldTie, correlation: f64) -> DMat3 {
    // A field that is off by more than usual had the larger prior.
    let prior =
        a.prior_variance_rad2.max(b.prior_variance_rad2).max(a.variance_rad2).max(b.variance_rad2);
    if prior <= 0.0 {
        return DMat3::ZERO;
    }
    let (a, b) = (a.with_orientation_rad2, b.with_orientation_rad2);
    DMat3::from_cols(a * b.x, a * b.y, a * b.z) * (correlation / prior)
}

/// How much of the deviation is common over a distance, its uncertainty included.
fn correlation(distance: &Distance, a: &FieldTie, b: &FieldTie) -> f64 {
    let c = &distance.covariance;
    let square = distance.vector.length_squared() + c.x_axis.x + c.y_axis.y + c.z_axis.z;
    libm::exp(-libm::sqrt(square) / a.way_m.min(b.way_m))
}

fn symmetric(m: DMat3) -> DMat3 {
    (m + m.transpose()) * 0.5
}

impl Relative {
    /// The other way round: camera a as camera b has it.
    ///
    /// The covariances are turned over with the present values; that of the distance gains what the
    /// rotation's error does to it.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let orientation = self.orientation.inverse();
        let turn = orientation.matrix();
        let over = |m: DMat3| symmetric(turn * m * turn.transpose());
        let distance = self.distance.map(|d| {
            let by_turn = so3::skew(d.vector);
            let turned = by_turn * self.orientation_covariance * by_turn.transpose();
            Distance { vector: -(turn * d.vector), covariance: over(d.covariance + turned) }
        });
        let orientation_covariance = over(self.orientation_covariance);
        Self { orientation, orientation_covariance, distance, ..*self }
    }
}
