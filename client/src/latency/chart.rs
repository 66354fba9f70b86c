//! The curve of percentiles, as HDR histograms are drawn: each step to the right is one sample in ten,
//! a hundred, a thousand.

use std::fmt::Write;

use super::histogram::Histogram;
use super::page::Escaped;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 420.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 44.0;

/// Colours of the page's style, in their order.
const COLOURS: usize = 8;

/// One curve.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    /// What it is of.
    pub name: String,
    /// What is drawn.
    pub histogram: &'a Histogram,
}

/// Powers of ten between which an axis runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Decades {
    first: i32,
    last: i32,
}

impl Decades {
    /// Whole decades that hold all values; one where there is none.
    fn around(values: impl Iterator<Item = f64>) -> Self {
        let logs: Vec<f64> = values.filter(|v| *v > 0.0).map(f64::log10).collect();
        let first = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let last = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !first.is_finite() {
            return Self { first: 0, last: 1 };
        }
        let (first, last) = (first.floor() as i32, last.ceil() as i32);
        Self { first, last: last.max(first + 1) }
    }

    fn part(self, value: f64) -> f64 {
        (value.log10() - f64::from(self.first)) / f64::from(self.last - self.first)
    }
}

/// Draws curves of times over percentiles as inline SVG.
pub fn chart(title: &str, curves: &[Curve<'_>]) -> String {
    let points: Vec<Vec<(f64, f64)>> = curves.iter().map(points_of).collect();
    let all = || points.iter().flatten();
    let x = Decades { first: 0, ..Decades::around(all().map(|(one_in, _)| *one_in)) };
    let y = Decades::around(all().map(|(_, us)| *us));
    let mut svg = format!(
        "<svg class=\"plot\" role=\"img\" viewBox=\"0 0 {WIDTH} {HEIGHT}\"><title>{}</title>",
        Escaped(title)
    );
    grid(&mut svg, x, y);
    for (index, points) in points.iter().enumerate() {
        line(&mut svg, index, points, x, y);
    }
    svg.push_str("</svg>\n");
    svg + &legend(curves)
}

/// One time in so many, and µs; a time of 0 ns is drawn at 1 ns.
fn points_of(curve: &Curve<'_>) -> Vec<(f64, f64)> {
    let curve = curve.histogram.curve().into_iter();
    curve.map(|(one_in, ns)| (one_in, ns.max(1) as f64 * 1e-3)).collect()
}

fn place_x(x: Decades, one_in: f64) -> f64 {
    LEFT + x.part(one_in) * (WIDTH - LEFT - RIGHT)
}

fn place_y(y: Decades, us: f64) -> f64 {
    HEIGHT - BOTTOM - y.part(us) * (HEIGHT - TOP - BOTTOM)
}

fn grid(svg: &mut String, x: Decades, y: Decades) {
    let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
    for power in x.first..=x.last {
        let (at, label) = (place_x(x, 10_f64.powi(power)), percentile_label(power));
        append(
            svg,
            format_args!(
                "<path class=\"grid\" d=\"M{at:.1} {TOP}V{bottom}\"/>\
                 <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
                bottom + 18.0
            ),
        );
    }
    for power in y.first..=y.last {
        let (at, label) = (place_y(y, 10_f64.powi(power)), time_label(power));
        append(
            svg,
            format_args!(
                "<path class=\"grid\" d=\"M{LEFT} {at:.1}H{right}\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
                LEFT - 8.0,
                at + 4.0
            ),
        );
    }
    append(
        svg,
        format_args!(
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">percentile</text>",
            0.5 * (LEFT + right),
            HEIGHT - 6.0
        ),
    );
}

fn line(svg: &mut String, index: usize, points: &[(f64, f64)], x: Decades, y: Decades) {
    let mut path = String::new();
    for (one_in, us) in points {
        let verb = if path.is_empty() { 'M' } else { 'L' };
        append(&mut path, format_args!("{verb}{:.1} {:.1}", place_x(x, *one_in), place_y(y, *us)));
    }
    append(svg, format_args!("<path class=\"curve c{}\" d=\"{path}\"/>", index % COLOURS));
}

fn legend(curves: &[Curve<'_>]) -> String {
    let mut text = String::from("<p class=\"legend\">");
    for (index, curve) in curves.iter().enumerate() {
        append(
            &mut text,
            format_args!(
                "<span class=\"c{}\">━ <b>{}</b></span> ",
                index % COLOURS,
                Escaped(&curve.name)
            ),
        );
    }
    text + "</p>\n"
}

/// One in ten is 90 %, one in a hundred 99 %.
fn percentile_label(power: i32) -> String {
    match power {
        0 => "0".into(),
        1 => "90 %".into(),
        2 => "99 %".into(),
        _ => format!("99.{} %", "9".repeat(power.unsigned_abs() as usize - 2)),
    }
}

/// A power of ten µs.
fn time_label(power: i32) -> String {
    match power {
        ..=-1 => format!("{} ns", 10_f64.powi(power + 3)),
        0..=2 => format!("{} µs", 10_f64.powi(power)),
        3..=5 => format!("{} ms", 10_f64.powi(power - 3)),
        _ => format!("{} s", 10_f64.powi(power - 6)),
    }
}

fn append(text: &mut String, more: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = text.write_fmt(more);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_named_as_people_read_them() {
        assert_eq!(
            [0, 1, 2, 3, 4].map(percentile_label),
            ["0", "90 %", "99 %", "99.9 %", "99.99 %"]
        );
        let times = [-3, -1, 0, 2, 3, 6].map(time_label);
        assert_eq!(times, ["1 ns", "100 ns", "1 µs", "100 µs", "1 ms", "1 s"]);
    }

    #[test]
    fn curves_stay_within_the_axes_and_names_are_text() {
        let mut histogram = Histogram::default();
        (1..=2000).for_each(|us| histogram.record(us * 700));
        let curves = [
            Curve { name: "<front>".into(), histogram: &histogram },
            Curve { name: "nothing".into(), histogram: &Histogram::default() },
        ];
        let svg = chart("a & b", &curves);
        assert!(svg.contains("&lt;front&gt;") && svg.contains("a &amp; b") && !svg.contains("NaN"));
        let (_, path) = svg.split_once("curve c0\" d=\"M").expect("a curve");
        let (path, _) = path.split_once('"').expect("its end");
        for point in path.split('L') {
            let (x, y) = point.split_once(' ').expect("two numbers");
            let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
            assert!((LEFT..=WIDTH - RIGHT).contains(&x), "{point}");
            assert!((TOP..=HEIGHT - BOTTOM).contains(&y), "{point}");
        }
    }
}
