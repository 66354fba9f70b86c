//! Compile-time proof of where each byte lies.

/// Asserts the size of a message and the offset of each named field.
///
/// A consumer in another language relies on these numbers, so a change that moves a field must
/// fail to compile here and be answered with a new [`crate::SCHEMA_VERSION`].
macro_rules! assert_layout {
    ($type:ty, size = $size:literal, $($field:ident = $offset:literal),+ $(,)?) => {
        const _: () = {
            assert!(core::mem::size_of::<$type>() == $size);
            assert!(core::mem::align_of::<$type>() == 8);
            $(assert!(core::mem::offset_of!($type, $field) == $offset);)+
        };
    };
}

pub(crate) use assert_layout;
