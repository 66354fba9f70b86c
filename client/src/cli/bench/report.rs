//! The figures, for people, for programs and as a page.

use std::time::Duration;

use lodestone_client::latency::{
    CameraLatency, Counted, Curve, Escaped, GAP_THRESHOLD, Machine, Percentiles, Stage,
    StageHistograms, chart, page, table,
};
use serde::Serialize;
use serde_json::{Map, Value};

use super::measurement::{Measurement, Tally};

/// Everything that was measured.
#[derive(Serialize)]
pub(super) struct Report {
    machine: Machine,
    duration_s: f64,
    warnings: Vec<String>,
    /// Gaps that the consumer noted on its own core, and the sentinel on another.
    gaps_of_consumer: Tally,
    gaps_of_sentinel: Option<Tally>,
    cameras: Vec<Camera>,
}

#[derive(Serialize)]
struct Camera {
    #[serde(rename = "camera")]
    name: String,
    counted: Counted,
    /// By stage, every sample.
    all: Map<String, Value>,
    /// By stage, without those whose way crossed a gap.
    without_gaps: Map<String, Value>,
    #[serde(skip)]
    rows: Vec<Row>,
}

/// A stage's percentiles in a table.
struct Row {
    stage: String,
    percentiles: Percentiles,
}

impl Report {
    pub(super) fn new(
        machine: Machine,
        cameras: &[String],
        measurement: &Measurement,
        duration: Duration,
        warnings: Vec<String>,
    ) -> Self {
        let each = cameras.iter().zip(&measurement.latencies);
        Self {
            machine,
            duration_s: duration.as_secs_f64(),
            warnings,
            gaps_of_consumer: measurement.own,
            gaps_of_sentinel: measurement.other,
            cameras: each.map(|(name, latency)| Camera::new(name, latency)).collect(),
        }
    }

    pub(super) fn text(&self) -> String {
        let mut lines = vec![self.machine.told()];
        for camera in &self.cameras {
            lines.push(String::new());
            lines.push(format!(
                "{:<28} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}   µs",
                camera.name, "samples", "p50", "p99", "p99.9", "p99.99", "max"
            ));
            lines.extend(camera.rows.iter().map(Row::text));
            lines.push(format!("  {}", camera.counted_text()));
        }
        lines.push(String::new());
        lines.extend(self.gap_lines());
        lines.extend(self.warnings.iter().map(|warning| format!("  ! {warning}")));
        lines.join("\n")
    }

    /// One chart for all cameras' whole ways, and one for each camera's stages.
    pub(super) fn page(&self, cameras: &[String], measurement: &Measurement) -> String {
        let mut body = format!("<p>{}</p>\n", Escaped(&self.machine.told()));
        for note in self.gap_lines().iter().chain(&self.warnings) {
            body += &element("p class=\"note\"", note);
        }
        let latencies = || cameras.iter().zip(&measurement.latencies);
        let whole = latencies().map(|(name, latency)| Curve {
            name: name.clone(),
            histogram: latency.all.of(Stage::ArrivalToSeen),
        });
        body += "<h2>Arrival → seen</h2>\n";
        body += &chart("Arrival to seen by camera", &whole.collect::<Vec<_>>());
        for (camera, (name, latency)) in self.cameras.iter().zip(latencies()) {
            body += &element("h2", name);
            body += &chart(&format!("Stages of {name}"), &stages(&latency.all));
            body += "<div class=\"scroll\">";
            body += &camera.table();
            body += "</div>\n";
            body += &element("p class=\"note\"", &camera.counted_text());
        }
        page("Lodestone: latency", &body)
    }

    fn gap_lines(&self) -> Vec<String> {
        let told = |who: &str, tally: &Tally| {
            format!(
                "gaps {who}: {} of more than {} µs, {:.2} ms in all, the longest {:.2} ms",
                tally.count,
                GAP_THRESHOLD.as_micros(),
                tally.total_ns as f64 * 1e-6,
                tally.longest_ns as f64 * 1e-6
            )
        };
        let own = told("on the consumer's processor", &self.gaps_of_consumer);
        let other = self.gaps_of_sentinel.as_ref();
        [own].into_iter().chain(other.map(|t| told("on the sentinel's processor", t))).collect()
    }
}

impl Camera {
    fn new(name: &str, latency: &CameraLatency) -> Self {
        let row = |histograms: &StageHistograms, stage: Stage, note: &str| Row {
            stage: format!("{}{note}", stage.name()),
            percentiles: histograms.of(stage).percentiles(),
        };
        let mut rows: Vec<Row> = Stage::ALL.map(|stage| row(&latency.all, stage, "")).into();
        rows.push(row(&latency.clean, Stage::ArrivalToSeen, ", no gaps"));
        Self {
            name: name.into(),
            counted: latency.counted,
            all: by_stage(&latency.all),
            without_gaps: by_stage(&latency.clean),
            rows,
        }
    }

    fn counted_text(&self) -> String {
        let mut parts = vec![format!("{} measured", self.counted.measured)];
        parts.extend(self.counted.told());
        parts.join(", ")
    }

    fn table(&self) -> String {
        let named = Percentiles::default().named().map(|(name, _)| format!("{name} µs"));
        let head = ["stage".into(), "samples".into()].into_iter().chain(named).collect();
        let rows = self.rows.iter().map(|row| {
            let numbers = row.percentiles.named().map(|(_, ns)| micros(ns));
            let count = row.percentiles.count.to_string();
            [row.stage.clone(), count].into_iter().chain(numbers).collect()
        });
        table(&[head].into_iter().chain(rows).collect::<Vec<Vec<String>>>())
    }
}

impl Row {
    fn text(&self) -> String {
        let numbers = self.percentiles.named().map(|(_, ns)| format!(" {:>9}", micros(ns)));
        format!("  {:<26} {:>8}{}", self.stage, self.percentiles.count, numbers.concat())
    }
}

fn by_stage(histograms: &StageHistograms) -> Map<String, Value> {
    let entry = |stage: Stage| {
        // Numbers and nulls only: it cannot fail.
        let value = serde_json::to_value(histograms.of(stage).percentiles());
        (stage.key().to_owned(), value.unwrap_or(Value::Null))
    };
    Stage::ALL.into_iter().map(entry).collect()
}

fn stages(histograms: &StageHistograms) -> Vec<Curve<'_>> {
    let curve = |stage: Stage| Curve { name: stage.name().into(), histogram: histograms.of(stage) };
    Stage::ALL.map(curve).into()
}

/// Text in a paragraph or heading; attributes go with the element's name.
fn element(name_and_attributes: &str, text: &str) -> String {
    let name = name_and_attributes.split(' ').next().unwrap_or_default();
    format!("<{name_and_attributes}>{}</{name}>\n", Escaped(text))
}

fn micros(ns: Option<u64>) -> String {
    ns.map_or_else(|| "-".into(), |ns| format!("{:.1}", ns as f64 * 1e-3))
}
