//! Numbers as 64-bit words, in the order in which they are put and taken.

use glam::{DMat3, DVec3};
use lodestone_fusion::{Drift, SensorTime};

/// Words that are put one after the other.
pub(super) struct Put<const WORDS: usize> {
    words: [u64; WORDS],
    next: usize,
}

impl<const WORDS: usize> Put<WORDS> {
    pub(super) const fn new() -> Self {
        Self { words: [0; WORDS], next: 0 }
    }

    pub(super) fn word(&mut self, word: u64) {
        self.words[self.next] = word;
        self.next += 1;
    }

    pub(super) fn number(&mut self, number: f64) {
        self.word(number.to_bits());
    }

    pub(super) fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.number(*number);
        }
    }

    pub(super) fn drift(&mut self, drift: &Drift) {
        self.word(drift.began.as_nanos().cast_unsigned());
        self.numbers(&[drift.angle_rad2, drift.bias_rad, drift.way_m]);
        for vector in [drift.turned_rad2, drift.shifted_m2, drift.turned_rad, drift.shifted_m] {
            self.numbers(&vector.to_array());
        }
    }

    pub(super) const fn done(self) -> [u64; WORDS] {
        self.words
    }
}

/// Words that are taken one after the other.
pub(super) struct Take<'a> {
    words: &'a [u64],
}

impl<'a> Take<'a> {
    pub(super) const fn new(words: &'a [u64]) -> Self {
        Self { words }
    }

    /// The next one; 0 after the last.
    pub(super) fn word(&mut self) -> u64 {
        let Some((word, rest)) = self.words.split_first() else { return 0 };
        self.words = rest;
        *word
    }

    pub(super) fn number(&mut self) -> f64 {
        f64::from_bits(self.word())
    }

    pub(super) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }

    /// A matrix by columns.
    pub(super) fn matrix(&mut self) -> DMat3 {
        DMat3::from_cols(self.vector(), self.vector(), self.vector())
    }

    /// A matrix of `xx xy xz yy yz zz`.
    pub(super) fn symmetric(&mut self) -> DMat3 {
        symmetric(core::array::from_fn(|_| self.number()))
    }

    pub(super) fn drift(&mut self) -> Drift {
        Drift {
            began: SensorTime::from_nanos(self.word().cast_signed()),
            angle_rad2: self.number(),
            bias_rad: self.number(),
            way_m: self.number(),
            turned_rad2: self.vector(),
            shifted_m2: self.vector(),
            turned_rad: self.vector(),
            shifted_m: self.vector(),
        }
    }
}

/// Words of a [`Drift`].
pub(super) const DRIFT: usize = 16;

/// `xx xy xz yy yz zz`.
pub(super) const fn triangle(m: DMat3) -> [f64; 6] {
    [m.x_axis.x, m.y_axis.x, m.z_axis.x, m.y_axis.y, m.z_axis.y, m.z_axis.z]
}

pub(super) fn symmetric([xx, xy, xz, yy, yz, zz]: [f64; 6]) -> DMat3 {
    DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
}
