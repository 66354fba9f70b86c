//! One chart: axes with ticks and units, and marks in it.

mod shapes;

use super::scale::{Scale, Tick, signed};
use super::svg::{Escaped, Px, append, dots, polyline};

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What runs along it, with its unit.
    pub label: String,
    /// How.
    pub scale: Scale,
    /// Where its ticks stand.
    pub ticks: Vec<Tick>,
}

impl Axis {
    /// An axis with about `count` round ticks.
    pub fn new(label: &str, scale: Scale, count: usize) -> Self {
        Self { label: label.into(), scale, ticks: scale.ticks(count) }
    }

    /// An axis with ticks that divide it into `parts`, such as a circle's quarters.
    pub fn every(label: &str, low: f64, high: f64, parts: u32) -> Self {
        let tick = |part: u32| {
            let value = low + (high - low) * f64::from(part) / f64::from(parts);
            Tick { value, label: signed(value, 0) }
        };
        let ticks = (0..=parts).map(tick).collect();
        Self { label: label.into(), scale: Scale::Linear(low, high), ticks }
    }

    /// An axis of named rows at 0, 1, 2, …
    pub fn rows(names: &[String]) -> Self {
        let scale = Scale::Linear(names.len() as f64 - 0.5, -0.5);
        let tick = |(row, name): (usize, &String)| Tick { value: row as f64, label: name.clone() };
        Self { label: String::new(), scale, ticks: names.iter().enumerate().map(tick).collect() }
    }
}

/// What stands for a series in a legend, by itself.
pub fn key(mark: Mark, class: &str) -> String {
    let sign = mark_markup(mark, class, (11.0, 7.0));
    format!("<svg class=\"key\" viewBox=\"0 0 22 14\" width=\"22\" height=\"14\">{sign}</svg>")
}

/// What stands for a series in a legend.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Dots or a filled circle.
    Dot,
    /// A line, dashed if the class says so.
    Line,
    /// A hollow diamond.
    Diamond,
}

/// A chart that is being drawn. Classes name colours of the page's style.
#[derive(Clone, Debug)]
pub struct Plot {
    name: String,
    width: f64,
    height: f64,
    left: f64,
    top: f64,
    inner: (f64, f64),
    x: Scale,
    y: Scale,
    /// Grid, ticks, labels, legend.
    around: String,
    /// What is clipped to the axes.
    within: String,
}

/// Room around the axes, px.
#[derive(Clone, Copy, Debug)]
struct Margins {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

const RIGHT_PX: f64 = 18.0;
const BOTTOM_PX: f64 = 40.0;
const TOP_PX: f64 = 12.0;

impl Margins {
    /// Room for labels of y and for what stands above the axes.
    const fn of(left: f64, top: f64) -> Self {
        Self { left, top, right: RIGHT_PX, bottom: BOTTOM_PX }
    }

    /// Room for no labels.
    const NARROW: Self = Self { left: 2.0, top: 2.0, right: 2.0, bottom: 2.0 };
}

impl Plot {
    /// Draws the axes; `name` says what the chart shows, for those who cannot see it. Room for the
    /// labels of y is `left` wide.
    pub fn new(name: &str, (width, height): (f64, f64), left: f64, x: &Axis, y: &Axis) -> Self {
        Self::within(name, (width, height), Margins::of(left, TOP_PX), (x, y))
    }

    /// The same with room for a legend above the axes.
    pub fn with_legend(
        name: &str,
        (width, height): (f64, f64),
        left: f64,
        (x, y): (&Axis, &Axis),
        entries: &[(Mark, &str, &str)],
    ) -> Self {
        let mut plot = Self::within(name, (width, height), Margins::of(left, 30.0), (x, y));
        plot.legend(entries);
        plot
    }

    fn within(
        name: &str,
        (width, height): (f64, f64),
        margins: Margins,
        (x, y): (&Axis, &Axis),
    ) -> Self {
        let Margins { left, top, right, bottom } = margins;
        let mut plot = Self {
            name: name.into(),
            width,
            height,
            left,
            top,
            inner: (width - left - right, height - top - bottom),
            x: x.scale,
            y: y.scale,
            around: String::new(),
            within: String::new(),
        };
        plot.x_axis(x);
        plot.y_axis(y);
        plot
    }

