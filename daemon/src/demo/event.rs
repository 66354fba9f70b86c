//! What the consumer tells whoever started it, a line of JSON each on its standard output.

use serde::{Deserialize, Serialize};

/// How far the consumer has come.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "phase")]
pub enum Event {
    /// It waits for poses and clouds.
    Waiting {
        /// Of what, for people.
        what: String,
    },
    /// Every pose is initialised; it lets the filters settle.
    Settling,
    /// It merges.
    Merging {
        /// Share of the time that is over.
        share: f64,
        /// Points taken by the merge of both cameras.
        points: u64,
    },
    /// It writes its files.
    Writing,
}

impl Event {
    /// As a line.
    pub fn to_line(&self) -> String {
        // Numbers and text always are JSON.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// From a line; `None` for what is none.
    pub fn from_line(line: &str) -> Option<Self> {
        serde_json::from_str(line).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_survive_the_pipe() {
        let merging = Event::Merging { share: 0.5, points: 3_000_000 };
        for event in [Event::Waiting { what: "poses of front".into() }, Event::Settling, merging] {
            assert_eq!(Event::from_line(&event.to_line()), Some(event));
        }
        assert_eq!(Event::from_line("thread 'main' panicked"), None);
    }
}
