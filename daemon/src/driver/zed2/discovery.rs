//! Which cameras are plugged in.
//!
//! Identity: zed-open-capture, `include/defines.hpp:73-83`.

use std::ffi::CString;
use std::fmt;
use std::io;

use hidapi::{DeviceInfo, HidApi, HidError};

use super::report::Firmware;

/// USB vendor id of Stereolabs.
pub const VENDOR: u16 = 0x2b03;

/// What stands behind a USB product id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// ZED 2.
    Zed2,
    /// ZED 2i.
    Zed2i,
    /// ZED Mini: other report, other axes; not supported.
    Mini,
}

impl Product {
    /// The product with the USB product id of its sensor unit.
    pub const fn from_id(product_id: u16) -> Option<Self> {
        match product_id {
            0xf781 => Some(Self::Zed2),
            0xf881 => Some(Self::Zed2i),
            0xf681 => Some(Self::Mini),
            _ => None,
        }
    }

    /// The USB product id of the sensor unit.
    pub const fn id(self) -> u16 {
        match self {
            Self::Zed2 => 0xf781,
            Self::Zed2i => 0xf881,
            Self::Mini => 0xf681,
        }
    }
}

impl fmt::Display for Product {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Zed2 => "ZED 2",
            Self::Zed2i => "ZED 2i",
            Self::Mini => "ZED Mini",
        })
    }
}

/// A Stereolabs camera that is plugged in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Which camera it is.
    pub product: Product,
    /// Serial number; `None` if the device gives none in decimal.
    pub serial: Option<u64>,
    /// Version of its sensor firmware; `None` if USB gives none.
    pub firmware: Option<Firmware>,
    /// Its node, `/dev/hidrawN`.
    pub path: CString,
}

impl Found {
    fn from_info(info: &DeviceInfo) -> Option<Self> {
        if info.vendor_id() != VENDOR {
            return None;
        }
        let version = info.release_number();
        Some(Self {
            product: Product::from_id(info.product_id())?,
            serial: info.serial_number().and_then(|text| text.trim().parse().ok()),
            firmware: (version != 0).then_some(Firmware(version)),
            path: info.path().to_owned(),
        })
    }
}

impl fmt::Display for Found {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.serial {
            Some(serial) => write!(out, "{} {serial}", self.product),
            None => write!(out, "{} without a serial number", self.product),
        }
    }
}

/// The cameras that are plugged in, for a message.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Present(pub Vec<Found>);

impl fmt::Display for Present {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return out.write_str("no ZED camera is plugged in (or its USB cable carries no data)");
        }
        out.write_str("plugged in: ")?;
        for (i, camera) in self.0.iter().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(out, "{comma}{camera} ({})", camera.path.to_string_lossy())?;
        }
        Ok(())
    }
}

/// Why a camera could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The list of HID devices could not be read.
    #[error("cannot list the HID devices: {0}")]
    List(HidError),
    /// No camera with this serial number is plugged in.
    #[error("no camera with serial number {serial}; {present}")]
    NotFound {
        /// The serial number looked for.
        serial: u64,
        /// What is there instead.
        present: Present,
    },
    /// The camera with this serial number is another model.
    #[error("camera {serial} is a {product}, which is not supported; supported: ZED 2, ZED 2i")]
    Unsupported {
        /// The serial number looked for.
        serial: u64,
        /// What it is.
        product: Product,
    },
    /// This user may not open the device.
    #[error(
        "permission denied on {path}: the udev rule is missing or this user is not in the group \
         `lodestone`; install config/udev/60-lodestone-zed2.rules and plug the camera in again"
    )]
    Permission {
        /// The device's node.
        path: String,
    },
    /// The device could not be opened for another reason.
    #[error("cannot open {path}: {source}")]
    Open {
        /// The device's node.
        path: String,
        /// What the kernel said.
        source: io::Error,
    },
    /// The device could not be opened for feature reports.
    #[error("cannot open {path} for commands: {source}")]
    Commands {
        /// The device's node.
        path: String,
        /// What hidapi said.
        source: HidError,
    },
    /// The thread that looks after the camera could not be started.
    #[error("cannot start the camera's thread: {0}")]
    Thread(io::Error),
}

/// Lists the cameras that are plugged in, supported or not, by node.
///
/// # Errors
///
/// [`OpenError::List`] if the system's devices cannot be read.
pub fn list() -> Result<Present, OpenError> {
    scan().map(|(_, present)| present)
}

/// As [`list`], with the library's handle, because each new one lists all devices again.
pub(super) fn scan() -> Result<(HidApi, Present), OpenError> {
    let api = HidApi::new().map_err(OpenError::List)?;
    let mut found: Vec<Found> = api.device_list().filter_map(Found::from_info).collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    // A device is listed once per usage that its report descriptor declares.
    found.dedup_by(|a, b| a.path == b.path);
    Ok((api, Present(found)))
}

/// Picks the camera with a serial number.
///
/// # Errors
///
/// [`OpenError::NotFound`] with what there is, or [`OpenError::Unsupported`] for a ZED Mini.
pub fn pick(serial: u64, present: Present) -> Result<Found, OpenError> {
    let Some(at) = present.0.iter().position(|camera| camera.serial == Some(serial)) else {
        return Err(OpenError::NotFound { serial, present });
    };
    let camera = present.0[at].clone();
    match camera.product {
        Product::Zed2 | Product::Zed2i => Ok(camera),
        product @ Product::Mini => Err(OpenError::Unsupported { serial, product }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(product: Product, serial: u64, node: &str) -> Found {
        let path = CString::new(node).unwrap();
        Found { product, serial: Some(serial), firmware: None, path }
    }

    fn three() -> Present {
        Present(vec![
            camera(Product::Zed2, 21, "/dev/hidraw0"),
            camera(Product::Zed2i, 22, "/dev/hidraw1"),
            camera(Product::Mini, 23, "/dev/hidraw2"),
        ])
    }

    #[test]
    fn a_camera_is_picked_by_its_serial_number() {
        assert_eq!(pick(22, three()).unwrap().path.to_str(), Ok("/dev/hidraw1"));
    }

    #[test]
    fn a_missing_serial_number_is_answered_with_what_is_there() {
        let message = pick(99, three()).unwrap_err().to_string();
        for part in ["99", "ZED 2 21 (/dev/hidraw0)", "ZED 2i 22 (/dev/hidraw1)", "ZED Mini 23"] {
            assert!(message.contains(part), "{part} is missing in: {message}");
        }
        let alone = pick(99, Present::default()).unwrap_err().to_string();
        assert!(alone.contains("no ZED camera is plugged in"), "{alone}");
    }

    #[test]
    fn a_mini_is_refused_by_name() {
        let message = pick(23, three()).unwrap_err().to_string();
        assert!(message.contains("camera 23 is a ZED Mini"), "{message}");
    }

    #[test]
    fn product_ids_go_both_ways() {
        for product in [Product::Zed2, Product::Zed2i, Product::Mini] {
            assert_eq!(Product::from_id(product.id()), Some(product));
        }
        assert_eq!(Product::from_id(0xf780), None, "the video half is not the sensor");
    }
}
