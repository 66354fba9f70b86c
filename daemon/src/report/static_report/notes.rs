//! What the numbers mean, in words.

use super::super::page::{beside, list, paragraph};
use super::super::scale::signed;
use super::super::svg::Escaped;
use super::{StaticReport, title};
use crate::evaluation::static_places::PlaceResult;

/// The paper's figure of the calibration beside ours.
pub(super) fn calibration_beside(result: &PlaceResult) -> String {
    let name = Escaped(title(result));
    let ours = match result.calibrated {
        Some(after) => format!(
            "The same at “{name}”, on a recording that the calibration has not seen: σ of the strength falls \
             from {} to {} µT.",
            signed(result.uncalibrated.sigma_ut.mean, 2),
            signed(after.sigma_ut.mean, 2)
        ),
        None => format!("At “{name}” the calibration was refused; the reason is below."),
    };
    beside(
        "Readings of a turned ZED 2, coloured by the axis of rotation: shifted and unlike before calibration, \
         on circles about the origin after it.",
        &ours,
        "Each picture is one plane, with the earth’s true field dashed, so that a wrong radius shows as well \
         as a wrong centre.",
        "In a synthetic world the true field is known; the paper could only look at the shape.",
    )
}

/// The paper's table beside ours; nothing where no place has a row in it.
pub(super) fn stability_beside(places: &[PlaceResult]) -> String {
    let pairs = places.iter().filter_map(|place| Some((place.paper?, place.calibrated?)));
    let lower = pairs.clone().filter(|(paper, ours)| ours.sigma_ut.mean < paper.sigma_c_ut).count();
    let count = pairs.count();
    if count == 0 {
        return String::new();
    }
    beside(
        "One camera in real rooms and cars; σ before and after, and ε, with a ± that is not explained.",
        "The same table in simulated places, each calibration judged on fresh recordings, with the heading’s \
         error, which the paper could not know.",
        &format!(
            "Our σ<sub>c</sub> is the lower one at {lower} of {count} places. That our σ<sub>nc</sub> is like \
             the paper’s is no finding."
        ),
        "Our places are assumptions: hard iron as large as the paper’s σ<sub>nc</sub> asks for. What is left \
         is the noise, motors and instruments that were assumed, and no more.",
    )
}

/// What compares with the paper, and what does not.
pub(super) fn comparable() -> String {
    let intro =
        "<h3 id=\"compares\">What compares with the paper, and what does not</h3>\n".to_owned();
    let intro = intro
        + &paragraph(
            "The paper measured one ZED 2 in real rooms and cars. Here the camera and the places are \
         simulated, and the fields of the places are assumptions, listed with each place. Therefore:",
        );
    let items = [
        "<b>Compares:</b> the method (turn the camera, fit hard and soft iron, look at the strength of \
         the field before and after), the shape of the figures, and the order of magnitude of what a \
         calibration leaves.",
        "<b>Does not compare:</b> any single number. The hard iron was chosen so that σ<sub>nc</sub> has \
         the size of the paper’s, so the agreement of that column is no finding, and with it neither is \
         that of ε. What is left after calibration was not fitted to the paper’s σ<sub>c</sub>; it \
         follows from the noise, motors and instruments that were assumed.",
        "<b>Two assumptions of the embedded places were changed after first results.</b> The 1/f noise \
         went from 0.1 to 0.03 µT/√Hz at 1 Hz, a guess in place of a guess: with 0.1, σ<sub>c</sub> is \
         0.63 to 1.07 µT instead of 0.51 to 1.01, and the lab’s ε 28 to 41 % instead of 45 to 48 %. And \
         cars circle to both sides instead of one, because one-sided circles turned the calibrated heading \
         by more than a degree. Both make ours look better.",
        "<b>ε rewards a bad start.</b> The more hard iron, the higher ε, with the same σ<sub>c</sub>. \
         The paper’s highest ε, at ICEV Front, goes with its highest σ<sub>nc</sub>.",
        "<b>σ of the strength is no proof of a heading.</b> In a car, which tilts by a few degrees, a fit \
         to the strength alone can leave σ = 0.28 µT and be wrong by 8° in heading: many ellipsoids \
         pass through one ring of readings. So the table has a heading column, and Lodestone’s \
         calibration fits gyroscope and accelerometer along with the field, states the heading error \
         that it expects, and refuses a recording that cannot tell.",
        "<b>Movement:</b> the paper calls this evaluation stationary, and colours its table’s pictures by \
         the direction of rotation. A camera that only stands shows nothing of hard and soft iron, so σ is taken while it \
         turns; σ at rest stands with each place.",
        "<b>The ±</b> of the paper is not explained there; ours is the standard deviation over fresh \
         recordings.",
        "<b>Frames:</b> the paper calls the rotation about y yaw and that about z pitch. Here roll is \
         about forward, pitch about left, yaw about up; red, green and blue go with these words.",
    ];
    intro + &list(&items.map(String::from))
}

/// How the numbers came about.
pub(super) fn method(report: &StaticReport) -> String {
    let fresh = report.fresh_recordings;
    list(&[
        "At each place one recording is made to calibrate from, with its own seed. The calibration is \
         that of <code>lodestoned calibrate</code>. It sees what a sensor says, the sensor’s noise \
         figures, which way it is mounted and, as a rough guess, the earth’s field by the World Magnetic \
         Model; nothing of the truth."
            .into(),
        format!(
            "It is judged on {fresh} fresh recordings of the same place, with other seeds: other noise, \
             other movement, motors and instruments at another point of their cycle. σ, ε and heading \
             error are taken from each and averaged."
        ),
        "The heading error of a reading is the angle between its horizontal part and the true field’s, \
         turned by the true attitude: the magnetometer’s own part of a heading’s error. The truth is used \
         for this score alone."
            .into(),
        "The heading error that a calibration expects of itself rests on noise that is independent from \
         reading to reading. Slow drift, and devices that switch while the camera turns, come on top; the \
         lasting error beside it shows by how much."
            .into(),
        "A car that circles is pressed outward, which looks like a tilt. All to one side that turns the \
         heading by a degree and more, so the car circles to both sides."
            .into(),
        "Calibrated field: B = C (B̃ − b₀ − b₁ (T − T₀)), the paper’s equation of hard and soft iron with \
         its temperature term apart."
            .into(),
        "Motors and instruments are fixed to the vehicle like hard iron, but change in time; readings are \
         point samples at 50 Hz, so a motor’s field is aliased, as in a sensor without a filter. 1/f noise \
         is a sum of Gauss-Markov processes an octave apart (van der Ziel 1950; Milotti, \
         arXiv:physics/0204033)."
            .into(),
    ])
}