    /// A square chart about the origin whose two axes have one scale, so that circles are round.
    pub fn square(name: &str, side: f64, labels: (&str, &str), reach: f64) -> Self {
        Self::alike(name, side, labels, ((0.0, 0.0), reach))
    }

    /// A square chart whose two axes have one scale, from a middle as far as `reach` to all sides.
    pub fn alike(
        name: &str,
        side: f64,
        labels: (&str, &str),
        ((x, y), reach): ((f64, f64), f64),
    ) -> Self {
        let axis = |label, at: f64| Axis::new(label, Scale::Linear(at - reach, at + reach), 5);
        let (x, y) = (axis(labels.0, x), axis(labels.1, y));
        let left = 46.0;
        let height = side - left - RIGHT_PX + TOP_PX + BOTTOM_PX;
        Self::new(name, (side, height), left, &x, &y)
    }

    /// The same without ticks and labels, for a projection that has axes of its own.
    pub fn picture(name: &str, side: f64, ((x, y), reach): ((f64, f64), f64)) -> Self {
        let axis = |at: f64| Axis {
            label: String::new(),
            scale: Scale::Linear(at - reach, at + reach),
            ticks: Vec::new(),
        };
        Self::within(name, (side, side), Margins::NARROW, (&axis(x), &axis(y)))
    }

    /// Dots.
    pub fn dots(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        let places = points.filter_map(|point| self.inside(point));
        let data = dots(places);
        append(&mut self.within, format_args!("<path class=\"dots {class}\" d=\"{data}\"/>"));
    }

    /// A line through points, cut off at the axes' ends.
    pub fn line(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        let data = polyline(points.map(|point| self.place(point)).filter(is_finite));
        append(&mut self.within, format_args!("<path class=\"line {class}\" d=\"{data}\"/>"));
    }

    /// A circle in the axes' units; round only on a square chart.
    pub fn ring(&mut self, class: &str, radius: f64) {
        let ((x, y), (edge, _)) = (self.place((0.0, 0.0)), self.place((radius, 0.0)));
        let (x, y, r) = (Px(x), Px(y), Px(edge - x));
        append(
            &mut self.within,
            format_args!("<circle class=\"ring {class}\" cx=\"{x}\" cy=\"{y}\" r=\"{r}\"/>"),
        );
    }

    /// A filled circle or hollow diamond at one point.
    pub fn mark(&mut self, mark: Mark, class: &str, point: (f64, f64)) {
        let Some(place) = self.inside(point) else { return };
        let mark = mark_markup(mark, class, place);
        self.within.push_str(&mark);
    }

    fn legend(&mut self, entries: &[(Mark, &str, &str)]) {
        let mut x = self.left;
        for (mark, class, text) in entries {
            let sign = mark_markup(*mark, class, (x + 9.0, 13.0));
            let label = Escaped(text);
            let at = Px(x + 24.0);
            append(
                &mut self.around,
                format_args!("{sign}<text class=\"legend\" x=\"{at}\" y=\"17\">{label}</text>"),
            );
            // Letters are about 6.4 px wide at this size.
            x += 42.0 + 6.4 * text.chars().count() as f64;
        }
    }

    /// The finished chart.
    pub fn finish(self) -> String {
        let (name, left, top) = (Escaped(&self.name), Px(self.left), Px(self.top));
        let (width, height) = (Px(self.width), Px(self.height));
        let (across, down) = (Px(self.inner.0), Px(self.inner.1));
        format!(
            "<svg class=\"plot\" role=\"img\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             height=\"{height}\"><title>{name}</title>{around}<svg x=\"{left}\" y=\"{top}\" \
             width=\"{across}\" height=\"{down}\">{within}</svg></svg>\n",
            around = self.around,
            within = self.within,
        )
    }

