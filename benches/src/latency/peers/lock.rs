//! The sequence lock's two ends.

use std::error::Error;
use std::time::Duration;

use super::super::payload::Payload;
use super::super::seqlock::Mapped;
use super::{Place, Receiver, Sender};

pub(super) struct Writer {
    lock: Mapped,
    wakes: bool,
}

impl Writer {
    pub(super) fn open(place: &Place, wakes: bool) -> Result<Self, Box<dyn Error>> {
        Ok(Self { lock: Mapped::open(&place.file("seqlock"))?, wakes })
    }
}

impl Sender for Writer {
    fn send(&mut self, payload: &Payload) -> Result<(), Box<dyn Error>> {
        self.lock.get().write(payload);
        if self.wakes {
            self.lock.get().ring();
        }
        Ok(())
    }
}

pub(super) struct Reader {
    lock: Mapped,
    known: u64,
}

impl Reader {
    pub(super) fn open(place: &Place) -> Result<Self, Box<dyn Error>> {
        Ok(Self { lock: Mapped::open(&place.file("seqlock"))?, known: 0 })
    }
}

impl Receiver for Reader {
    fn take(&mut self) -> Result<Option<(Payload, u64)>, Box<dyn Error>> {
        let Some((known, payload)) = self.lock.get().read(self.known) else { return Ok(None) };
        self.known = known;
        Ok(Some((payload, 1)))
    }

    fn sleep(&mut self, timeout: Duration) -> Result<(), Box<dyn Error>> {
        self.lock.get().sleep(self.known, timeout);
        Ok(())
    }
}
