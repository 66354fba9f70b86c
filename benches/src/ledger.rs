//! Times of several subjects in one run, and their ratios.

use std::cell::RefCell;
use std::time::Duration;

/// Nanoseconds per operation, by subject.
#[derive(Debug, Default)]
pub struct Ledger {
    entries: RefCell<Vec<(String, Vec<f64>)>>,
}

impl Ledger {
    /// Adds a measurement of `operations` operations.
    pub fn add(&self, subject: &str, total: Duration, operations: u64) {
        let nanos = total.as_secs_f64() * 1e9 / operations as f64;
        let mut entries = self.entries.borrow_mut();
        match entries.iter_mut().find(|(name, _)| name == subject) {
            Some((_, times)) => times.push(nanos),
            None => entries.push((subject.into(), vec![nanos])),
        }
    }

    /// Prints the median of each subject and its ratio to the median of `peer`.
    pub fn print_ratios(&self, peer: &str) {
        let entries = self.entries.borrow();
        let of = |name: &str| entries.iter().find(|(n, _)| n == name).map(|(_, t)| median(t));
        println!("\n{:<38} {:>12} {:>8}", "median", "ns", "ratio");
        for (name, times) in entries.iter() {
            let time = median(times);
            let ratio = of(peer).map_or_else(|| "-".into(), |p| format!("{:.2}", time / p));
            println!("{name:<38} {time:>12.1} {ratio:>8}");
        }
    }
}

/// The middle of some numbers; NaN of none.
pub fn median(numbers: &[f64]) -> f64 {
    quantile(numbers, 0.5)
}

/// The number below which the share `p` of the numbers lies (nearest rank); NaN of none.
fn quantile(numbers: &[f64], p: f64) -> f64 {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let rank = (p * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_ranks() {
        let numbers: Vec<f64> = (1..=100).rev().map(f64::from).collect();
        for (p, expected) in [(0.5, 50.0), (0.99, 99.0), (1.0, 100.0), (0.0, 1.0)] {
            assert!((quantile(&numbers, p) - expected).abs() < f64::EPSILON, "{p}");
        }
        assert!(median(&[]).is_nan());
    }
}
