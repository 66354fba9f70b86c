//! The bytes of a recording: a plain file, or one decompressed as it is read.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

use super::error::RecordingError;

/// First bytes of a Zstandard frame (RFC 8878, 3.1.1), the number in little-endian order.
const ZSTD_MAGIC: [u8; 4] = 0xFD2F_B528_u32.to_le_bytes();

/// Last three bytes of the magic number of a frame to be skipped (RFC 8878, 3.1.2).
const SKIPPABLE_MAGIC_END: [u8; 3] = [0x2A, 0x4D, 0x18];

/// Where the text of a recording comes from.
pub(super) enum Source {
    Plain(BufReader<File>),
    Zstd(Box<ZstdFrames<BufReader<File>>>),
}

impl std::fmt::Debug for Source {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::Plain(_) => "Plain",
            Self::Zstd(_) => "Zstd",
        })
    }
}

impl Source {
    pub(super) fn open(path: &Path) -> Result<Self, RecordingError> {
        let unreadable = |source| RecordingError::Unreadable { path: path.to_path_buf(), source };
        let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
        let start = file.fill_buf().map_err(unreadable)?;
        if is_zstd(start) {
            return Ok(Self::Zstd(Box::new(ZstdFrames::new(file))));
        }
        let promised = path.extension().is_some_and(|extension| extension == "zst");
        if promised && !start.is_empty() {
            return Err(RecordingError::NotZstandard { path: path.to_path_buf() });
        }
        Ok(Self::Plain(file))
    }
}

impl Read for Source {
    fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(file) => file.read(target),
            Self::Zstd(frames) => frames.read(target),
        }
    }
}

fn is_zstd(start: &[u8]) -> bool {
    start.starts_with(&ZSTD_MAGIC) || start.get(1..4) == Some(&SKIPPABLE_MAGIC_END)
}

/// Decompresses all frames of a stream, one after the other, and checks their checksums.
///
/// `ruzstd`'s own streaming decoder ends after the first frame and ignores the checksum. Its frame
/// decoder keeps back what the frame's window may still refer to (up to 8 MiB at usual levels):
/// where the data are cut short, so much of what precedes the cut is lost with them.
pub(super) struct ZstdFrames<R> {
    source: R,
    decoder: FrameDecoder,
    checked: bool,
}

impl<R: BufRead> ZstdFrames<R> {
    pub(super) fn new(source: R) -> Self {
        Self { source, decoder: FrameDecoder::new(), checked: true }
    }

    /// Opens the next frame; `false` at the end of the stream.
    fn next_frame(&mut self) -> io::Result<bool> {
        while !self.source.fill_buf()?.is_empty() {
            match self.decoder.reset(&mut self.source) {
                Ok(()) => {
                    self.checked = false;
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => skip(&mut self.source, u64::from(length))?,
                Err(error) => return Err(damaged(&error)),
            }
        }
        Ok(false)
    }

    fn check(&mut self) -> io::Result<()> {
        let stated = self.decoder.get_checksum_from_data();
        if !self.checked && stated.is_some() && stated != self.decoder.get_calculated_checksum() {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "Zstandard: checksum of the content is wrong",
            ));
        }
        self.checked = true;
        Ok(())
    }
}

impl<R: BufRead> Read for ZstdFrames<R> {
    fn read(&mut self, target: &mut [u8]) -> io::Result<usize> {
        while self.decoder.can_collect() == 0 {
            if self.decoder.is_finished() {
                self.check()?;
                if !self.next_frame()? {
                    return Ok(0);
                }
            } else {
                self.decoder
                    .decode_blocks(&mut self.source, BlockDecodingStrategy::UptoBlocks(1))
                    .map_err(|error| damaged(&error))?;
            }
        }
        self.decoder.read(target)
    }
}

fn skip(source: &mut impl BufRead, length: u64) -> io::Result<()> {
    let skipped = io::copy(&mut source.take(length), &mut io::sink())?;
    if skipped < length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(())
}

fn damaged(error: &FrameDecoderError) -> io::Error {
    let text = format!("Zstandard data damaged or cut short: {error}");
    io::Error::new(io::ErrorKind::InvalidData, text)
}
