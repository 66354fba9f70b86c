//! What the peers carry: as many bytes as a pose, with the stamp that is measured.

use lodestone_schema::Pose;

/// 64-bit words of a pose.
pub const WORDS: usize = size_of::<Pose>() / 8;

/// A message of a peer.
pub type Payload = [u64; WORDS];

const _: () = assert!(size_of::<Payload>() == size_of::<Pose>(), "the same size as a pose");

const SEQUENCE: usize = 0;
const PUBLISHED: usize = 1;

/// The message with this number, handed to the transport at this time.
pub const fn payload(sequence: u64, published_ns: i64) -> Payload {
    // Words that differ from message to message: nothing can be saved on them.
    let mut words = [sequence.wrapping_mul(0x9E37_79B9_7F4A_7C15); WORDS];
    words[SEQUENCE] = sequence;
    words[PUBLISHED] = published_ns.cast_unsigned();
    words
}

/// Its number.
pub const fn sequence(payload: &Payload) -> u64 {
    payload[SEQUENCE]
}

/// When it was handed to the transport, `CLOCK_MONOTONIC`, ns.
pub const fn published_ns(payload: &Payload) -> i64 {
    payload[PUBLISHED].cast_signed()
}

/// As bytes on a wire.
pub fn to_bytes(payload: &Payload) -> [u8; size_of::<Payload>()] {
    let mut bytes = [0; size_of::<Payload>()];
    for (place, word) in bytes.chunks_exact_mut(8).zip(payload) {
        place.copy_from_slice(&word.to_le_bytes());
    }
    bytes
}

/// From a wire; `None` if the length is wrong.
pub fn from_bytes(bytes: &[u8]) -> Option<Payload> {
    let words = bytes.chunks_exact(8).map(|w| u64::from_le_bytes(w.try_into().unwrap_or_default()));
    let mut payload = [0; WORDS];
    if bytes.len() != size_of::<Payload>() {
        return None;
    }
    payload.iter_mut().zip(words).for_each(|(place, word)| *place = word);
    Some(payload)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_survives_the_wire() {
        let sent = payload(7, -9);
        assert_eq!((sequence(&sent), published_ns(&sent)), (7, -9));
        assert_eq!(from_bytes(&to_bytes(&sent)), Some(sent));
        assert_eq!(from_bytes(&to_bytes(&sent)[1..]), None);
    }
}
