//! The paper's table, ours beside it: for the page and for the terminal.

use super::super::scale::signed;
use super::super::svg::Escaped;
use super::{place, spread, title};
use crate::evaluation::static_places::PlaceResult;

const HEAD: &str = "<thead>\n\
    <tr><th class=\"text\" rowspan=\"2\">Place</th>\
    <th class=\"group\" colspan=\"2\">σ<sub>nc</sub> uncalibrated, µT</th>\
    <th class=\"group\" colspan=\"2\">σ<sub>c</sub> calibrated, µT</th>\
    <th class=\"group\" colspan=\"2\">ε, %</th>\
    <th class=\"group\" colspan=\"2\">heading RMS error, °</th>\
    <th class=\"thumb\" rowspan=\"2\">Uncalibrated</th><th class=\"thumb\" rowspan=\"2\">Calibrated</th></tr>\n\
    <tr><th>ours</th><th class=\"paper\">paper</th><th>ours</th><th class=\"paper\">paper</th>\
    <th>ours</th><th class=\"paper\">paper</th><th>before</th><th>after</th></tr>\n</thead>\n";

/// The table as markup.
pub(super) fn markup(places: &[PlaceResult]) -> String {
    let rows: String = places.iter().map(row).collect();
    format!(
        "<figure>\n<div class=\"scroll\">\n<table>\n{HEAD}<tbody>\n{rows}</tbody>\n</table>\n</div>\n\
         <figcaption><b>The paper’s table “Stability of the Magnetometer”.</b> ICEV: car with \
         combustion engine; EV: electric car. Ours is simulated, the paper’s was measured; <a \
         href=\"#compares\">what that means</a>. Heading errors are ours alone: they need the truth, \
         which the paper did not have. The small pictures stand for the paper’s last two columns: \
         the field seen along the <span class=\"roll\">roll</span>, <span class=\"pitch\">pitch</span> \
         and <span class=\"yaw\">yaw</span> axis, laid over each other, within the circle of the \
         earth’s field.</figcaption>\n</figure>\n"
    )
}

fn row(result: &PlaceResult) -> String {
    let name = Escaped(title(result));
    let (before, after, paper) = (&result.uncalibrated, &result.calibrated, &result.paper);
    let refused = || "<span class=\"warn\">refused</span>".to_owned();
    let dash = || "–".to_owned();
    let printed = |sigma: f64, pm: f64| {
        format!(
            "{sigma:.2} <small>± {}</small>",
            if pm < 5e-5 { "0.000".into() } else { format!("{pm:.3}") }
        )
    };
    let cells = [
        ("ours", spread(before.sigma_ut, 2)),
        ("paper", paper.map_or_else(dash, |p| printed(p.sigma_nc_ut, p.sigma_nc_pm_ut))),
        ("ours", after.map_or_else(refused, |score| spread(score.sigma_ut, 2))),
        ("paper", paper.map_or_else(dash, |p| printed(p.sigma_c_ut, p.sigma_c_pm_ut))),
        ("ours", result.epsilon_percent.map_or_else(dash, |epsilon| spread(epsilon, 1))),
        ("paper", paper.map_or_else(dash, |p| signed(p.epsilon_percent, 2))),
        ("", spread(before.heading_rms_deg, 1)),
        ("", after.map_or_else(dash, |score| spread(score.heading_rms_deg, 1))),
        ("thumb", place::thumbnail(result, false)),
        ("thumb", place::thumbnail(result, true)),
    ];
    let cells: Vec<String> =
        cells.iter().map(|(class, cell)| format!("<td class=\"{class}\">{cell}</td>")).collect();
    format!(
        "<tr><th scope=\"row\"><a href=\"#{}\">{name}</a></th>{}</tr>\n",
        place::anchor(result),
        cells.concat(),
    )
}

/// The table for a terminal.
pub fn text(places: &[PlaceResult]) -> String {
    let mut rows = vec![
        ["", "σ_nc", "", "σ_c", "", "ε", "", "heading RMS", ""].map(String::from),
        ["place", "ours µT", "paper", "ours µT", "paper", "ours %", "paper", "before °", "after °"]
            .map(String::from),
    ];
    rows.extend(places.iter().map(text_row));
    let mut widths = [0; 9];
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let line = |row: &[String; 9]| {
        let padded = |(column, cell): (usize, &String)| {
            let gap = " ".repeat(widths[column] - cell.chars().count());
            if column == 0 { format!("{cell}{gap}") } else { format!("  {gap}{cell}") }
        };
        let line: String = row.iter().enumerate().map(padded).collect();
        format!("{}\n", line.trim_end())
    };
    rows.iter().map(line).collect()
}

fn text_row(result: &PlaceResult) -> [String; 9] {
    let (before, after, paper) = (&result.uncalibrated, &result.calibrated, &result.paper);
    let fixed = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "-".into(), |value| format!("{value:.decimals$}"))
    };
    let sigma_c = after.map(|score| score.sigma_ut.mean);
    [
        title(result).into(),
        fixed(Some(before.sigma_ut.mean), 2),
        fixed(paper.map(|p| p.sigma_nc_ut), 2),
        if sigma_c.is_some() { fixed(sigma_c, 2) } else { "refused".into() },
        fixed(paper.map(|p| p.sigma_c_ut), 2),
        fixed(result.epsilon_percent.map(|epsilon| epsilon.mean), 1),
        fixed(paper.map(|p| p.epsilon_percent), 2),
        fixed(Some(before.heading_rms_deg.mean), 1),
        fixed(after.map(|score| score.heading_rms_deg.mean), 1),
    ]
}
