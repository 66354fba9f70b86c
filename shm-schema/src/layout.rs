//! Compile-time proof of where each byte lies.

/// Asserts the size of a message and the offset of each of its fields, and that no byte belongs to
/// none of them: neither padding, whose content is undefined, nor a field that is not named here.
///
/// A consumer in another language relies on these numbers, so a change that moves a field must
/// fail to compile here and be answered with a new [`crate::SCHEMA_VERSION`].
macro_rules! assert_layout {
    ($type:ty, size = $size:literal, $($fields:tt)+) => {
        crate::layout::assert_layout!($type, align = 8, size = $size, $($fields)+);
    };
    ($type:ty, align = $align:literal, size = $size:literal, $($field:ident = $offset:literal),+ $(,)?) => {
        const _: () = {
            assert!(core::mem::size_of::<$type>() == $size);
            assert!(core::mem::align_of::<$type>() == $align);
            $(assert!(core::mem::offset_of!($type, $field) == $offset);)+
            let in_fields = 0 $(+ crate::layout::size_of_field(|m: &$type| &m.$field))+;
            assert!(in_fields == $size, "bytes that belong to no named field");
        };
    };
}

pub(crate) use assert_layout;

/// Size of the field that a projection points at, bytes.
pub(crate) const fn size_of_field<M, F>(_: fn(&M) -> &F) -> usize {
    size_of::<F>()
}

#[cfg(test)]
mod tests {
    use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

    use crate::{
        Aiding, CalibratedSample, CloudHeader, CloudPoint, Health, Pose, Relative, Request,
        SCHEMA_VERSION, ServiceKind, StaticTransform, WORLD_NAME, World, camera_of, is_camera_name,
        version_of,
    };

    /// The name that iceoryx2 compares.
    #[allow(unsafe_code, reason = "the transport declares it so")]
    fn transport_name<T: ZeroCopySend>() -> &'static str {
        // SAFETY: the caller's duty is that equal names mean equal layouts; this only reads one.
        unsafe { <T as ZeroCopySend>::type_name() }
    }

    #[test]
    fn every_type_name_bears_the_schema_version() {
        let named = |message: &str| format!("lodestone.v{SCHEMA_VERSION}.{message}");
        assert_eq!(transport_name::<Pose>(), named("Pose"));
        assert_eq!(transport_name::<CalibratedSample>(), named("CalibratedSample"));
        assert_eq!(transport_name::<Health>(), named("Health"));
        assert_eq!(transport_name::<Aiding>(), named("Aiding"));
        assert_eq!(transport_name::<CloudHeader>(), named("CloudHeader"));
        assert_eq!(transport_name::<CloudPoint>(), named("CloudPoint"));
        assert_eq!(transport_name::<World>(), named("World"));
        assert_eq!(transport_name::<Relative>(), named("Relative"));
        assert_eq!(transport_name::<StaticTransform>(), named("StaticTransform"));
        assert_eq!(transport_name::<Request>(), named("Request"));
    }

    #[test]
    fn every_service_name_bears_the_schema_version_and_the_camera() {
        let of_lane = ServiceKind::OF_LANE.map(|kind| (kind, "front"));
        let of_depth_source = [(ServiceKind::Cloud, "front")];
        let of_daemon = ServiceKind::OF_DAEMON.map(|kind| (kind, WORLD_NAME));
        for (kind, whose) in of_lane.into_iter().chain(of_depth_source).chain(of_daemon) {
            let name = kind.of(whose).to_string();
            assert_eq!(version_of(&name), Some(SCHEMA_VERSION), "{name}");
            assert_eq!(camera_of(&name, kind), Some(whose), "{name}");
        }
        assert!(!is_camera_name(WORLD_NAME), "a camera could take the daemon's own services");
    }
}
