//! Lines of bounded length out of a byte stream, in one reused buffer.

use std::io::{self, BufRead, BufReader, Read};

/// Longest line that is read; a longer one is skipped and reported.
pub const MAX_LINE_BYTES: usize = 64 * 1024;

const BUFFER_BYTES: usize = 64 * 1024;

/// One line.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Line<'a> {
    /// Its bytes without the line end.
    Text(&'a [u8]),
    /// It is longer than [`MAX_LINE_BYTES`]; the reader stands behind it.
    TooLong,
}

/// Reads lines ending in LF or CRLF.
#[derive(Debug)]
pub(super) struct LineReader<R> {
    reader: BufReader<R>,
    line: Vec<u8>,
    number: u64,
}

impl<R: Read> LineReader<R> {
    pub(super) fn new(source: R) -> Self {
        let line = Vec::with_capacity(MAX_LINE_BYTES + 2);
        Self { reader: BufReader::with_capacity(BUFFER_BYTES, source), line, number: 0 }
    }

    /// Number of the line read last, from 1.
    pub(super) const fn number(&self) -> u64 {
        self.number
    }

    /// The next line; `None` at the end.
    pub(super) fn next_line(&mut self) -> io::Result<Option<Line<'_>>> {
        const LIMIT: u64 = MAX_LINE_BYTES as u64 + 2;
        self.line.clear();
        (&mut self.reader).take(LIMIT).read_until(b'\n', &mut self.line)?;
        if self.line.is_empty() {
            return Ok(None);
        }
        self.number += 1;
        let ended = self.line.last() == Some(&b'\n');
        let text = without_line_end(&self.line);
        if text.len() <= MAX_LINE_BYTES {
            return Ok(Some(Line::Text(text)));
        }
        if !ended {
            self.reader.skip_until(b'\n')?;
        }
        Ok(Some(Line::TooLong))
    }
}

fn without_line_end(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(input: &[u8]) -> Vec<Option<Vec<u8>>> {
        let mut reader = LineReader::new(input);
        let mut all = Vec::new();
        while let Some(line) = reader.next_line().unwrap() {
            all.push(match line {
                Line::Text(text) => Some(text.to_vec()),
                Line::TooLong => None,
            });
        }
        assert_eq!(reader.number(), all.len() as u64);
        all
    }

    #[test]
    fn line_ends_of_both_kinds_and_a_last_line_without_one() {
        let expected = [Some(b"a".to_vec()), Some(b"".to_vec()), Some(b"b".to_vec())];
        assert_eq!(lines(b"a\r\n\nb"), expected);
        assert_eq!(lines(b"a\n\r\nb\n"), expected);
        assert_eq!(lines(b""), []);
    }

    #[test]
    fn a_line_at_the_limit_is_read_and_a_longer_one_is_skipped_whole() {
        for end in ["\n", "\r\n"] {
            for excess in [0, 1, 2, 100_000] {
                let long = vec![b'x'; MAX_LINE_BYTES + excess];
                let input = [&long, end.as_bytes(), b"next"].concat();
                let expected = (excess == 0).then_some(long);
                assert_eq!(lines(&input), [expected, Some(b"next".to_vec())]);
            }
        }
    }
}
