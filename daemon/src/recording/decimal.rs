//! Seconds in decimal text to integer nanoseconds.

/// First magnitude that is refused; nanoseconds of all below it fit into an `i64`.
const LARGEST_SECONDS: f64 = 9e9;

const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// Nanoseconds of a decimal number of seconds; `None` if it is no number or beyond ±9e9.
///
/// Plain notation is exact, rounded half away from zero at the ninth decimal; notation with an
/// exponent goes through `f64` and is good to the nanosecond up to 1e6 s.
pub(super) fn seconds_to_nanos(text: &[u8]) -> Option<i64> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] | rest => (false, rest),
    };
    let magnitude = plain(digits).or_else(|| with_exponent(digits))?;
    Some(if negative { -magnitude } else { magnitude })
}

fn plain(digits: &[u8]) -> Option<i64> {
    let point = digits.iter().position(|&byte| byte == b'.').unwrap_or(digits.len());
    let whole = &digits[..point];
    let fraction = digits.get(point + 1..).unwrap_or_default();
    if whole.is_empty() && fraction.is_empty() {
        return None;
    }
    let seconds = natural(whole)?;
    let nanos = fraction_nanos(fraction)?;
    let in_range = seconds < LARGEST_SECONDS as i64;
    in_range.then(|| seconds * NANOS_PER_SECOND + nanos)
}

/// A number of at most 18 digits.
fn natural(digits: &[u8]) -> Option<i64> {
    if digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(digits.iter().fold(0, |sum, &digit| sum * 10 + i64::from(digit - b'0')))
}

fn fraction_nanos(digits: &[u8]) -> Option<i64> {
    let (kept, rest) = digits.split_at(digits.len().min(9));
    if !rest.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let scale = 10_i64.pow(9 - kept.len() as u32);
    let round_up = rest.first().is_some_and(|&digit| digit >= b'5');
    Some(natural(kept)? * scale + i64::from(round_up))
}

fn with_exponent(digits: &[u8]) -> Option<i64> {
    let first_is_digit = digits.first().is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.');
    let seconds: f64 = std::str::from_utf8(digits).ok()?.parse().ok()?;
    let in_range = seconds < LARGEST_SECONDS;
    (first_is_digit && in_range).then_some((seconds * NANOS_PER_SECOND as f64).round() as i64)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn plain_notation_is_exact_and_rounds_at_the_ninth_decimal() {
        for (text, nanos) in [
            ("0", 0),
            ("0.003500", 3_500_000),
            ("-1.5", -1_500_000_000),
            ("+2.", 2_000_000_000),
            (".25", 250_000_000),
            ("1700000000.123456789", 1_700_000_000_123_456_789),
            ("0.0000000004", 0),
            ("0.0000000005", 1),
            ("0.9999999999", 1_000_000_000),
            ("8999999999.9999999999", 9_000_000_000_000_000_000),
            ("1e-3", 1_000_000),
            ("2.5E2", 250_000_000_000),
        ] {
            assert_eq!(seconds_to_nanos(text.as_bytes()), Some(nanos), "{text}");
        }
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in ["", ".", "-", "+-1", "--1", "nan", "inf", "-inf", "9e9", "9000000000", "1e300"]
        {
            assert_eq!(seconds_to_nanos(text.as_bytes()), None, "{text}");
        }
        for text in [
            "1,5",
            "1.2.3",
            "0x10",
            "1 2",
            "12s",
            "1e",
            "99999999999999999999",
            "999999999999999999",
        ] {
            assert_eq!(seconds_to_nanos(text.as_bytes()), None, "{text}");
        }
        assert_eq!(seconds_to_nanos(b"1.\xFF"), None);
    }

    proptest! {
        #[test]
        fn printed_nanoseconds_come_back(nanos in -9_000_000_000_000_000_000_i64..9_000_000_000_000_000_000) {
            let sign = if nanos < 0 { "-" } else { "" };
            let size = nanos.unsigned_abs();
            let text = format!("{sign}{}.{:09}", size / 1_000_000_000, size % 1_000_000_000);
            prop_assert_eq!(seconds_to_nanos(text.as_bytes()), Some(nanos));
        }
    }
}
