//! Input report 0x01 as it lies on the wire: integers, no meaning yet.
//!
//! Little-endian and packed. Source: zed-open-capture, `include/sensorcapture_def.hpp:78-106`.

use super::report::ReportError;

/// Length of the report as the device sends it, bytes (its id is the first one).
pub const REPORT_LEN: usize = 64;

/// Bytes of the report that carry fields.
pub const USED_LEN: usize = 62;

/// The fields of one input report, as sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RawReport {
    /// Offset 0. 1 on ZED 2 and 2i, 0 on ZED Mini.
    pub struct_id: u8,
    /// Offset 1. 1: gyroscope and accelerometer are not valid.
    pub imu_not_valid: u8,
    /// Offset 2. Ticks of 39.0625 µs.
    pub ticks: u64,
    /// Offsets 10, 12, 14. x, y, z in 1000/32768 °/s.
    pub gyro: [i16; 3],
    /// Offsets 16, 18, 20. x, y, z in 8·9.8189/32768 m/s².
    pub accel: [i16; 3],
    /// Offset 22. 1: this sample coincides with an image.
    pub frame_sync: u8,
    /// Offset 23. What the firmware can synchronise.
    pub sync_capabilities: u8,
    /// Offset 24. Images counted by the firmware.
    pub frame_sync_count: u32,
    /// Offset 28. 0.01 °C.
    pub imu_temperature: i16,
    /// Offset 30. 0 absent, 1 old, 2 new.
    pub mag_valid: u8,
    /// Offsets 31, 33, 35. x, y, z in 1/16 µT.
    pub mag: [i16; 3],
    /// Offset 37. 1: the camera moves.
    pub moving: u8,
    /// Offset 38. Times it began to move.
    pub moving_count: u32,
    /// Offset 42. 1: the camera falls.
    pub falling: u8,
    /// Offset 43. Times it fell.
    pub falling_count: u32,
    /// Offset 47. As `mag_valid`, for temperature, pressure and humidity.
    pub env_valid: u8,
    /// Offset 48. 0.01 °C.
    pub temperature: i16,
    /// Offset 50. Firmware ≥ 3.9: 1e-4 hPa, before: 1e-2 hPa.
    pub pressure: u32,
    /// Offset 54. Firmware ≥ 3.9: 0.01 %, before: 1/1024 %.
    pub humidity: u32,
    /// Offsets 58, 60. Left and right image sensor, 0.01 °C; −27315 is not valid.
    pub image_temperature: [i16; 2],
}

impl RawReport {
    /// Takes a report apart. Bytes beyond [`USED_LEN`] are not looked at.
    ///
    /// # Errors
    ///
    /// [`ReportError::TooShort`] below [`USED_LEN`] bytes; any longer input has a reading.
    pub fn parse(bytes: &[u8]) -> Result<Self, ReportError> {
        let Some(wire) = bytes.first_chunk::<USED_LEN>() else {
            return Err(ReportError::TooShort { found: bytes.len() });
        };
        Ok(Self {
            struct_id: wire[0],
            imu_not_valid: wire[1],
            ticks: u64::from_le_bytes(at(wire, 2)),
            gyro: triple(wire, 10),
            accel: triple(wire, 16),
            frame_sync: wire[22],
            sync_capabilities: wire[23],
            frame_sync_count: u32::from_le_bytes(at(wire, 24)),
            imu_temperature: i16::from_le_bytes(at(wire, 28)),
            mag_valid: wire[30],
            mag: triple(wire, 31),
            moving: wire[37],
            moving_count: u32::from_le_bytes(at(wire, 38)),
            falling: wire[42],
            falling_count: u32::from_le_bytes(at(wire, 43)),
            env_valid: wire[47],
            temperature: i16::from_le_bytes(at(wire, 48)),
            pressure: u32::from_le_bytes(at(wire, 50)),
            humidity: u32::from_le_bytes(at(wire, 54)),
            image_temperature: [58, 60].map(|offset| i16::from_le_bytes(at(wire, offset))),
        })
    }

    /// The report as a device sends it; bytes without a field are zero.
    pub fn emit(&self) -> [u8; REPORT_LEN] {
        let mut wire = [0; REPORT_LEN];
        let mut put = |offset: usize, bytes: &[u8]| {
            wire[offset..offset + bytes.len()].copy_from_slice(bytes);
        };
        put(0, &[self.struct_id, self.imu_not_valid]);
        put(2, &self.ticks.to_le_bytes());
        for axis in 0..3 {
            put(10 + 2 * axis, &self.gyro[axis].to_le_bytes());
            put(16 + 2 * axis, &self.accel[axis].to_le_bytes());
            put(31 + 2 * axis, &self.mag[axis].to_le_bytes());
        }
        put(22, &[self.frame_sync, self.sync_capabilities]);
        put(24, &self.frame_sync_count.to_le_bytes());
        put(28, &self.imu_temperature.to_le_bytes());
        put(30, &[self.mag_valid]);
        put(37, &[self.moving]);
        put(38, &self.moving_count.to_le_bytes());
        put(42, &[self.falling]);
        put(43, &self.falling_count.to_le_bytes());
        put(47, &[self.env_valid]);
        put(48, &self.temperature.to_le_bytes());
        put(50, &self.pressure.to_le_bytes());
        put(54, &self.humidity.to_le_bytes());
        put(58, &self.image_temperature[0].to_le_bytes());
        put(60, &self.image_temperature[1].to_le_bytes());
        wire
    }
}

/// `N` bytes from `offset`; every call names a field that lies inside.
fn at<const N: usize>(wire: &[u8; USED_LEN], offset: usize) -> [u8; N] {
    std::array::from_fn(|i| wire[offset + i])
}

/// Three neighbouring `i16`.
fn triple(wire: &[u8; USED_LEN], offset: usize) -> [i16; 3] {
    std::array::from_fn(|axis| i16::from_le_bytes(at(wire, offset + 2 * axis)))
}
