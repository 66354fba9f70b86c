//! Every key of a calibration file.

use super::Kind::{Covariance, Date, Number, SoftIron, Text, Vector, Whole};
use super::range::{from_to, plus_minus};
use super::text::Text::Description;
use super::{Key, Schema, Section, Shape, key};

/// The calibration file.
pub(crate) static CALIBRATION: Schema = Schema {
    sections: &[
        Section {
            path: "",
            shape: Shape::Root,
            meaning: "Which camera was calibrated, when, and as what. All vectors are in the \
                      sensor's own axes, before the axis map.",
            keys: ROOT,
        },
        Section {
            path: "temperature",
            shape: Shape::Optional,
            meaning: "Range of the sensor's temperature during the calibration.",
            keys: TEMPERATURE,
        },
        Section {
            path: "magnetometer",
            shape: Shape::Optional,
            meaning: "B = C (reading − b0 − b1 (T − T0)).",
            keys: MAGNETOMETER,
        },
        Section {
            path: "gyro",
            shape: Shape::Optional,
            meaning: "rate = reading − bias − slope (T − T0).",
            keys: GYRO,
        },
        Section {
            path: "accelerometer",
            shape: Shape::Optional,
            meaning: "specific force = reading − bias.",
            keys: ACCELEROMETER,
        },
    ],
};

const ROOT: &[Key] = &[
    key("serial", Whole(1, i64::MAX), "", "Serial number of the camera.").required(),
    key("date", Date, "", "Day of the calibration.").required(),
    key(
        "mounting",
        Text(Description),
        "",
        "How the camera was mounted: the magnetometer's part holds for this mounting alone.",
    ),
];

const TEMPERATURE: &[Key] = &[
    key("min_c", Number(from_to(-40.0, 85.0)), "°C", "Lowest temperature.").required(),
    key("max_c", Number(from_to(-40.0, 85.0)), "°C", "Highest temperature.").required(),
];

const MAGNETOMETER: &[Key] = &[
    key("hard_iron_ut", Vector(plus_minus(1000.0)), "µT", "Hard iron b0.").required(),
    key(
        "hard_iron_slope_ut_k",
        Vector(plus_minus(10.0)),
        "µT/K",
        "Change of the hard iron per kelvin, b1.",
    ),
    key(
        "reference_temperature_c",
        Number(from_to(-40.0, 85.0)),
        "°C",
        "Temperature T0 at which the hard iron is b0.",
    ),
    key("soft_iron", SoftIron(plus_minus(10.0)), "", "Correction of soft iron C, row by row.")
        .required(),
    key(
        "heading_sigma_deg",
        Number(from_to(0.0, 180.0)),
        "°",
        "Standard deviation of the heading that this calibration leaves, over the tilts it was \
         made with and all headings.",
    ),
    key(
        "level_heading_sigma_deg",
        Number(from_to(0.0, 180.0)),
        "°",
        "The same for a level camera.",
    ),
    key(
        "residual_ut",
        Number(from_to(0.0, 1000.0)),
        "µT",
        "What the calibration left of one reading, per axis.",
    ),
    key("field_ut", Number(from_to(0.0, 1000.0)), "µT", "Strength of the earth's field as found."),
    key("field_sigma_ut", Number(from_to(0.0, 1000.0)), "µT", "Its standard deviation."),
    key("dip_deg", Number(plus_minus(90.0)), "°", "Dip of the earth's field, positive downward."),
    key("dip_sigma_deg", Number(from_to(0.0, 180.0)), "°", "Its standard deviation."),
    key(
        "covariance",
        Covariance,
        "",
        "Covariance of C row by row, b0 and, where it was found, b1.",
    ),
];

const GYRO: &[Key] = &[
    key("bias_rad_s", Vector(plus_minus(1.0)), "rad/s", "What the gyroscope reads at rest, at T0.")
        .required(),
    key("bias_sigma_rad_s", Vector(from_to(0.0, 1.0)), "rad/s", "Its standard deviation."),
    key(
        "bias_slope_rad_s_k",
        Vector(plus_minus(0.1)),
        "rad/s/K",
        "Change of the bias per kelvin; not applied if absent.",
    ),
    key(
        "reference_temperature_c",
        Number(from_to(-40.0, 85.0)),
        "°C",
        "Temperature T0 of bias and slope.",
    ),
];

const ACCELEROMETER: &[Key] = &[
    key(
        "bias_m_s2",
        Vector(plus_minus(10.0)),
        "m/s²",
        "What the accelerometer reads above the true specific force.",
    )
    .required(),
    key(
        "bias_sigma_m_s2",
        Vector(from_to(0.0, 10.0)),
        "m/s²",
        "Its standard deviation; large along a direction that the movement did not show.",
    ),
];
