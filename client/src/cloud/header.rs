//! What is true of a whole cloud, checked.

use lodestone_schema::{CloudFields, CloudFrame, CloudHeader};

use super::error::CloudHeaderError;

/// A cloud's header whose numbers agree with each other and with the points.
///
/// ```
/// use lodestone_client::{CloudHeader, CloudInfo};
///
/// let header = CloudHeader { width: 640, height: 480, time_ns: 1, ..CloudHeader::default() };
/// assert!(CloudInfo::check(&header, 640 * 480).unwrap().is_organised());
/// assert!(CloudInfo::check(&header, 1000).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudInfo {
    header: CloudHeader,
    frame: CloudFrame,
    fields: CloudFields,
}

impl CloudInfo {
    /// Checks a header against the number of points that came with it.
    ///
    /// # Errors
    /// [`CloudHeaderError`].
    pub fn check(header: &CloudHeader, points: usize) -> Result<Self, CloudHeaderError> {
        let CloudHeader { width, height, time_ns, .. } = *header;
        if height == 0 {
            return Err(CloudHeaderError::NoRow);
        }
        // Two u32 multiply without overflow in u64.
        if u64::from(width) * u64::from(height) != points as u64 {
            return Err(CloudHeaderError::PointCount { width, height, points });
        }
        if time_ns < 0 {
            return Err(CloudHeaderError::NegativeTime(time_ns));
        }
        let sigma = header.depth_sigma_per_m;
        if sigma < 0.0 || sigma.is_infinite() {
            return Err(CloudHeaderError::DepthSigma);
        }
        let frame = CloudFrame::from_code(header.frame)
            .ok_or(CloudHeaderError::UnknownFrame(header.frame))?;
        let fields = CloudFields::from_bits(header.fields)
            .ok_or(CloudHeaderError::UnknownFields(header.fields))?;
        Ok(Self { header: *header, frame, fields })
    }

    /// The header as it came.
    pub const fn message(&self) -> &CloudHeader {
        &self.header
    }

    /// Number of the cloud within its source.
    pub const fn sequence(&self) -> u64 {
        self.header.sequence
    }

    /// When the cloud was seen, `CLOCK_MONOTONIC`, ns.
    pub const fn time_ns(&self) -> i64 {
        self.header.time_ns
    }

    /// When it was handed to the transport, `CLOCK_MONOTONIC`, ns.
    pub const fn published_time_ns(&self) -> i64 {
        self.header.published_time_ns
    }

    /// Points in a row.
    pub const fn width(&self) -> u32 {
        self.header.width
    }

    /// Rows.
    pub const fn height(&self) -> u32 {
        self.header.height
    }

    /// Whether the points lie row by row as in an image.
    pub const fn is_organised(&self) -> bool {
        self.header.height > 1
    }

    /// The frame of the points.
    pub const fn frame(&self) -> CloudFrame {
        self.frame
    }

    /// Whether points have a colour.
    pub const fn has_colour(&self) -> bool {
        self.fields.contains(CloudFields::COLOUR)
    }

    /// Whether points have times of their own.
    pub const fn has_point_time(&self) -> bool {
        self.fields.contains(CloudFields::POINT_TIME)
    }

    /// Standard deviation of a depth over the square of that depth, 1/m; `None` if not known.
    pub fn depth_sigma_per_m(&self) -> Option<f32> {
        Some(self.header.depth_sigma_per_m).filter(|sigma| !sigma.is_nan())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const GOOD: CloudHeader = CloudHeader {
        sequence: 3,
        time_ns: 10,
        published_time_ns: 20,
        width: 4,
        height: 3,
        fields: 0b11,
        depth_sigma_per_m: f32::NAN,
        frame: 0,
        reserved: [0; 7],
    };

    fn refused(header: CloudHeader) -> CloudHeaderError {
        CloudInfo::check(&header, 12).expect_err("is not sound")
    }

    #[test]
    fn a_sound_header_says_what_its_points_have() {
        let info = CloudInfo::check(&GOOD, 12).unwrap();
        assert!(info.is_organised() && info.has_colour() && info.has_point_time());
        assert_eq!((info.frame(), info.depth_sigma_per_m()), (CloudFrame::Optical, None));
    }

    #[test]
    fn each_thing_that_cannot_be_is_refused_by_name() {
        assert_eq!(refused(CloudHeader { height: 0, ..GOOD }), CloudHeaderError::NoRow);
        assert_eq!(refused(CloudHeader { frame: 2, ..GOOD }), CloudHeaderError::UnknownFrame(2));
        assert_eq!(refused(CloudHeader { fields: 4, ..GOOD }), CloudHeaderError::UnknownFields(4));
        assert_eq!(
            refused(CloudHeader { time_ns: -1, ..GOOD }),
            CloudHeaderError::NegativeTime(-1)
        );
        let sigma = refused(CloudHeader { depth_sigma_per_m: -0.1, ..GOOD });
        assert_eq!(sigma, CloudHeaderError::DepthSigma);
        // 65536 * 65536 is 0 in 32 bits.
        let header = CloudHeader { width: 65_536, height: 65_536, ..GOOD };
        assert!(CloudInfo::check(&header, 0).is_err());
    }

    proptest! {
        #[test]
        fn no_header_panics(
            (width, height, fields, frame) in any::<(u32, u32, u32, u8)>(),
            (time_ns, sigma, points) in any::<(i64, f32, usize)>(),
        ) {
            let header = CloudHeader {
                width, height, fields, frame, time_ns, depth_sigma_per_m: sigma, ..GOOD
            };
            if let Ok(info) = CloudInfo::check(&header, points) {
                prop_assert_eq!(info.width() as usize * info.height() as usize, points);
            }
        }
    }
}
