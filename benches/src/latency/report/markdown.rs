//! For the README.

use lodestone_client::latency::Stage;

use super::summary::Summary;
use super::{micros, three_figures, with_spread, yes_or_no};

/// Tables of the whole ways and of the promises.
pub fn markdown(summary: &Summary) -> String {
    let machine = summary.machine.told();
    let real_time =
        if summary.real_time == Some(true) { "SCHED_FIFO" } else { "ordinary priority" };
    let mut lines = vec![
        format!(
            "{machine}; {} rounds of {} s, {real_time}; medians over the rounds (smallest to largest), \
             the rest of all rounds together; without samples that crossed a gap.",
            summary.rounds, summary.seconds
        ),
        String::new(),
        "| from arrival, or from publishing, to seen, µs | p50 | p99 | p99.9 | p99.99 | max |"
            .into(),
        "|---|---|---|---|---|---|".into(),
    ];
    let us = |ns: Option<u64>| micros(ns.map(|ns| ns as f64 * 1e-3));
    for line in summary.lines.iter().filter(|line| line.stage == Stage::ArrivalToSeen.key()) {
        lines.push(format!(
            "| {} | {} | {} | {} | {} | {} |",
            line.name,
            with_spread(line.p50_us),
            with_spread(line.p99_us),
            us(line.together.p99_9_ns),
            us(line.together.p99_99_ns),
            us(line.together.max_ns),
        ));
    }
    lines.extend([
        String::new(),
        "| promise | at most | found | met |".into(),
        "|---|---|---|---|".into(),
    ]);
    for target in &summary.targets {
        lines.push(format!(
            "| {} | {} | {} | {} |",
            target.promise,
            three_figures(target.limit),
            with_spread(Some(target.found)),
            yes_or_no(target.met)
        ));
    }
    lines.join("\n")
}
