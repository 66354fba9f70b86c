//! The magnetic field around the camera: the earth's, and what comes and goes beside it.

use std::time::{SystemTime, UNIX_EPOCH};

use glam::DVec3;
use lodestone_config::model::{Disturbance, North, Steel, World};
use thiserror::Error;
use world_magnetic_model::time::{Date, OffsetDateTime, util::days_in_year};
use world_magnetic_model::uom::si::angle::{degree, radian};
use world_magnetic_model::uom::si::f32::{Angle, Length};
use world_magnetic_model::uom::si::length::meter;
use world_magnetic_model::uom::si::magnetic_flux_density::microtesla;
use world_magnetic_model::{Error as WmmError, GeomagneticField};

use super::jet::Blend;

/// Why the earth's field is not known.
#[derive(Debug, Error)]
pub enum FieldError {
    /// The place or the date is outside of the World Magnetic Model.
    #[error(
        "world (latitude_deg {latitude_deg}, longitude_deg {longitude_deg}, altitude_m \
         {altitude_m}): the World Magnetic Model does not cover it: {source}"
    )]
    Model {
        /// As configured, degrees.
        latitude_deg: f64,
        /// As configured, degrees.
        longitude_deg: f64,
        /// As configured, m.
        altitude_m: f64,
        /// What the model says.
        source: WmmError,
    },
    /// The configured year is no date.
    #[error("world.year is {0}; allowed is a decimal year such as 2026.5")]
    Year(f64),
    /// The computer's clock gives no date.
    #[error("world.year is absent and this computer's clock is not set; set the clock or the year")]
    Clock,
}

/// The earth's field at one place and date, by the World Magnetic Model (NOAA).
///
/// It is uniform: over a town it changes by less than 0.1 µT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EarthField {
    /// The field in W (east, north, up of the configured north), µT.
    pub world_ut: DVec3,
    /// Declination, from true north to magnetic north, east positive, rad.
    pub declination_rad: f64,
    /// Direction of true north from W's y axis, anticlockwise seen from above, rad: the
    /// declination where W's y is magnetic north, else 0.
    pub true_north_rad: f64,
}

impl EarthField {
    /// The field at a world's place and date.
    ///
    /// # Errors
    /// If the model does not cover the place or the date.
    pub fn of(world: &World) -> Result<Self, FieldError> {
        let model = GeomagneticField::new(
            Length::new::<meter>(world.altitude_m as f32),
            Angle::new::<degree>(world.latitude_deg as f32),
            Angle::new::<degree>(world.longitude_deg as f32),
            date(world.year)?,
        )
        .map_err(|source| FieldError::Model {
            latitude_deg: world.latitude_deg,
            longitude_deg: world.longitude_deg,
            altitude_m: world.altitude_m,
            source,
        })?;
        // The model's axes are north, east, down.
        let [north, east, down] =
            [model.x(), model.y(), model.z()].map(|b| f64::from(b.get::<microtesla>()));
        let declination_rad = f64::from(model.declination().get::<radian>());
        Ok(match world.north {
            North::True => Self {
                world_ut: DVec3::new(east, north, -down),
                declination_rad,
                true_north_rad: 0.0,
            },
            North::Magnetic => Self {
                world_ut: DVec3::new(0.0, north.hypot(east), -down),
                declination_rad,
                true_north_rad: declination_rad,
            },
        })
    }
}

/// The day of a decimal year; today without one.
fn date(year: Option<f64>) -> Result<Date, FieldError> {
    let Some(decimal) = year else { return today() };
    if !(1.0..9999.0).contains(&decimal) {
        return Err(FieldError::Year(decimal));
    }
    let whole = decimal.floor() as i32;
    let day = ((decimal - decimal.floor()) * f64::from(days_in_year(whole))) as u16;
    Date::from_ordinal_date(whole, day + 1).map_err(|_| FieldError::Year(decimal))
}

fn today() -> Result<Date, FieldError> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).map_err(|_| FieldError::Clock)?;
    let seconds = i64::try_from(since.as_secs()).map_err(|_| FieldError::Clock)?;
    OffsetDateTime::from_unix_timestamp(seconds)
        .map(OffsetDateTime::date)
        .map_err(|_| FieldError::Clock)
}

