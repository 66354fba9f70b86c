//! Whether a source of measurements is believed that does not fit.

use crate::time::SensorTime;

/// How long an aid has been refused without pause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gate {
    refused_since: Option<SensorTime>,
    last: Option<SensorTime>,
}

/// What a gate decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    Use,
    Refuse,
    /// Refused for long: the state's own uncertainty must be too small.
    Reopen,
}

impl Gate {
    pub(super) const OPEN: Self = Self { refused_since: None, last: None };

    pub(super) fn judge(&mut self, fits: bool, now: SensorTime, patience_s: f64) -> Verdict {
        // A source that was silent for as long begins anew.
        let silent = self.last.is_some_and(|last| (now - last).as_secs_f64() > patience_s);
        self.last = Some(now);
        if fits {
            self.refused_since = None;
            return Verdict::Use;
        }
        if silent {
            self.refused_since = None;
        }
        let since = *self.refused_since.get_or_insert(now);
        if (now - since).as_secs_f64() < patience_s {
            return Verdict::Refuse;
        }
        self.refused_since = None;
        Verdict::Reopen
    }
}
