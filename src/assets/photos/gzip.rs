//! Gzip files (RFC 1952). Their one deflated stream is handed to the zip reader as the one entry of an archive.

use std::io::{Cursor, Read as _};

use super::super::budget::Budget;
use super::super::error::Fault;

/// Bytes of the fixed header and of the trailer (checksum, size).
const HEADER: usize = 10;
const TRAILER: usize = 8;
/// Header flags: header checksum, extra field, name, comment.
const HEADER_CHECK: u8 = 2;
const EXTRA: u8 = 4;
const NAME: u8 = 8;
const COMMENT: u8 = 16;
/// Name of the entry.
const ENTRY: &[u8] = b"data";

/// Whether it begins as gzip's deflate does.
pub(super) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b, 8])
}

/// The unpacked bytes, at most `limit`; length and checksum are checked.
pub(super) fn unpack(bytes: &[u8], limit: u64) -> Result<Vec<u8>, Fault> {
    let damaged = |what: String| Fault::malformed("the gzip stream", what);
    let start = stream_start(bytes).ok_or_else(|| damaged("its header is cut off".into()))?;
    let end = bytes.len().checked_sub(TRAILER).filter(|end| *end >= start);
    let end = end.ok_or_else(|| damaged("its end is cut off".into()))?;
    let word = |at: usize| [0, 1, 2, 3].map(|i| bytes[at + i]);
    let (check, size) = (word(end), word(end + 4));
    Budget::check("the gzip stream", "unpacked bytes", u64::from(u32::from_le_bytes(size)), limit)?;
    let archive = as_zip(&bytes[start..end], check, size).ok_or_else(|| damaged("it is too long".into()))?;
    let mut archive = zip::ZipArchive::new(Cursor::new(archive)).map_err(|e| damaged(e.to_string()))?;
    let entry = archive.by_index(0).map_err(|e| damaged(e.to_string()))?;
    let mut unpacked = Vec::new();
    entry.take(limit + 1).read_to_end(&mut unpacked).map_err(|e| damaged(e.to_string()))?;
    Budget::check("the gzip stream", "unpacked bytes", unpacked.len() as u64, limit)?;
    Ok(unpacked)
}

/// Where the deflated stream begins.
fn stream_start(bytes: &[u8]) -> Option<usize> {
    let flags = *bytes.get(3)?;
    let mut at = HEADER;
    if flags & EXTRA != 0 {
        at += 2 + usize::from(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]));
    }
    for text in [NAME, COMMENT] {
        if flags & text != 0 {
            at += bytes.get(at..)?.iter().position(|b| *b == 0)? + 1;
        }
    }
    if flags & HEADER_CHECK != 0 {
        at += 2;
    }
    (at <= bytes.len()).then_some(at)
}

/// A zip archive of one deflated entry; `None` beyond the format's 4 GiB.
fn as_zip(stream: &[u8], check: [u8; 4], size: [u8; 4]) -> Option<Vec<u8>> {
    const VERSION: [u8; 2] = [20, 0];
    const DEFLATED: [u8; 2] = [8, 0];
    // 1 January 1980, 00:00.
    const TIME: [u8; 4] = [0, 0, 0x21, 0];
    let packed = u32::try_from(stream.len()).ok()?.to_le_bytes();
    let name = u16::try_from(ENTRY.len()).ok()?.to_le_bytes();
    let common = [&VERSION[..], &[0, 0], &DEFLATED, &TIME, &check, &packed, &size, &name, &[0, 0]].concat();
    let mut archive = [&b"PK\x03\x04"[..], &common, ENTRY, stream].concat();
    let directory = u32::try_from(archive.len()).ok()?;
    // Comment length, disk, internal and external attributes, offset of the entry.
    let entry = [&b"PK\x01\x02"[..], &VERSION, &common, &[0; 14], ENTRY].concat();
    let length = u32::try_from(entry.len()).ok()?;
    archive.extend(entry);
    let one = 1_u16.to_le_bytes();
    let (length, directory) = (length.to_le_bytes(), directory.to_le_bytes());
    archive.extend([&b"PK\x05\x06"[..], &[0; 4], &one, &one, &length, &directory, &[0, 0]].concat());
    Some(archive)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `printf 'hello hello hello\n' | gzip -9n`.
    const HELLO: [u8; 29] = [
        0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0xcb, 0x48, 0xcd, 0xc9, 0xc9, 0x57, 0xc8,
        0x40, 0x90, 0x5c, 0x00, 0x3b, 0x7c, 0x8a, 0xdf, 0x12, 0x00, 0x00, 0x00,
    ];

    #[test]
    fn a_stream_is_unpacked_and_a_damaged_one_refused() {
        assert_eq!(unpack(&HELLO, 100).expect("sound"), b"hello hello hello\n");
        assert!(unpack(&HELLO, 10).expect_err("too long").problem.to_string().contains("limit"));
        let mut damaged = HELLO;
        damaged[21] ^= 1;
        assert!(unpack(&damaged, 100).is_err(), "the checksum is wrong");
        for length in 0..HELLO.len() - 1 {
            assert!(unpack(&HELLO[..length], 100).is_err(), "cut off at {length}");
        }
    }

    #[test]
    fn a_name_in_the_header_is_passed_over() {
        let mut named = HELLO.to_vec();
        named[3] = NAME;
        named.splice(HEADER..HEADER, *b"file.txt\0");
        assert_eq!(unpack(&named, 100).expect("sound").len(), 18);
    }
}
