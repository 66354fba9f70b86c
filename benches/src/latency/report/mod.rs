//! What is reported: medians over the rounds with their smallest and largest, and what is rare from all
//! rounds together.

mod markdown;
mod page;
mod summary;
mod text;

pub use markdown::markdown;
pub use page::page;
pub(super) use summary::REAL_TIME;
pub use summary::{Figure, Line, Spread, Summary, p50_us, p99_us};
pub use text::text;

/// µs with three figures that count; `-` if unknown.
fn micros(us: Option<f64>) -> String {
    us.map_or_else(|| "-".into(), three_figures)
}

/// A number with about three figures.
fn three_figures(value: f64) -> String {
    match value.abs() {
        100.0.. => format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

/// `1.23 (1.20 to 1.31)`.
fn with_spread(spread: Option<Spread>) -> String {
    spread.map_or_else(
        || "-".into(),
        |s| {
            let [median, smallest, largest] = [s.median, s.smallest, s.largest].map(three_figures);
            format!("{median} ({smallest} to {largest})")
        },
    )
}

fn yes_or_no(met: bool) -> &'static str {
    if met { "yes" } else { "no" }
}
