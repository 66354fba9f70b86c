//! The stairs in numbers: where they end, and how right the orientation is.

use super::super::page::{beside, cells, paragraph, table};
use super::super::scale::signed;
use super::format::{length, lengths, numbers};
use super::method::{emphasis, name};
use crate::evaluation::dynamic::DynamicResult;
use crate::evaluation::dynamic::method::Method;
use crate::evaluation::dynamic::stairs::{Stairs, StairsScore};

const HEAD: &str = "<tr><th class=\"text\">Stairs</th><th>position, RMS error</th><th>at the end</th><th>of it \
    height</th><th class=\"roll\">roll RMS, °</th><th class=\"pitch\">pitch RMS, °</th><th \
    class=\"yaw\">yaw RMS, °</th></tr>\n";

/// The table of both walks.
pub(super) fn scores(result: &DynamicResult) -> String {
    let walk = |heading: &str, stairs: &Stairs| {
        let title = format!("<tr><th class=\"text\" colspan=\"7\">{heading}</th></tr>\n");
        title + &stairs.methods.iter().map(row).collect::<String>()
    };
    let rows = walk("Walking on over the landings, a rest at the top", &result.stairs)
        + &walk("Halting for two seconds on every landing", &result.stairs_halting);
    table(HEAD, &rows)
        + &paragraph(&format!(
            "<span class=\"note\">Medians over {} runs; small: what eight of ten lie between.</span>",
            result.runs
        ))
}

fn row(score: &StairsScore) -> String {
    let best = emphasis(score.method);
    let mut figures =
        vec![lengths(&score.rms_m), lengths(&score.end_m), lengths(&score.end_height_m)];
    figures.extend(score.orientation_rms_deg.iter().map(|q| numbers(q, 2)));
    let cells = cells("td", best, figures);
    format!("<tr><th scope=\"row\">{}</th>{cells}</tr>\n", name(score.method))
}

/// The paper's trajectory beside ours.
pub(super) fn compared(result: &DynamicResult) -> String {
    let rms = |stairs: &Stairs, method| {
        let score = stairs.of_method(method);
        score.map_or_else(|| "–".to_owned(), |score| length(score.rms_m.median))
    };
    let steps = Method::ALL.into_iter().filter(|method| *method != Method::LowPassed);
    let steps: Vec<String> = steps.map(|method| rms(&result.stairs, method)).collect();
    let steps = steps.join(" → ");
    beside(
        "One section of a walk on stairs, red dots and black arrows, without a truth, a scale or numbers. It \
         “shows inaccuracies of sensor orientation (black arrows)”.",
        &format!(
            "The whole walk against the truth. Position, RMS, median: raw → offset-corrected → Lodestone on \
             its own → with standstills → calibrated {steps}; where the walker halts on each landing {}.",
            rms(&result.stairs_halting, Method::LodestoneCalibrated)
        ),
        "Our offset-corrected arrows are right and its dots are not: over a minute the orientation is the \
         easy part. Lodestone on its own drifts as well; what brings it back are standstills, which it finds by \
         itself. A calibration of the unit helps the orientation more than the position. No aid of this page comes from the truth.",
        "Where the walker turns round, an accelerometer’s offset that rest had hidden in the tilt turns with \
         the camera, and counts twice. A standstill tells the velocity again, and through it the tilt; \
         without one the error of a tilt of 0.2° is 0.034 m/s², half a metre after 5 s and seven after 20 s.",
    )
}

const SWING_HEAD: &str = "<tr><th class=\"text\" rowspan=\"2\">Swing on the first flight</th>\
    <th class=\"group\" colspan=\"3\">explained by the stride, %</th>\
    <th class=\"group\" colspan=\"3\">amplitude, °</th></tr>\n\
    <tr><th class=\"roll\">roll</th><th class=\"pitch\">pitch</th><th class=\"yaw\">yaw</th>\
    <th class=\"roll\">roll, stride</th><th class=\"pitch\">pitch, step</th>\
    <th class=\"yaw\">yaw, stride</th></tr>\n";

/// How harmonic each method's orientation is, beside the truth's.
pub(super) fn swings(stairs: &Stairs) -> String {
    let row = |name: &str, explained: [f64; 3], swing: [f64; 3]| {
        let parts = explained.map(|part| signed(100.0 * part, 1)).into_iter();
        let cells = cells("td", "", parts.chain(swing.map(|deg| signed(deg, 2))));
        format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>\n")
    };
    let medians = |q: [crate::evaluation::statistics::Quantiles; 3]| q.map(|q| q.median);
    let mut rows = row("truth", medians(stairs.true_explained), medians(stairs.true_swing_deg));
    for score in &stairs.methods {
        rows += &row(name(score.method), medians(score.explained), medians(score.swing_deg));
    }
    table(SWING_HEAD, &rows)
}

/// The paper's "non-harmonic progression" beside ours.
pub(super) fn harmony(stairs: &Stairs) -> String {
    let roll = |method| {
        let score = stairs.of_method(method);
        score.map_or(f64::NAN, |score| 100.0 * score.explained[0].median)
    };
    beside(
        "“We expect that the human sinusoidal oscillation leads to a harmonic behaviour of the sensor \
         alignment. However, our results show a non-harmonic progression. The orientation inaccuracies \
         result from noise behaviour and sensitivity of the measured angular velocity.”",
        &format!(
            "The stride explains {} % of the true roll, {} % of Lodestone’s and {} % of the raw \
             integral’s.",
            signed(100.0 * stairs.true_explained[0].median, 1),
            signed(roll(Method::Lodestone), 1),
            signed(roll(Method::Raw), 1)
        ),
        "Filtered or not, the estimate is as harmonic as the truth; the raw one lies on a drift of some \
         degrees. The low-pass makes orientation worse, not better: it delays it, here by 22 ms.",
        "At the noise that the maker states, a stride’s integral of the gyroscope is noisy by a \
         hundredth of a degree, against a swing of three. So noise does not explain the paper’s result; an \
         offset, or a walker who looks about as real ones do, would. Our walker swings harmonically by \
         construction, with a slow look about; that the estimate keeps it is the finding, not that it is \
         there.",
    )
}
