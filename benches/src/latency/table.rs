//! The table of results: medians over the rounds.

use super::rounds::{Seen, Subject};
use super::stages::{Quantiles, STAGES};
use crate::ledger::median;

/// Index of the stage that the peer has too.
const TRANSPORT: usize = 3;
/// Index of the whole way.
const WHOLE: usize = 4;

/// Prints what all rounds saw.
pub fn print(seen: &[Seen]) {
    println!(
        "{:<28} {:<24} {:>6} {:>9} {:>9} {:>9}",
        "consumer", "stage", "poses", "p50/us", "p99/us", "max/us"
    );
    let lanes = ["one", "two"].into_iter().flat_map(|t| [Subject::Poll(t), Subject::Wait(t)]);
    for subject in lanes {
        (0..STAGES.len()).for_each(|stage| print_row(seen, subject, stage));
    }
    print_row(seen, Subject::Peer, TRANSPORT);
    print_ratios(seen);
}

fn print_row(seen: &[Seen], subject: Subject, stage: usize) {
    let poses = of(seen, subject).map(|s| s.stages.len()).sum::<usize>();
    let q = over_rounds(seen, subject, stage);
    println!(
        "{:<28} {:<24} {poses:>6} {:>9.1} {:>9.1} {:>9.1}",
        name(subject),
        STAGES[stage],
        q.p50_us,
        q.p99_us,
        q.max_us
    );
}

fn print_ratios(seen: &[Seen]) {
    let p50 = |subject, stage| over_rounds(seen, subject, stage).p50_us;
    let p99 = |subject, stage| over_rounds(seen, subject, stage).p99_us;
    let (one, two) = (Subject::Poll("one"), Subject::Poll("two"));
    println!("\nratios of medians over rounds          p50    p99");
    for (what, a, b, stage) in [
        ("two threads / one, arrival -> seen", two, one, WHOLE),
        ("lane / peer, published -> seen", one, Subject::Peer, TRANSPORT),
        ("wait / poll, published -> seen", Subject::Wait("one"), one, TRANSPORT),
    ] {
        let ratios = [p50(a, stage) / p50(b, stage), p99(a, stage) / p99(b, stage)];
        println!("{what:<36} {:>5.2} {:>6.2}", ratios[0], ratios[1]);
    }
}

fn of(seen: &[Seen], subject: Subject) -> impl Iterator<Item = &Seen> {
    seen.iter().filter(move |s| s.subject == subject)
}

/// The median over the rounds of each quantile.
fn over_rounds(seen: &[Seen], subject: Subject, stage: usize) -> Quantiles {
    let rounds: Vec<Quantiles> =
        of(seen, subject).map(|s| Quantiles::of(&s.stages, stage)).collect();
    let middle = |of: fn(&Quantiles) -> f64| median(&rounds.iter().map(of).collect::<Vec<_>>());
    Quantiles {
        p50_us: middle(|q| q.p50_us),
        p99_us: middle(|q| q.p99_us),
        max_us: middle(|q| q.max_us),
    }
}

fn name(subject: Subject) -> String {
    match subject {
        Subject::Poll(threads) => format!("poll, lane.threads = {threads}"),
        Subject::Wait(threads) => format!("wait, lane.threads = {threads}"),
        Subject::Peer => "poll, plain iceoryx2".into(),
    }
}
