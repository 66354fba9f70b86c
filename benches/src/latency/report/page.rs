//! The page with curves.

use lodestone_client::latency::{
    CameraLatency, Curve, Escaped, Stage, chart, page as whole, table,
};

use super::super::subject::{Kind, Subject};
use super::summary::Summary;
use super::{micros, three_figures, with_spread, yes_or_no};

/// One self-contained page.
pub fn page(summary: &Summary) -> String {
    let mut body = format!(
        "<p>{}</p>\n<p class=\"note\">{} rounds of {} s. Curves hold all rounds together, without samples \
         whose way crossed a gap; tables have the medians over the rounds, smallest and largest in \
         brackets.</p>\n",
        Escaped(&summary.machine.told()),
        summary.rounds,
        summary.seconds
    );
    body += &section("Promises", &promises(summary));
    let polling = |subject: Subject| subject.polls();
    let sleeping =
        |subject: Subject| !polling(subject) && !matches!(subject.kind(), Kind::Alone(_));
    body += &section("Polling consumers", &curves(summary, "polling consumers", polling));
    body += &section("Consumers that sleep", &curves(summary, "consumers that sleep", sleeping));
    for (subject, latency) in &summary.together {
        if matches!(subject.kind(), Kind::Lane(..)) {
            body += &section(&subject.name(), &stages(summary, *subject, latency));
        }
    }
    whole("Lodestone: latency beside its peers", &body)
}

fn section(heading: &str, content: &str) -> String {
    format!("<h2>{}</h2>\n{content}", Escaped(heading))
}

fn promises(summary: &Summary) -> String {
    let head = ["promise", "at most", "found", "met"].map(str::to_owned).to_vec();
    let rows = summary.targets.iter().map(|target| {
        vec![
            target.promise.to_owned(),
            three_figures(target.limit),
            with_spread(Some(target.found)),
            yes_or_no(target.met).to_owned(),
        ]
    });
    scrolled(&[head].into_iter().chain(rows).collect::<Vec<_>>())
}

fn curves(summary: &Summary, title: &str, wanted: impl Fn(Subject) -> bool) -> String {
    let chosen = summary.together.iter().filter(|(subject, _)| wanted(*subject));
    let curves = chosen.clone().map(|(subject, latency)| Curve {
        name: subject.name(),
        histogram: latency.clean.of(Stage::ArrivalToSeen),
    });
    let keys: Vec<String> = chosen.map(|(subject, _)| subject.key()).collect();
    let whole_way = Stage::ArrivalToSeen.key();
    let rows = rows(summary, |subject, stage| keys.contains(subject) && stage == whole_way, false);
    chart(title, &curves.collect::<Vec<_>>()) + &scrolled(&rows)
}

fn stages(summary: &Summary, subject: Subject, latency: &CameraLatency) -> String {
    let curves = Stage::ALL
        .map(|stage| Curve { name: stage.name().into(), histogram: latency.clean.of(stage) });
    let key = subject.key();
    let rows = rows(summary, |of, _| *of == key, true);
    chart(&subject.name(), &curves) + &scrolled(&rows)
}

/// Table rows of the lines that are wanted, named by subject or by stage.
fn rows(
    summary: &Summary,
    wanted: impl Fn(&String, &str) -> bool,
    by_stage: bool,
) -> Vec<Vec<String>> {
    let head = ["µs", "p50", "p99", "p99.9", "p99.99", "max", "p99 with gaps", "max with gaps"];
    let us = |ns: Option<u64>| micros(ns.map(|ns| ns as f64 * 1e-3));
    let lines = summary.lines.iter().filter(|line| wanted(&line.subject, line.stage));
    let rows = lines.map(|line| {
        let stage = Stage::ALL.into_iter().find(|stage| stage.key() == line.stage);
        vec![
            if by_stage { stage.map_or("", Stage::name).into() } else { line.name.clone() },
            with_spread(line.p50_us),
            with_spread(line.p99_us),
            us(line.together.p99_9_ns),
            us(line.together.p99_99_ns),
            us(line.together.max_ns),
            with_spread(line.p99_with_gaps_us),
            us(line.together_with_gaps.max_ns),
        ]
    });
    [head.map(str::to_owned).to_vec()].into_iter().chain(rows).collect()
}

fn scrolled(rows: &[Vec<String>]) -> String {
    format!("<div class=\"scroll\">{}</div>\n", table(rows))
}
