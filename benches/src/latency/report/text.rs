//! For the terminal.

use lodestone_client::latency::Stage;

use super::summary::{Line, Summary};
use super::{micros, three_figures, with_spread, yes_or_no};

/// Everything as lines.
pub fn text(summary: &Summary) -> String {
    let mut lines = vec![
        summary.machine.told(),
        format!(
            "{} rounds of {} s each, order from seed {}; lanes {}",
            summary.rounds,
            summary.seconds,
            summary.seed,
            match summary.real_time {
                Some(true) => "with SCHED_FIFO",
                Some(false) => "without real-time priority",
                None => "not measured",
            }
        ),
    ];
    lines.extend(summary.machine.warnings().iter().map(|warning| format!("  ! {warning}")));
    lines.extend(latencies(summary));
    lines.extend(figures(summary));
    lines.extend(targets(summary));
    lines.join("\n")
}

fn latencies(summary: &Summary) -> Vec<String> {
    let head =
        ["subject", "stage", "p50 (rounds)", "p99 (rounds)", "p99.9", "p99.99", "max", "max, gaps"];
    let mut lines = vec![String::new(), row(head.map(str::to_owned)) + "   µs"];
    for line in &summary.lines {
        lines.push(row(cells(line)));
    }
    lines.push(String::new());
    for tally in &summary.counted {
        let told = tally.counted.told().join(", ");
        lines.push(format!("{:<20} {} measured; {told}", tally.subject, tally.counted.measured));
    }
    lines
}

fn cells(line: &Line) -> [String; 8] {
    let stage = Stage::ALL.into_iter().find(|stage| stage.key() == line.stage);
    let us = |ns: Option<u64>| micros(ns.map(|ns| ns as f64 * 1e-3));
    [
        line.name.clone(),
        stage.map_or("", Stage::name).into(),
        with_spread(line.p50_us),
        with_spread(line.p99_us),
        us(line.together.p99_9_ns),
        us(line.together.p99_99_ns),
        us(line.together.max_ns),
        us(line.together_with_gaps.max_ns),
    ]
}

fn row(cells: [String; 8]) -> String {
    let [subject, stage, p50, p99, rest @ ..] = cells;
    let rest: Vec<String> = rest.iter().map(|cell| format!(" {cell:>9}")).collect();
    format!("{subject:<36} {stage:<22} {p50:>24} {p99:>24}{}", rest.concat())
}

fn figures(summary: &Summary) -> Vec<String> {
    let line = |f: &super::Figure| {
        format!("{:<36} {:<30} {:>24}", f.name, f.what, with_spread(Some(f.found)))
    };
    [String::new()].into_iter().chain(summary.figures.iter().map(line)).collect()
}

fn targets(summary: &Summary) -> Vec<String> {
    let line = |t: &super::super::target::Target| {
        let limit = three_figures(t.limit);
        let found = with_spread(Some(t.found));
        format!("{:<68} ≤ {limit:<6} {found:>24}  {}", t.promise, yes_or_no(t.met))
    };
    [String::new()].into_iter().chain(summary.targets.iter().map(line)).collect()
}
