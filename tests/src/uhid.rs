//! A HID device made by a program: `/dev/uhid` (Linux, `include/uapi/linux/uhid.h`).
//!
//! Events are packed structs of fixed layout; they are laid out here byte by byte. The kernel
//! extends a short event with zeros.

use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};

const DESTROY: u32 = 1;
const OPEN: u32 = 4;
const CLOSE: u32 = 5;
const GET_REPORT: u32 = 9;
const GET_REPORT_REPLY: u32 = 10;
const CREATE2: u32 = 11;
const INPUT2: u32 = 12;
const SET_REPORT: u32 = 13;
const SET_REPORT_REPLY: u32 = 14;

const BUS_USB: u16 = 3;

/// Size of `struct uhid_event`.
const EVENT_LEN: usize = 4380;

/// What the device is.
#[derive(Clone, Debug)]
pub struct Description<'a> {
    /// Name, shown as the product.
    pub name: &'a str,
    /// Serial number, as text.
    pub serial: &'a str,
    /// USB vendor id.
    pub vendor: u16,
    /// USB product id.
    pub product: u16,
    /// HID report descriptor.
    pub report_descriptor: &'a [u8],
}

/// What the kernel wants of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Somebody opened it first.
    Opened,
    /// Nobody has it open any more.
    Closed,
    /// Somebody reads a report; answer with [`Device::answer_get`].
    Get {
        /// To be given back with the answer.
        id: u32,
        /// Which report.
        report: u8,
    },
    /// Somebody sends a report; answer with [`Device::answer_set`].
    Set {
        /// To be given back with the answer.
        id: u32,
        /// The report, its number first.
        data: Vec<u8>,
    },
    /// Anything else.
    Other,
}

/// A device that exists for as long as this value.
pub struct Device {
    uhid: File,
}

impl Device {
    /// Plugs a device in.
    ///
    /// # Errors
    ///
    /// The kernel has no uhid, or this user may not use it.
    pub fn create(description: &Description<'_>) -> io::Result<Self> {
        let flags =
            rustix::fs::OFlags::RDWR | rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::CLOEXEC;
        let fd = rustix::fs::open("/dev/uhid", flags, rustix::fs::Mode::empty())?;
        let mut device = Self { uhid: fd.into() };
        device.send(CREATE2, &create2(description))?;
        Ok(device)
    }

    /// Sends an input report, its number first.
    ///
    /// # Errors
    ///
    /// What the kernel says.
    pub fn input(&mut self, report: &[u8]) -> io::Result<()> {
        let mut body = length(report).to_vec();
        body.extend_from_slice(report);
        self.send(INPUT2, &body)
    }

    /// Answers [`Request::Get`] with a report, its number first, or with an error number.
    ///
    /// # Errors
    ///
    /// What the kernel says.
    pub fn answer_get(&mut self, id: u32, answer: Result<&[u8], u16>) -> io::Result<()> {
        let (report, error) = match answer {
            Ok(report) => (report, 0),
            Err(error) => (&[][..], error),
        };
        let mut body = id.to_ne_bytes().to_vec();
        body.extend_from_slice(&error.to_ne_bytes());
        body.extend_from_slice(&length(report));
        body.extend_from_slice(report);
        self.send(GET_REPORT_REPLY, &body)
    }

    /// Answers [`Request::Set`] with an error number; 0 is good.
    ///
    /// # Errors
    ///
    /// What the kernel says.
    pub fn answer_set(&mut self, id: u32, error: u16) -> io::Result<()> {
        let mut body = id.to_ne_bytes().to_vec();
        body.extend_from_slice(&error.to_ne_bytes());
        self.send(SET_REPORT_REPLY, &body)
    }

    /// The next thing the kernel wants; `None` if there is nothing now.
    ///
    /// # Errors
    ///
    /// What the kernel says.
    pub fn next_request(&mut self) -> io::Result<Option<Request>> {
        let mut event = vec![0; EVENT_LEN];
        match self.uhid.read(&mut event) {
            Ok(_) => Ok(Some(request(&event))),
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn send(&mut self, kind: u32, body: &[u8]) -> io::Result<()> {
        let mut event = kind.to_ne_bytes().to_vec();
        event.extend_from_slice(body);
        self.uhid.write_all(&event)
    }
}

impl AsFd for Device {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.uhid.as_fd()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // Closing the file destroys the device as well.
        let _ = self.send(DESTROY, &[]);
    }
}

fn length(report: &[u8]) -> [u8; 2] {
    u16::try_from(report.len()).expect("a report below 64 KiB").to_ne_bytes()
}

/// `struct uhid_create2_req`.
fn create2(description: &Description<'_>) -> Vec<u8> {
    let mut body = text::<128>(description.name).to_vec();
    body.extend_from_slice(&text::<64>("virtual"));
    body.extend_from_slice(&text::<64>(description.serial));
    body.extend_from_slice(&length(description.report_descriptor));
    body.extend_from_slice(&BUS_USB.to_ne_bytes());
    let (version, country) = (0, 0);
    for number in [description.vendor.into(), description.product.into(), version, country] {
        body.extend_from_slice(&u32::to_ne_bytes(number));
    }
    body.extend_from_slice(description.report_descriptor);
    body
}

/// A text in a fixed field, cut so that a zero ends it.
fn text<const N: usize>(text: &str) -> [u8; N] {
    let mut field = [0; N];
    for (to, from) in field.iter_mut().zip(text.bytes().take(N - 1)) {
        *to = from;
    }
    field
}

fn request(event: &[u8]) -> Request {
    let word = |at: usize| u32::from_ne_bytes([0, 1, 2, 3].map(|i| event[at + i]));
    match word(0) {
        OPEN => Request::Opened,
        CLOSE => Request::Closed,
        GET_REPORT => Request::Get { id: word(4), report: event[8] },
        SET_REPORT => {
            let size = usize::from(u16::from_ne_bytes([event[10], event[11]]));
            let data = event[12..].iter().copied().take(size).collect();
            Request::Set { id: word(4), data }
        }
        _ => Request::Other,
    }
}
