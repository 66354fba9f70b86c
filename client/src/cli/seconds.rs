//! Times on the command line, read without rounding: a double holds UNIX time to 0.2 µs only.

use core::time::Duration;

/// An instant, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Instant(pub(super) i64);

/// Longest wait that makes sense to ask for, s: a year.
const LONGEST_S: u64 = 366 * 24 * 3600;

/// Takes decimal seconds with at most nine digits after the point, or nanoseconds with `ns`.
pub(super) fn instant(text: &str) -> Result<Instant, String> {
    let nanos = match text.strip_suffix("ns") {
        Some(nanos) => digits(nanos),
        None => decimal_seconds(text),
    };
    nanos.map(Instant).ok_or_else(|| {
        "allowed: seconds with up to 9 decimals (12.345678901) or nanoseconds (12345678901ns), not negative".into()
    })
}

/// Takes decimal seconds from 0 to a year.
pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let nanos = decimal_seconds(text).and_then(|nanos| u64::try_from(nanos).ok());
    let duration = nanos.map(Duration::from_nanos).filter(|d| d.as_secs() <= LONGEST_S);
    duration.ok_or_else(|| format!("allowed: seconds from 0 to {LONGEST_S}, with up to 9 decimals"))
}

fn decimal_seconds(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, "0"));
    if fraction.len() > 9 {
        return None;
    }
    let scale = 10_i64.pow(9 - fraction.len() as u32);
    let fraction_ns = digits(fraction)?.checked_mul(scale)?;
    digits(whole)?.checked_mul(1_000_000_000)?.checked_add(fraction_ns)
}

fn digits(text: &str) -> Option<i64> {
    let all_digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if all_digits { text.parse().ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_nanosecond_counts() {
        assert_eq!(instant("1700000000.123456789"), Ok(Instant(1_700_000_000_123_456_789)));
        assert_eq!(instant("1700000000123456789ns"), Ok(Instant(1_700_000_000_123_456_789)));
        assert_eq!(instant("12"), Ok(Instant(12_000_000_000)));
        assert_eq!(instant("0.5"), Ok(Instant(500_000_000)));
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in [
            "",
            ".",
            "1.",
            ".5",
            "-1",
            "+1",
            "1e3",
            "NaN",
            "1.0000000001",
            "ns",
            "99999999999999999999",
            "9999999999999.0",
        ] {
            assert!(instant(text).is_err(), "{text}");
        }
        assert!(duration("1000000000").is_err());
        assert_eq!(duration("0.1"), Ok(Duration::from_millis(100)));
    }
}
