//! A Unix datagram socket: one system call and one copy at each end.

use std::error::Error;
use std::io::ErrorKind;
use std::os::unix::net::UnixDatagram;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::time::Timespec;

use super::super::payload::{Payload, from_bytes, to_bytes};
use super::{Place, Receiver as Receives, Sender as Sends};

const NAME: &str = "datagram";

pub(super) struct Sender {
    socket: UnixDatagram,
    to: std::path::PathBuf,
}

impl Sender {
    pub(super) fn open(place: &Place) -> Result<Self, Box<dyn Error>> {
        let socket = UnixDatagram::unbound()?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, to: place.socket(NAME) })
    }
}

impl Sends for Sender {
    fn send(&mut self, payload: &Payload) -> Result<(), Box<dyn Error>> {
        match self.socket.send_to(&to_bytes(payload), &self.to) {
            // Nobody there yet or any more, or its queue is full: lost, as the consumer counts.
            Err(error) if is_nobody(error.kind()) => Ok(()),
            sent => Ok(sent.map(|_| ())?),
        }
    }
}

const fn is_nobody(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::NotFound | ErrorKind::ConnectionRefused | ErrorKind::WouldBlock)
}

pub(super) struct Receiver(UnixDatagram);

impl Receiver {
    pub(super) fn open(place: &Place) -> Result<Self, Box<dyn Error>> {
        let socket = UnixDatagram::bind(place.socket(NAME))?;
        socket.set_nonblocking(true)?;
        Ok(Self(socket))
    }
}

impl Receives for Receiver {
    fn take(&mut self) -> Result<Option<(Payload, u64)>, Box<dyn Error>> {
        let mut bytes = [0; size_of::<Payload>()];
        let (mut newest, mut count) = (None, 0);
        loop {
            match self.0.recv(&mut bytes) {
                Ok(length) => {
                    newest = from_bytes(&bytes[..length]);
                    count += 1;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    return Ok(newest.map(|payload| (payload, count)));
                }
                Err(error) => return Err(error.into()),
            }
        }
    }

    fn sleep(&mut self, timeout: Duration) -> Result<(), Box<dyn Error>> {
        let timeout = Timespec::try_from(timeout)?;
        poll(&mut [PollFd::new(&self.0, PollFlags::IN)], Some(&timeout))?;
        Ok(())
    }
}