/// The field of a dipole that stands in W, µT: `µ₀/4π (3 (m·r̂) r̂ − m) / r³`. Within a decimetre of its
/// place, where no steel is a point, it is that of a decimetre.
pub(crate) fn steel_at(steel: &Steel, place: DVec3) -> DVec3 {
    const LEAST_M: f64 = 0.1;
    let moment = DVec3::from_array(steel.moment_a_m2);
    let r = place - DVec3::from_array(steel.position_m);
    let distance = r.length().max(LEAST_M);
    let n = r / distance;
    (n * (3.0 * moment.dot(n)) - moment) * (0.1 / distance.powi(3))
}

/// Time in which a disturbance comes up, and in which it fades, s.
const RAMP_S: f64 = 0.05;

/// The field a disturbance adds in W at a time, µT; zero outside of its span, blended at its ends.
pub(crate) fn disturbance_at(disturbance: &Disturbance, time_s: f64) -> DVec3 {
    let since = time_s - disturbance.at_s;
    let left = disturbance.duration_s - since;
    if since <= 0.0 || left <= 0.0 {
        return DVec3::ZERO;
    }
    let ramp = RAMP_S.min(0.5 * disturbance.duration_s);
    let envelope = Blend::at(since / ramp).value * Blend::at(left / ramp).value;
    let wave = if disturbance.frequency_hz == 0.0 {
        1.0
    } else {
        (std::f64::consts::TAU * disturbance.frequency_hz * since).sin()
    };
    DVec3::from_array(disturbance.field_ut) * (envelope * wave)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn garching(north: North) -> EarthField {
        EarthField::of(&World { north, year: Some(2026.0), ..World::default() }).unwrap()
    }

    #[test]
    fn garching_has_the_field_of_the_model() {
        let field = garching(North::True).world_ut;
        assert!((field.length() - 48.9).abs() < 0.3, "{}", field.length());
        let dip = (-field.z).atan2(field.x.hypot(field.y)).to_degrees();
        assert!((dip - 64.6).abs() < 0.4, "{dip}");
        let declination = field.x.atan2(field.y).to_degrees();
        assert!((declination - 4.3).abs() < 0.5, "{declination}");
    }

    #[test]
    fn magnetic_north_leaves_no_east_component() {
        let (magnetic, true_north) = (garching(North::Magnetic), garching(North::True));
        assert!(magnetic.world_ut.x.abs() < f64::EPSILON && magnetic.world_ut.y > 0.0);
        let turned = true_north.world_ut.rotate_z(magnetic.true_north_rad);
        assert!((turned - magnetic.world_ut).length() < 1e-4, "{turned}");
    }

    #[test]
    fn a_place_or_date_outside_of_the_model_is_refused() {
        for world in [
            World { latitude_deg: 91.0, year: Some(2026.0), ..World::default() },
            World { year: Some(1980.0), ..World::default() },
            World { year: Some(f64::NAN), ..World::default() },
        ] {
            let message = EarthField::of(&world).unwrap_err().to_string();
            assert!(message.contains("world"), "{message}");
        }
    }

    #[test]
    fn the_year_may_be_absent_and_its_ends_are_days() {
        assert!(EarthField::of(&World::default()).is_ok());
        assert_eq!(date(Some(2026.0)).unwrap().ordinal(), 1);
        assert_eq!(date(Some(2028.9999)).unwrap().ordinal(), 366);
    }

    #[test]
    fn a_disturbance_comes_and_goes_without_a_jump() {
        let hum = |frequency_hz| Disturbance {
            at_s: 1.0,
            duration_s: 2.0,
            field_ut: [10.0, -5.0, 3.0],
            frequency_hz,
        };
        let full = DVec3::new(10.0, -5.0, 3.0);
        assert_eq!(disturbance_at(&hum(0.0), 0.999), DVec3::ZERO);
        assert_eq!(disturbance_at(&hum(0.0), 3.001), DVec3::ZERO);
        assert!((disturbance_at(&hum(0.0), 2.0) - full).length() < 1e-12);
        assert!((disturbance_at(&hum(50.0), 2.005) - full).length() < 1e-9);
        let mut before = DVec3::ZERO;
        for k in 0..4000 {
            let now = disturbance_at(&hum(0.0), f64::from(k) * 1e-3);
            // The blend is steepest with 1.875 over its 50 ms.
            assert!((now - before).length() <= full.length() * 1.9 * 1e-3 / 0.05);
            before = now;
        }
    }
}
