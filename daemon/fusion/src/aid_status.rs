//! Which aids hold the position now, and which of them were refused.

/// How long an aid counts as present after it was last used or refused, s.
const RECENT_S: f64 = 1.0;

/// Something that keeps the position from drifting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AidKind {
    /// The camera stands: zero velocity.
    Standstill,
    /// The forward speed of the vehicle.
    Speed,
    /// The vehicle moves neither sideways nor up and down.
    NonHolonomic,
    /// A position in the world.
    PositionFix,
    /// A position and an orientation in the world.
    PoseFix,
    /// A velocity in the world from the gradient of the magnetic field.
    Gradient,
}

impl AidKind {
    /// Every kind.
    pub const ALL: [Self; 6] = [
        Self::Standstill,
        Self::Speed,
        Self::NonHolonomic,
        Self::PositionFix,
        Self::PoseFix,
        Self::Gradient,
    ];
}

/// Where a position comes from: the aid that holds it best at present.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PositionOrigin {
    /// Acceleration integrated twice: sigma grows.
    #[default]
    Unaided,
    /// The camera stands where it was.
    Standstill,
    /// The forward speed of the vehicle, integrated along its heading.
    Speed,
    /// Acceleration, held to the direction in which the vehicle can drive.
    NonHolonomic,
    /// A position in the world.
    PositionFix,
    /// A position and an orientation in the world.
    PoseFix,
    /// The velocity that the gradient of the magnetic field shows.
    Gradient,
}

/// A set of aids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AidFlags(u8);

impl AidFlags {
    /// No aid.
    pub const NONE: Self = Self(0);

    /// The set of one aid.
    pub const fn of(kind: AidKind) -> Self {
        Self(1 << kind as u8)
    }

    /// The set with one aid more.
    #[must_use]
    pub const fn with(self, kind: AidKind) -> Self {
        Self(self.0 | Self::of(kind).0)
    }

    /// Whether an aid is in the set.
    pub const fn contains(self, kind: AidKind) -> bool {
        self.0 & Self::of(kind).0 != 0
    }

    /// One bit for each kind, in the order of [`AidKind::ALL`].
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

/// Aids used, and aids refused, within the last second; one that comes often can be both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AidStatus {
    /// They corrected the state.
    pub used: AidFlags,
    /// They were offered and did not fit, or came too late.
    pub refused: AidFlags,
}

impl AidStatus {
    /// Whether the velocity is measured in all directions, so that gravity needs no levelling by the
    /// assumption that a camera's velocity stays small.
    pub const fn holds_velocity(self) -> bool {
        let rolls = self.used.contains(AidKind::Speed) && self.used.contains(AidKind::NonHolonomic);
        rolls
            || self.used.contains(AidKind::PositionFix)
            || self.used.contains(AidKind::PoseFix)
            || self.used.contains(AidKind::Gradient)
    }

    /// The aid that holds the position best: one that sees it goes before one that sees a velocity.
    pub const fn position_origin(self) -> PositionOrigin {
        if self.used.contains(AidKind::PoseFix) {
            PositionOrigin::PoseFix
        } else if self.used.contains(AidKind::PositionFix) {
            PositionOrigin::PositionFix
        } else if self.used.contains(AidKind::Standstill) {
            PositionOrigin::Standstill
        } else if self.used.contains(AidKind::Speed) {
            PositionOrigin::Speed
        } else if self.used.contains(AidKind::Gradient) {
            PositionOrigin::Gradient
        } else if self.used.contains(AidKind::NonHolonomic) {
            PositionOrigin::NonHolonomic
        } else {
            PositionOrigin::Unaided
        }
    }
}

/// When each aid was last used and last refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AidLedger {
    used_s: [f64; AidKind::ALL.len()],
    refused_s: [f64; AidKind::ALL.len()],
    /// Now, on a clock of the ledger's own, s.
    now_s: f64,
}

impl AidLedger {
    pub(crate) const EMPTY: Self = Self {
        used_s: [f64::NEG_INFINITY; AidKind::ALL.len()],
        refused_s: [f64::NEG_INFINITY; AidKind::ALL.len()],
        now_s: 0.0,
    };

    /// Time passes.
    pub(crate) const fn pass(&mut self, span_s: f64) {
        self.now_s += span_s;
    }

    /// An aid was offered, and used or not.
    pub(crate) const fn note(&mut self, kind: AidKind, used: bool) {
        let times_s = if used { &mut self.used_s } else { &mut self.refused_s };
        times_s[kind as usize] = self.now_s;
    }

    /// What was used is over: the camera moves again.
    pub(crate) const fn end(&mut self, kind: AidKind) {
        self.used_s[kind as usize] = f64::NEG_INFINITY;
    }

    pub(crate) fn status(&self) -> AidStatus {
        let from_s = self.now_s - RECENT_S;
        AidStatus { used: since(from_s, &self.used_s), refused: since(from_s, &self.refused_s) }
    }
}

/// What happened last not before a time.
fn since(from_s: f64, times_s: &[f64; AidKind::ALL.len()]) -> AidFlags {
    let flag = |kind: AidKind| u8::from(times_s[kind as usize] >= from_s) << kind as u8;
    AidFlags(AidKind::ALL.into_iter().fold(0, |flags, kind| flags | flag(kind)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_aid_is_present_for_a_second_and_then_no_longer() {
        let mut ledger = AidLedger::EMPTY;
        assert_eq!(ledger.status(), AidStatus::default());
        ledger.note(AidKind::Speed, true);
        ledger.note(AidKind::PositionFix, false);
        ledger.pass(0.9);
        let status = ledger.status();
        assert!(status.used.contains(AidKind::Speed) && !status.refused.contains(AidKind::Speed));
        assert!(status.refused.contains(AidKind::PositionFix));
        assert_eq!(
            status.position_origin(),
            PositionOrigin::Speed,
            "what was refused holds nothing"
        );
        ledger.pass(0.2);
        assert_eq!(ledger.status(), AidStatus::default());
        assert_eq!(ledger.status().position_origin(), PositionOrigin::Unaided);
    }

    #[test]
    fn the_aid_that_sees_the_position_goes_first() {
        let mut used = AidFlags::NONE;
        let mut origins = std::vec::Vec::new();
        for kind in [
            AidKind::NonHolonomic,
            AidKind::Gradient,
            AidKind::Speed,
            AidKind::Standstill,
            AidKind::PositionFix,
            AidKind::PoseFix,
        ] {
            used = used.with(kind);
            origins.push(AidStatus { used, refused: AidFlags::NONE }.position_origin());
        }
        let expected = [
            PositionOrigin::NonHolonomic,
            PositionOrigin::Gradient,
            PositionOrigin::Speed,
            PositionOrigin::Standstill,
            PositionOrigin::PositionFix,
            PositionOrigin::PoseFix,
        ];
        assert_eq!(origins, expected);
    }

    #[test]
    fn a_standstill_ends_when_the_camera_moves() {
        let mut ledger = AidLedger::EMPTY;
        ledger.note(AidKind::Standstill, true);
        ledger.end(AidKind::Standstill);
        assert!(ledger.status().used.is_empty());
    }
}
