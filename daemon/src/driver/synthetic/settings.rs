//! Settings without which the simulated world has no meaning.

use lodestone_config::model::Synthetic;
use thiserror::Error;

/// A setting of the synthetic camera that has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error("camera.synthetic.{key} is {value}; allowed is {allowed}")]
pub struct SettingError {
    /// Key below `camera.synthetic`.
    pub key: &'static str,
    /// What it is.
    pub value: f64,
    /// What it may be.
    pub allowed: &'static str,
}

/// Checks what the simulation itself depends on; sensible ranges are the configuration's to check.
pub(crate) fn check(synthetic: &Synthetic) -> Result<(), SettingError> {
    const NOT_NEGATIVE: &str = "a finite number, 0 or more";
    let (errors, transport) = (&synthetic.errors, &synthetic.transport);
    for (key, value) in [
        ("rest_s", synthetic.rest_s),
        ("speed", synthetic.speed),
        ("duration_s", synthetic.duration_s),
        ("errors.noise_scale", errors.noise_scale),
        ("errors.mag_flicker_ut_rthz", errors.mag_flicker_ut_rthz),
        ("transport.sampling_jitter_s", transport.sampling_jitter_s),
        ("transport.arrival_delay_s", transport.arrival_delay_s),
    ] {
        require(key, value, value.is_finite() && value >= 0.0, NOT_NEGATIVE)?;
    }
    let lost = transport.drop_probability;
    require("transport.drop_probability", lost, (0.0..=1.0).contains(&lost), "0 to 1")?;
    for (key, value) in [
        ("transport.rate_error", transport.rate_error),
        ("transport.clock_error", transport.clock_error),
    ] {
        require(key, value, value.abs() <= 0.5, "-0.5 to 0.5")?;
    }
    let every = transport.mag_every;
    require("transport.mag_every", f64::from(every), every > 0, "1 or more")
}

fn require(
    key: &'static str,
    value: f64,
    holds: bool,
    allowed: &'static str,
) -> Result<(), SettingError> {
    if holds { Ok(()) } else { Err(SettingError { key, value, allowed }) }
}
