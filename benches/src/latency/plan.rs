//! Rounds: every subject once, in an order that is drawn anew.

use std::error::Error;

use clap::ValueEnum;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::round::{Outcome, run};
use super::subject::{Kind, Subject};

/// What is run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Rounds.
    pub rounds: usize,
    /// Seconds each subject is measured in a round.
    pub seconds: f64,
    /// Of the order.
    pub seed: u64,
    /// With real-time priority, where that is allowed.
    pub real_time: bool,
    /// What is measured; everything if empty.
    pub only: Vec<Subject>,
}

impl Plan {
    /// The subjects.
    pub fn subjects(&self) -> Vec<Subject> {
        let all = Subject::value_variants().iter().copied();
        // The floor is measured by the subject whose turns it shares.
        let of = |subject| if subject == Subject::Floor { Subject::InTurns } else { subject };
        all.filter(|subject| self.only.is_empty() || self.only.contains(&of(*subject))).collect()
    }

    /// What one round runs, in its order.
    fn order(&self, round: usize) -> Vec<Subject> {
        let mut subjects = self.subjects();
        subjects.retain(|subject| subject.kind() != Kind::Beside);
        let mut drawn = ChaCha8Rng::seed_from_u64(self.seed);
        drawn.set_stream(round as u64);
        subjects.shuffle(&mut drawn);
        subjects
    }

    /// Runs all rounds; says on standard error what it does.
    ///
    /// # Errors
    /// The first subject that failed.
    pub fn run(&self) -> Result<Vec<Outcome>, Box<dyn Error>> {
        let mut outcomes = Vec::new();
        for round in 1..=self.rounds {
            for subject in self.order(round) {
                eprintln!("round {round} of {}: {}", self.rounds, subject.name());
                let outcome = run(subject, (self.seconds, self.real_time));
                outcomes.extend(outcome.map_err(|e| format!("{}: {e}", subject.key()))?);
            }
        }
        Ok(outcomes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_round_has_every_subject_once_in_an_order_of_its_own() {
        let plan = Plan { rounds: 2, seconds: 1.0, seed: 7, real_time: true, only: Vec::new() };
        let (first, second) = (plan.order(1), plan.order(2));
        assert_ne!(first, second);
        assert_eq!(first, plan.order(1), "the seed tells");
        let on_its_own = |subject: &&Subject| subject.kind() != Kind::Beside;
        for subject in Subject::value_variants().iter().filter(on_its_own) {
            assert_eq!(first.iter().filter(|s| *s == subject).count(), 1, "{}", subject.key());
            assert!(second.contains(subject));
        }
        let chosen = Plan { only: vec![Subject::Step], ..plan };
        assert_eq!(chosen.order(1), [Subject::Step]);
        let in_turns = Plan { only: vec![Subject::InTurns], ..chosen };
        assert_eq!(in_turns.subjects(), [Subject::InTurns, Subject::Floor]);
        assert_eq!(in_turns.order(1), [Subject::InTurns]);
    }
}
