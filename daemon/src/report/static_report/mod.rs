//! The static part of the report.
//!
//! A reader of the paper finds its figure "Calibration of the Magnetic Field Sensor" and its table
//! "Stability of the Magnetometer" again, ours beside the paper's where it gives numbers.

mod comparison;
mod notes;
mod place;
mod rest;
mod table;

pub use table::text as text_table;

use serde::Serialize;

use super::page::{paragraph, section};
use super::scale::signed;
use crate::evaluation::rest::Rest;
use crate::evaluation::static_places::{FRESH_RECORDINGS, PlaceResult};
use crate::evaluation::statistics::Spread;

/// Everything that a static evaluation found.
#[derive(Clone, Debug, Serialize)]
pub struct StaticReport {
    /// Fresh recordings behind every figure with a ±.
    pub fresh_recordings: u32,
    /// The table, row by row.
    pub places: Vec<PlaceResult>,
    /// Noise of the inertial sensors at rest.
    pub rest: Rest,
}

impl StaticReport {
    /// The report of these places.
    pub const fn new(places: Vec<PlaceResult>, rest: Rest) -> Self {
        Self { fresh_recordings: FRESH_RECORDINGS, places, rest }
    }

    /// The paper's figure and table as sections of a page.
    pub fn sections(&self) -> String {
        self.calibration()
            + &section("stability", "Stability of the magnetometer", &self.stability())
    }

    /// What goes beyond the paper: each place by itself, and the noise of the inertial sensors.
    pub fn appendix(&self) -> String {
        let intro = paragraph(
            "Each place by itself: the field before and after calibration, what is left of its strength, the \
             heading’s error, and what was assumed.",
        );
        let places: String = self.places.iter().map(place::section_of).collect();
        section("places", "Place by place", &intro)
            + &places
            + &section("rest", "Allan deviation at rest", &rest::markup(&self.rest))
    }

    /// How the numbers came about.
    pub fn method(&self) -> String {
        notes::method(self)
    }

    /// The paper's figure of the calibration, at the first place.
    fn calibration(&self) -> String {
        let Some(first) = self.places.first() else { return String::new() };
        let body = place::spheres(first) + &notes::calibration_beside(first);
        section("calibration", "Calibration of the magnetic field sensor", &body)
    }

    fn stability(&self) -> String {
        let refused = self.places.iter().filter(|p| p.calibrated.is_none()).count();
        let mut markup = paragraph(
            "σ is the standard deviation of the field’s strength |B| while the camera is turned: a \
             perfect magnetometer in the earth’s uniform field reads one strength in every direction. \
             σ<sub>nc</sub> is the sensor as it comes, σ<sub>c</sub> the same readings after \
             calibration, ε = 1 − σ<sub>c</sub>/σ<sub>nc</sub>. ± is the standard deviation from one \
             fresh recording to the next.",
        );
        markup += &table::markup(&self.places);
        if refused > 0 {
            markup += &paragraph(
                "<span class=\"warn\">Refused</span>: the recording could not tell what a calibration \
                 must know; the section of the place says what is missing. No σ<sub>c</sub> is given \
                 then.",
            );
        }
        markup
            + &comparison::figure_of(&self.places)
            + &notes::stability_beside(&self.places)
            + &notes::comparable()
    }
}

/// `1.23 ± 0.04` as markup.
fn spread(spread: Spread, decimals: usize) -> String {
    let mean = signed(spread.mean, decimals);
    match spread.deviation {
        Some(deviation) => format!("{mean} <small>± {}</small>", signed(deviation, decimals)),
        None => mean,
    }
}

/// How a place is called: as in the paper where it has a row there, else by its camera's name.
fn title(result: &PlaceResult) -> &str {
    result.paper.map_or(result.name.as_str(), |row| row.place)
}
