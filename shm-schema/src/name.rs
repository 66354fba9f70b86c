//! Names inside messages: UTF-8 in a field of fixed size, filled up with zero bytes.

/// Room for a name in a message, bytes: a camera's name, a slash and the part of the camera fit.
pub const NAME_BYTES: usize = 64;

/// A text as the field of a message; `None` if it is too long or holds a zero byte.
///
/// ```
/// use lodestone_schema::{name_of, to_name};
/// let field = to_name("front/optical").unwrap();
/// assert_eq!(name_of(&field), Some("front/optical"));
/// assert!(to_name(&"x".repeat(65)).is_none());
/// ```
pub fn to_name(text: &str) -> Option<[u8; NAME_BYTES]> {
    let mut field = [0; NAME_BYTES];
    field.get_mut(..text.len())?.copy_from_slice(text.as_bytes());
    (!text.as_bytes().contains(&0)).then_some(field)
}

/// The text in a field; `None` if it is not UTF-8 followed by zero bytes only.
pub fn name_of(field: &[u8; NAME_BYTES]) -> Option<&str> {
    let length = field.iter().position(|&byte| byte == 0).unwrap_or(NAME_BYTES);
    let (text, rest) = field.split_at(length);
    rest.iter().all(|&byte| byte == 0).then(|| core::str::from_utf8(text).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_fills_its_field_is_read_back_and_bytes_after_the_end_are_refused() {
        let full = "x".repeat(NAME_BYTES);
        assert_eq!(name_of(&to_name(&full).unwrap()), Some(&*full));
        assert_eq!(name_of(&[0; NAME_BYTES]), Some(""));
        let mut torn = to_name("front").unwrap();
        torn[9] = b'x';
        assert_eq!(name_of(&torn), None);
        assert_eq!(name_of(&[0xff; NAME_BYTES]), None);
    }
}
