//! From values to places along an axis, and where its ticks stand.

/// How values run along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Evenly, between two different values.
    Linear(f64, f64),
    /// By their logarithm, between two different values above zero.
    Log(f64, f64),
}

/// A mark on an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Where.
    pub value: f64,
    /// What stands there; empty for a line without a number.
    pub label: String,
}

impl Scale {
    /// Values that hold all given ones, with some air at both ends; −1 to 1 without any.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = extent(values).unwrap_or((-1.0, 1.0));
        let air = 0.06 * (high - low).max(1e-9 + 1e-6 * high.abs());
        Self::Linear(low - air, high + air)
    }

    /// Whole decades that hold all positive values; one decade about 1 without any.
    pub fn decades(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = extent(values.filter(|v| *v > 0.0)).unwrap_or((1.0, 1.0));
        let (low, high) = (low.log10().floor(), high.log10().ceil());
        Self::Log(10.0_f64.powf(low), 10.0_f64.powf(if high > low { high } else { low + 1.0 }))
    }

    /// Where a value lies: 0 at the beginning, 1 at the end.
    pub fn part(self, value: f64) -> f64 {
        match self {
            Self::Linear(low, high) => (value - low) / (high - low),
            Self::Log(low, high) => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Ticks: round numbers, at most about `count`; with a logarithmic scale every decade, and
    /// lines without numbers between.
    pub fn ticks(self, count: usize) -> Vec<Tick> {
        match self {
            Self::Linear(low, high) => linear_ticks(low, high, count),
            Self::Log(low, high) => log_ticks(low, high),
        }
    }
}

fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|v| v.is_finite()).fold(None, |extent: Option<(f64, f64)>, v| {
        Some(extent.map_or((v, v), |(low, high)| (low.min(v), high.max(v))))
    })
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<Tick> {
    let raw = (high - low) / count.max(1) as f64;
    let power = 10.0_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= raw * 0.999);
    let step = step.unwrap_or(10.0 * power);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    let tick = |k: i64| {
        let value = k as f64 * step;
        Tick { value, label: signed(value, decimals) }
    };
    (first..=last).map(tick).collect()
}

fn log_ticks(low: f64, high: f64) -> Vec<Tick> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let within = |value: f64| value > low * 0.999 && value < high * 1.001;
    let decade = |power: i32| {
        (1..10).map(move |m| {
            let value = f64::from(m) * 10.0_f64.powi(power);
            Tick { value, label: if m == 1 { power_of_ten(power) } else { String::new() } }
        })
    };
    (first..=last).flat_map(decade).filter(|tick| within(tick.value)).collect()
}

/// 0.01 to 1000 in figures, else 10⁻³.
fn power_of_ten(power: i32) -> String {
    if (-2..=3).contains(&power) {
        return format!("{}", 10.0_f64.powi(power));
    }
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit.to_digit(10).unwrap_or(0)).unwrap_or('?'),
    };
    format!("10{}", power.to_string().chars().map(raised).collect::<String>())
}

/// A number with a real minus sign.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    if is_zero { text.replace('-', "") } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(scale: Scale, count: usize) -> Vec<String> {
        scale.ticks(count).into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        assert_eq!(labels(Scale::Linear(-52.0, 52.0), 5), ["−50", "0", "50"]);
        assert_eq!(labels(Scale::Linear(0.0, 1.0), 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(
            labels(Scale::Linear(-0.03, 0.01), 4),
            ["−0.03", "−0.02", "−0.01", "0.00", "0.01"]
        );
    }

    #[test]
    fn decades_have_numbers_and_lines_between() {
        let scale = Scale::decades([0.004, 3.0].into_iter());
        assert_eq!(scale, Scale::Log(1e-3, 10.0));
        let ticks = scale.ticks(0);
        let numbered: Vec<&str> =
            ticks.iter().map(|t| t.label.as_str()).filter(|l| !l.is_empty()).collect();
        assert_eq!(numbered, ["10⁻³", "0.01", "0.1", "1", "10"]);
        assert_eq!(ticks.len(), 37);
        assert_eq!(power_of_ten(-14), "10⁻¹⁴");
    }

    #[test]
    fn no_values_and_equal_values_still_make_a_scale() {
        for scale in [Scale::around([].into_iter()), Scale::around([5.0, 5.0].into_iter())] {
            assert!(scale.part(5.0).is_finite() && !scale.ticks(5).is_empty(), "{scale:?}");
        }
        assert_eq!(Scale::decades([f64::NAN, -1.0].into_iter()), Scale::Log(1.0, 10.0));
    }

    proptest! {
        #[test]
        fn ticks_lie_on_the_axis_and_are_few(low in -1e6..1e6f64, span in 1e-6..1e6f64) {
            let scale = Scale::Linear(low, low + span);
            let ticks = scale.ticks(6);
            prop_assert!(ticks.len() <= 8);
            prop_assert!(ticks.iter().all(|t| (-1e-6..=1.0 + 1e-6).contains(&scale.part(t.value))));
        }
    }
}
