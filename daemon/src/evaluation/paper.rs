//! What the paper measured: its table "Stability of the Magnetometer", as printed.

use serde::Serialize;

/// One row of the paper's table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperRow {
    /// The place as the paper calls it.
    pub place: &'static str,
    /// `σ_nc`, uncalibrated, µT.
    pub sigma_nc_ut: f64,
    /// What stands behind its ±, µT.
    pub sigma_nc_pm_ut: f64,
    /// `σ_c`, calibrated, µT.
    pub sigma_c_ut: f64,
    /// What stands behind its ±, µT.
    pub sigma_c_pm_ut: f64,
    /// ε, percent.
    pub epsilon_percent: f64,
}

const fn row(place: &'static str, nc: (f64, f64), c: (f64, f64), epsilon_percent: f64) -> PaperRow {
    PaperRow {
        place,
        sigma_nc_ut: nc.0,
        sigma_nc_pm_ut: nc.1,
        sigma_c_ut: c.0,
        sigma_c_pm_ut: c.1,
        epsilon_percent,
    }
}

/// The rows by the name of the camera in the scenario that stands for them, in the paper's order.
pub const STABILITY: [(&str, PaperRow); 6] = [
    ("model", row("Model", (3.00, 12.86e-3), (2.05, 23.00e-3), 31.67)),
    ("lab", row("Lab", (0.99, 11.10e-3), (0.97, 8.09e-3), 2.51)),
    ("icev-centre", row("ICEV Centre", (1.29, 0.00e-3), (1.28, 10.83e-3), 0.35)),
    ("icev-front", row("ICEV Front", (6.72, 3.11e-3), (1.52, 11.48e-3), 77.50)),
    ("ev-centre", row("EV Centre", (2.56, 0.01e-3), (0.96, 15.39e-3), 62.53)),
    ("ev-front", row("EV Front", (1.89, 2.22e-16), (1.15, 10.16e-3), 39.27)),
];

/// The paper's row for a place, if it has one.
pub fn row_of(place: &str) -> Option<PaperRow> {
    STABILITY.iter().find(|(name, _)| *name == place).map(|(_, row)| *row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::statistics::improvement;

    #[test]
    fn the_printed_epsilon_follows_from_the_printed_sigmas() {
        for (name, row) in STABILITY {
            let epsilon = 100.0 * improvement(row.sigma_c_ut, row.sigma_nc_ut).unwrap();
            // Both are printed to 0.01 µT, which at 0.99 µT is a percent.
            let rounding = 100.0 * 0.01 / row.sigma_nc_ut;
            assert!((epsilon - row.epsilon_percent).abs() < rounding, "{name}: {epsilon}");
        }
    }

    #[test]
    fn every_embedded_scenario_has_its_row() {
        for ((name, _), (file, _)) in STABILITY.iter().zip(lodestone_config::STATIC_SCENARIOS) {
            assert_eq!(format!("{name}.toml"), file);
        }
        assert_eq!(row_of("cellar"), None);
    }
}