    /// Where a point lies inside of the axes' rectangle, px.
    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.part(x) * self.inner.0, (1.0 - self.y.part(y)) * self.inner.1)
    }

    fn inside(&self, point: (f64, f64)) -> Option<(f64, f64)> {
        let place = self.place(point);
        let within = |at: f64, size: f64| (-1.0..=size + 1.0).contains(&at);
        (within(place.0, self.inner.0) && within(place.1, self.inner.1)).then_some(place)
    }

    fn x_axis(&mut self, axis: &Axis) {
        let (top, bottom) = (Px(self.top), Px(self.top + self.inner.1));
        let number_y = Px(self.top + self.inner.1 + 15.0);
        for tick in &axis.ticks {
            let x = Px(self.left + self.x.part(tick.value) * self.inner.0);
            let (class, label) = (grid_class(tick), Escaped(&tick.label));
            append(
                &mut self.around,
                format_args!(
                    "<path class=\"{class}\" d=\"M{x} {top}V{bottom}\"/>\
                     <text class=\"tick\" x=\"{x}\" y=\"{number_y}\" text-anchor=\"middle\">{label}</text>"
                ),
            );
        }
        let (middle, y) = (Px(self.left + 0.5 * self.inner.0), Px(self.height - 6.0));
        let label = Escaped(&axis.label);
        append(
            &mut self.around,
            format_args!(
                "<text class=\"axis\" x=\"{middle}\" y=\"{y}\" text-anchor=\"middle\">{label}</text>"
            ),
        );
    }

    fn y_axis(&mut self, axis: &Axis) {
        let (left, right) = (Px(self.left), Px(self.left + self.inner.0));
        for tick in &axis.ticks {
            let at = self.top + (1.0 - self.y.part(tick.value)) * self.inner.1;
            let (y, baseline, x) = (Px(at), Px(at + 4.0), Px(self.left - 7.0));
            let (class, label) = (grid_class(tick), Escaped(&tick.label));
            append(
                &mut self.around,
                format_args!(
                    "<path class=\"{class}\" d=\"M{left} {y}H{right}\"/>\
                     <text class=\"tick\" x=\"{x}\" y=\"{baseline}\" text-anchor=\"end\">{label}</text>"
                ),
            );
        }
        let (middle, label) = (Px(self.top + 0.5 * self.inner.1), Escaped(&axis.label));
        append(
            &mut self.around,
            format_args!(
                "<text class=\"axis\" transform=\"translate(12 {middle}) rotate(-90)\" \
                 text-anchor=\"middle\">{label}</text>"
            ),
        );
    }
}

fn is_finite((x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

const fn grid_class(tick: &Tick) -> &'static str {
    if tick.label.is_empty() { "grid minor" } else { "grid" }
}

fn mark_markup(mark: Mark, class: &str, (x, y): (f64, f64)) -> String {
    let (left, right, top, bottom) = (Px(x - 6.0), Px(x + 6.0), Px(y - 6.0), Px(y + 6.0));
    let (x, y) = (Px(x), Px(y));
    match mark {
        Mark::Dot => format!("<circle class=\"mark {class}\" cx=\"{x}\" cy=\"{y}\" r=\"4.5\"/>"),
        Mark::Line => format!("<path class=\"line {class}\" d=\"M{left} {y}H{right}\"/>"),
        Mark::Diamond => {
            format!(
                "<path class=\"hollow {class}\" d=\"M{x} {top}L{right} {y}L{x} {bottom}L{left} {y}Z\"/>"
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        let x = Axis::new("time, s", Scale::Linear(0.0, 10.0), 5);
        let y = Axis::new("field <µT>", Scale::Log(0.1, 10.0), 5);
        Plot::new("a & b", (400.0, 300.0), 50.0, &x, &y)
    }

    #[test]
    fn places_run_right_and_up() {
        let plot = plot();
        assert_eq!(plot.place((0.0, 10.0)), (0.0, 0.0));
        let (x, y) = plot.place((10.0, 0.1));
        assert!((x - 332.0).abs() < 1e-9 && (y - 248.0).abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn labels_are_escaped_and_points_outside_are_left_out() {
        let mut plot = plot();
        plot.dots("yaw", [(5.0, 1.0), (50.0, 1.0), (5.0, f64::NAN)].into_iter());
        plot.mark(Mark::Dot, "ours", (5.0, 100.0));
        let markup = plot.finish();
        assert!(markup.contains("field &lt;µT&gt;") && markup.contains("<title>a &amp; b</title>"));
        assert!(markup.contains("d=\"M166 124h0\""), "{markup}");
        assert!(!markup.contains("class=\"mark"), "{markup}");
    }

    #[test]
    fn a_square_chart_has_one_scale() {
        let plot = Plot::square("sphere", 300.0, ("x", "y"), 50.0);
        assert!((plot.inner.0 - plot.inner.1).abs() < 1e-9);
        let ((x0, y0), (x1, y1)) = (plot.place((0.0, 0.0)), plot.place((10.0, 10.0)));
        assert!((x1 - x0 - (y0 - y1)).abs() < 1e-9);
    }
}
