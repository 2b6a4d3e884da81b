//! Writes NumPy archives: named arrays of plain numbers, the same bytes for the same arrays.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;

/// Kinds of numbers that are written, little endian.
pub trait Number: Copy {
    /// NumPy's name of the kind.
    const DTYPE: &'static str;
    /// Adds the number's bytes.
    fn put(self, bytes: &mut Vec<u8>);
}

macro_rules! number {
    ($($kind:ty => $name:literal),*) => {
        $(impl Number for $kind {
            const DTYPE: &'static str = $name;
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend(self.to_le_bytes());
            }
        })*
    };
}

number!(f32 => "<f4", f64 => "<f8", u8 => "|u1", u16 => "<u2", i32 => "<i4", i64 => "<i8");

/// Effort of deflate: depth pictures shrink nearly as well as at the highest, in a third of the time.
const EFFORT: i64 = 4;
/// NumPy aligns the numbers to this many bytes.
const ALIGNMENT: usize = 64;

/// An archive while arrays are added.
pub struct NpzWriter {
    archive: zip::ZipWriter<Cursor<Vec<u8>>>,
}

impl Default for NpzWriter {
    fn default() -> Self {
        Self { archive: zip::ZipWriter::new(Cursor::new(Vec::new())) }
    }
}

impl NpzWriter {
    /// Adds an array; `numbers` are in C order and fill `shape`.
    ///
    /// # Errors
    /// What the zip writer says; never in memory.
    ///
    /// # Panics
    /// When the numbers don't fill the shape: a mistake of the caller.
    pub fn add<T: Number>(&mut self, name: &str, shape: &[usize], numbers: &[T]) -> std::io::Result<()> {
        assert_eq!(shape.iter().product::<usize>(), numbers.len(), "array `{name}` has another shape");
        let mut bytes = Vec::with_capacity(size_of_val(numbers));
        numbers.iter().for_each(|n| n.put(&mut bytes));
        self.file(name, &header(T::DTYPE, shape), &bytes)
    }

    fn file(&mut self, name: &str, header: &[u8], bytes: &[u8]) -> std::io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(EFFORT))
            .last_modified_time(zip::DateTime::default());
        self.archive.start_file(format!("{name}.npy"), options).map_err(std::io::Error::other)?;
        self.archive.write_all(header)?;
        self.archive.write_all(bytes)
    }

    /// Adds one text as NumPy's scalar of Unicode, which readers of motion archives expect of names.
    ///
    /// # Errors
    /// What the zip writer says; never in memory.
    pub fn add_text(&mut self, name: &str, text: &str) -> std::io::Result<()> {
        let letters: Vec<u32> = text.chars().map(u32::from).collect();
        let bytes: Vec<u8> = letters.iter().flat_map(|letter| letter.to_le_bytes()).collect();
        self.file(name, &header(&format!("<U{}", letters.len().max(1)), &[]), &bytes)
    }

    /// The archive's bytes.
    ///
    /// # Errors
    /// What the zip writer says; never in memory.
    pub fn finish(self) -> std::io::Result<Vec<u8>> {
        Ok(self.archive.finish().map_err(std::io::Error::other)?.into_inner())
    }
}

/// Version 1.0 of the npy header.
fn header(dtype: &str, shape: &[usize]) -> Vec<u8> {
    let axes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let text = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': ({}), }}", axes.trim_end());
    let before = 10;
    let padding = ALIGNMENT - (before + text.len() + 1) % ALIGNMENT;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend(((text.len() + padding + 1) as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes.extend(std::iter::repeat_n(b' ', padding));
    bytes.push(b'\n');
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::npz::{Npz, Numbers};

    #[test]
    fn what_is_written_is_read_back() {
        let write = || {
            let mut writer = NpzWriter::default();
            writer.add("people/height", &[2, 1], &[1.5f32, -2.25]).expect("adds");
            writer.add("depth", &[3], &[0u16, 7, 65535]).expect("adds");
            writer.add("kind", &[0, 4], &[] as &[u8]).expect("adds");
            writer.add("rate", &[], &[29.97f64]).expect("adds");
            writer.add_text("gender", "neutral").expect("adds");
            writer.finish().expect("finishes")
        };
        let npz = Npz::from_bytes("x.npz", &write()).expect("reads");
        assert_eq!(npz.floats("people/height", &[Some(2), Some(1)]).expect("floats").1, [1.5, -2.25]);
        assert_eq!(npz.array("depth").expect("ints").numbers, Numbers::Int(vec![0, 7, 65535]));
        assert_eq!(npz.array("kind").expect("empty").shape, [0, 4]);
        assert_eq!(npz.array("rate").expect("a scalar").numbers, Numbers::Float(vec![29.97]));
        assert!(npz.array("gender").expect_err("text").to_string().contains("U7"));
        assert_eq!(write(), write(), "the same bytes each time");
    }
}
