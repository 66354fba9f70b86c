//! The dynamic tables for a terminal.

use super::method::name;
use crate::evaluation::dynamic::DynamicResult;
use crate::evaluation::dynamic::drift::{Drift, TABLE_S};
use crate::evaluation::dynamic::method::Method;
use crate::evaluation::dynamic::stairs::Stairs;

/// Rows of cells, the first of each to the left, the others to the right.
fn lined_up(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
    };
    let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let padded = |(column, cell): (usize, &String)| {
            let gap = " ".repeat(widths[column] - cell.chars().count());
            if column == 0 { format!("{cell}{gap}") } else { format!("  {gap}{cell}") }
        };
        let line: String = row.iter().enumerate().map(padded).collect();
        format!("{}\n", line.trim_end())
    };
    rows.iter().map(line).collect()
}

/// Both tables.
pub(in crate::report) fn tables(result: &DynamicResult) -> String {
    drift(&result.at_rest, "at rest")
        + "\n"
        + &drift(&result.in_motion, "carried through a room")
        + "\n"
        + &stairs(result)
        + &recordings(result)
}

/// Nothing where no recording was given.
fn recordings(result: &DynamicResult) -> String {
    if result.recordings.is_empty() {
        return String::new();
    }
    let head = ["recording", "total °", "heading °", "inclination °", "RMS m", "end m"];
    let mut rows = vec![head.map(String::from).to_vec()];
    for recorded in &result.recordings {
        let angles = recorded.orientation.as_ref().map(|o| {
            [o.total_deg, o.heading_deg, o.inclination_deg].map(|deg| format!("{deg:.2}"))
        });
        let metres = recorded.position.as_ref().map(|p| [p.rms_m, p.end_m].map(metres));
        let mut row = vec![recorded.name.clone()];
        row.extend(angles.unwrap_or_else(|| ["-", "-", "-"].map(String::from)));
        row.extend(metres.unwrap_or_else(|| ["-", "-"].map(String::from)));
        rows.push(row);
    }
    format!("\n{}", lined_up(&rows))
}

fn drift(drift: &Drift, scene: &str) -> String {
    let mut head = vec![format!("position error, m: {scene}")];
    head.extend(TABLE_S.map(|time_s| format!("{time_s} s")));
    let mut rows = vec![head];
    for method in &drift.methods {
        let mut row = vec![name(method.method).to_owned()];
        row.extend(method.table.iter().map(|p| metres(p.error_m.median)));
        rows.push(row);
    }
    lined_up(&rows)
}

fn stairs(result: &DynamicResult) -> String {
    let head = ["stairs", "RMS m", "end m", "roll °", "pitch °", "yaw °"];
    let mut rows = vec![head.map(String::from).to_vec()];
    let mut add = |label: &str, stairs: &Stairs, method: Method| {
        let Some(score) = stairs.of_method(method) else { return };
        let mut row =
            vec![label.to_owned(), metres(score.rms_m.median), metres(score.end_m.median)];
        row.extend(score.orientation_rms_deg.iter().map(|q| format!("{:.2}", q.median)));
        rows.push(row);
    };
    for method in Method::ALL {
        add(name(method), &result.stairs, method);
    }
    let halting = &result.stairs_halting;
    add("Lodestone, halts on landings", halting, Method::Lodestone);
    add("calibrated, halts on landings", halting, Method::LodestoneCalibrated);
    lined_up(&rows) + &format!("medians of {} runs\n", result.runs)
}

/// A length with about three digits.
fn metres(value: f64) -> String {
    let decimals = if value < 0.1 {
        4
    } else if value < 10.0 {
        2
    } else {
        0
    };
    format!("{value:.decimals$}")
}
