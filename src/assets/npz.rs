//! NumPy archives (`.npz`): named arrays of plain numbers, in and out, nothing else.
//!
//! Pickled objects are never opened, whatever their name. Sizes are checked against a budget and against
//! the bytes that are there before anything is allocated.

use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use npyz::{DType, NpyFile, Order, TypeChar};

pub use super::npz_write::{NpzWriter, Number};

/// Most bytes that one archive may hold once inflated. A full SMPL-X model with 400 shape and expression
/// directions inflates to about 170 MB.
const MAX_TOTAL_BYTES: u64 = 768 << 20;
/// Most arrays of one archive; a motion corpus of a few thousand clips still fits.
const MAX_ARRAYS: usize = 65_536;
/// Longest header of one array; NumPy writes 128 bytes. Keeps the literal parser's recursion shallow.
const MAX_HEADER_BYTES: usize = 1024;
/// Most axes of an array.
const MAX_AXES: usize = 8;

/// Why an archive or one of its arrays can't be used.
#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    /// The file could not be read.
    #[error("{file}: can't be read: {cause}")]
    Io {
        /// The file.
        file: String,
        /// What the system says.
        cause: std::io::Error,
    },
    /// Not a zip archive, or a damaged one.
    #[error("{file}: not a readable npz archive ({cause}); save it again with numpy.savez_compressed")]
    Archive {
        /// The file.
        file: String,
        /// What the zip reader says.
        cause: String,
    },
    /// More than the budget allows.
    #[error("{file}: {what} exceeds the limit of {limit}; split the archive")]
    TooLarge {
        /// The file.
        file: String,
        /// What is too large.
        what: String,
        /// The limit.
        limit: u64,
    },
    /// No array of that name.
    #[error("{file}: has no array `{array}`; it has {present}")]
    Missing {
        /// The file.
        file: String,
        /// The name looked for.
        array: String,
        /// Names that are there.
        present: String,
    },
    /// The array is a pickled Python object, text or a record.
    #[error(
        "{file}: array `{array}` holds {dtype}, which is not plain numbers (pickles are never opened); save it as float32 or int32"
    )]
    NotNumbers {
        /// The file.
        file: String,
        /// The array.
        array: String,
        /// NumPy's name of the type.
        dtype: String,
    },
    /// The array's header or bytes are damaged.
    #[error("{file}: array `{array}`: {cause}")]
    Damaged {
        /// The file.
        file: String,
        /// The array.
        array: String,
        /// What is wrong.
        cause: String,
    },
    /// The array has another shape than asked for.
    #[error("{file}: array `{array}` has shape {found:?}, expected {expected}")]
    Shape {
        /// The file.
        file: String,
        /// The array.
        array: String,
        /// Its shape.
        found: Vec<usize>,
        /// The shape it should have.
        expected: String,
    },
    /// A number is NaN or infinite.
    #[error("{file}: array `{array}` has a number that is not finite, at flat index {index}")]
    NotFinite {
        /// The file.
        file: String,
        /// The array.
        array: String,
        /// Where, in C order.
        index: usize,
    },
}

/// The numbers of an array, in C order.
#[derive(Clone, Debug, PartialEq)]
pub enum Numbers {
    /// From f16, f32 or f64.
    Float(Vec<f32>),
    /// From any integer type or bool.
    Int(Vec<i64>),
}

/// One array.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Length of each axis.
    pub shape: Vec<usize>,
    /// The numbers, C order.
    pub numbers: Numbers,
}

/// An archive in memory. Arrays are decoded when asked for, so unusable neighbours do no harm.
pub struct Npz {
    file: String,
    entries: BTreeMap<String, Vec<u8>>,
}

impl Npz {
    /// Reads the archive at `path`.
    ///
    /// # Errors
    /// [`NpzError::Io`], [`NpzError::Archive`] or [`NpzError::TooLarge`].
    pub fn open(path: &Path) -> Result<Self, NpzError> {
        let file = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|cause| NpzError::Io { file: file.clone(), cause })?;
        Self::from_bytes(&file, &bytes)
    }

    /// Reads an archive from memory; `file` names it in errors.
    ///
    /// # Errors
    /// [`NpzError::Archive`] or [`NpzError::TooLarge`].
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Self, NpzError> {
        let damaged =
            |cause: &dyn std::fmt::Display| NpzError::Archive { file: file.into(), cause: cause.to_string() };
        let too_large =
            |what: &str, limit| NpzError::TooLarge { file: file.into(), what: what.into(), limit };
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| damaged(&e))?;
        if archive.len() > MAX_ARRAYS {
            return Err(too_large("the number of arrays", MAX_ARRAYS as u64));
        }
        let mut left = MAX_TOTAL_BYTES;
        let mut entries = BTreeMap::new();
        for i in 0..archive.len() {
            let mut entry = archive.by_index(i).map_err(|e| damaged(&e))?;
            let path = entry.name().map_err(|e| damaged(&e))?.into_owned();
            let Some(name) = npyz::npz::array_name_from_file_name(&path) else { continue };
            let mut data = Vec::new();
            let read = entry.by_ref().take(left + 1).read_to_end(&mut data).map_err(|e| damaged(&e))? as u64;
            left = left.checked_sub(read).ok_or_else(|| too_large("the inflated size", MAX_TOTAL_BYTES))?;
            entries.insert(name.to_owned(), data);
        }
        Ok(Self { file: file.to_owned(), entries })
    }

    /// Names of all arrays, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.keys().map(String::as_str)
    }

    /// Whether there is an array of that name.
    pub fn has(&self, array: &str) -> bool {
        self.entries.contains_key(array)
    }

    /// Decodes one array.
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::NotNumbers`] or [`NpzError::Damaged`].
    pub fn array(&self, array: &str) -> Result<Array, NpzError> {
        let bytes = self.entries.get(array).ok_or_else(|| self.missing(array))?;
        self.check_header_length(array, bytes)?;
        let npy = NpyFile::new(bytes.as_slice()).map_err(|e| self.damaged(array, &e))?;
        let (shape, count) = self.shape_of(array, npy.shape())?;
        let dtype = npy.dtype();
        let DType::Plain(kind) = &dtype else { return Err(self.not_numbers(array, &dtype)) };
        let size = kind.num_bytes().ok_or_else(|| self.not_numbers(array, &dtype))?;
        let there = npy_data_length(bytes, size);
        if there.is_none_or(|there| there < count) {
            return Err(self.damaged(array, &format!("{count} numbers announced, fewer are there")));
        }
        let (type_char, order) = (kind.type_char(), npy.order());
        let numbers = decode(npy, type_char, size)
            .ok_or_else(|| self.not_numbers(array, &dtype))?
            .map_err(|e| self.damaged(array, &e))?;
        let numbers = if order == Order::Fortran { to_c_order(numbers, &shape) } else { numbers };
        Ok(Array { shape, numbers })
    }

    /// Decodes an array of finite floats; each axis of `expected` is a length or `None` for any.
    /// Returns the shape and the numbers in C order.
    ///
    /// # Errors
    /// As [`Npz::array`], and [`NpzError::Shape`] or [`NpzError::NotFinite`].
    pub fn floats(
        &self,
        array: &str,
        expected: &[Option<usize>],
    ) -> Result<(Vec<usize>, Vec<f32>), NpzError> {
        let Array { shape, numbers } = self.array(array)?;
        self.check_shape(array, &shape, expected)?;
        let values = match numbers {
            Numbers::Float(values) => values,
            Numbers::Int(values) => values.into_iter().map(|v| v as f32).collect(),
        };
        match values.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(NpzError::NotFinite { file: self.file.clone(), array: array.into(), index }),
            None => Ok((shape, values)),
        }
    }

    /// Decodes an array of integers; each axis of `expected` is a length or `None` for any.
    ///
    /// # Errors
    /// As [`Npz::array`], and [`NpzError::Shape`]; floats are [`NpzError::NotNumbers`].
    pub fn ints(&self, array: &str, expected: &[Option<usize>]) -> Result<(Vec<usize>, Vec<i64>), NpzError> {
        let Array { shape, numbers } = self.array(array)?;
        self.check_shape(array, &shape, expected)?;
        match numbers {
            Numbers::Int(values) => Ok((shape, values)),
            Numbers::Float(_) => Err(self.damaged(array, &"holds floats where whole numbers are due")),
        }
    }

    fn check_shape(&self, array: &str, found: &[usize], expected: &[Option<usize>]) -> Result<(), NpzError> {
        let fits = found.len() == expected.len()
            && found.iter().zip(expected).all(|(f, e)| e.is_none_or(|e| e == *f));
        if fits {
            return Ok(());
        }
        let axes: Vec<_> = expected.iter().map(|e| e.map_or("any".to_owned(), |n| n.to_string())).collect();
        let expected = format!("[{}]", axes.join(", "));
        Err(NpzError::Shape { file: self.file.clone(), array: array.into(), found: found.to_vec(), expected })
    }

    fn check_header_length(&self, array: &str, bytes: &[u8]) -> Result<(), NpzError> {
        match header_end(bytes) {
            Some(end) if end <= MAX_HEADER_BYTES && end <= bytes.len() => Ok(()),
            _ => Err(self.damaged(array, &"its header is not NumPy's")),
        }
    }

    fn shape_of(&self, array: &str, shape: &[u64]) -> Result<(Vec<usize>, usize), NpzError> {
        let lengths: Option<Vec<usize>> = shape.iter().map(|n| usize::try_from(*n).ok()).collect();
        lengths
            .filter(|axes| axes.len() <= MAX_AXES)
            .and_then(|axes| {
                let count = axes.iter().try_fold(1usize, |product, n| product.checked_mul(*n))?;
                Some((axes, count))
            })
            .ok_or_else(|| self.damaged(array, &format!("its shape {shape:?} is absurd")))
    }

    fn missing(&self, array: &str) -> NpzError {
        let present = self.names().take(20).collect::<Vec<_>>().join(", ");
        NpzError::Missing { file: self.file.clone(), array: array.into(), present }
    }

    fn damaged(&self, array: &str, cause: &dyn std::fmt::Display) -> NpzError {
        NpzError::Damaged { file: self.file.clone(), array: array.into(), cause: cause.to_string() }
    }

    fn not_numbers(&self, array: &str, dtype: &DType) -> NpzError {
        NpzError::NotNumbers { file: self.file.clone(), array: array.into(), dtype: dtype.descr() }
    }
}

/// Where the header of an npy file ends; `None` if it isn't one. Format versions 1 to 3.
fn header_end(bytes: &[u8]) -> Option<usize> {
    let body = bytes.strip_prefix(b"\x93NUMPY")?;
    match *body {
        [1, _, a, b, ..] => Some(10 + usize::from(u16::from_le_bytes([a, b]))),
        [2 | 3, _, a, b, c, d, ..] => usize::try_from(u32::from_le_bytes([a, b, c, d])).ok()?.checked_add(12),
        _ => None,
    }
}

fn npy_data_length(bytes: &[u8], item_bytes: usize) -> Option<usize> {
    bytes.len().checked_sub(header_end(bytes)?)?.checked_div(item_bytes)
}

fn decode(npy: NpyFile<&[u8]>, kind: TypeChar, size: usize) -> Option<std::io::Result<Numbers>> {
    fn ints<T: npyz::Deserialize + Into<i64>>(npy: NpyFile<&[u8]>) -> std::io::Result<Numbers> {
        Ok(Numbers::Int(npy.into_vec::<T>()?.into_iter().map(Into::into).collect()))
    }
    Some(match (kind, size) {
        (TypeChar::Float, 2) => npy
            .into_vec::<half::f16>()
            .map(|values| Numbers::Float(values.into_iter().map(half::f16::to_f32).collect())),
        (TypeChar::Float, 4) => npy.into_vec::<f32>().map(Numbers::Float),
        (TypeChar::Float, 8) => {
            npy.into_vec::<f64>().map(|values| Numbers::Float(values.into_iter().map(|v| v as f32).collect()))
        }
        (TypeChar::Bool, 1) => ints::<bool>(npy),
        (TypeChar::Int, 1) => ints::<i8>(npy),
        (TypeChar::Int, 2) => ints::<i16>(npy),
        (TypeChar::Int, 4) => ints::<i32>(npy),
        (TypeChar::Int, 8) => ints::<i64>(npy),
        (TypeChar::Uint, 1) => ints::<u8>(npy),
        (TypeChar::Uint, 2) => ints::<u16>(npy),
        (TypeChar::Uint, 4) => ints::<u32>(npy),
        (TypeChar::Uint, 8) => npy.into_vec::<u64>().and_then(|values| {
            let narrow = values.into_iter().map(|v| i64::try_from(v).map_err(std::io::Error::other));
            narrow.collect::<Result<_, _>>().map(Numbers::Int)
        }),
        _ => return None,
    })
}

fn to_c_order(numbers: Numbers, shape: &[usize]) -> Numbers {
    match numbers {
        Numbers::Float(values) => Numbers::Float(transpose_axes(&values, shape)),
        Numbers::Int(values) => Numbers::Int(transpose_axes(&values, shape)),
    }
}

/// Reorders Fortran-ordered values (first axis fastest) to C order (last axis fastest).
fn transpose_axes<T: Copy>(values: &[T], shape: &[usize]) -> Vec<T> {
    let mut index = vec![0usize; shape.len()];
    let mut reordered = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        let at = index.iter().zip(shape).rev().fold(0, |at, (i, n)| at * n + i);
        reordered.push(values[at]);
        for axis in (0..shape.len()).rev() {
            index[axis] += 1;
            if index[axis] < shape[axis] {
                break;
            }
            index[axis] = 0;
        }
    }
    reordered
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write as _;

    fn npy(descr: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
        let fortran = if fortran { "True" } else { "False" };
        let text = format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}");
        let mut header = text.into_bytes();
        while (header.len() + 11) % 64 != 0 {
            header.push(b' ');
        }
        header.push(b'\n');
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend(u16::try_from(header.len()).expect("short").to_le_bytes());
        bytes.extend(header);
        bytes.extend(data);
        bytes
    }

    fn archive(entries: &[(&str, Vec<u8>)]) -> Npz {
        let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in entries {
            zip.start_file(*name, zip::write::SimpleFileOptions::default()).expect("entry");
            zip.write_all(bytes).expect("bytes");
        }
        Npz::from_bytes("test.npz", zip.finish().expect("zip").get_ref()).expect("archive")
    }

    fn floats(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    #[test]
    fn both_memory_orders_give_the_same_matrix() {
        let npz = archive(&[
            ("c.npy", npy("<f4", false, "(2, 3)", &floats(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))),
            ("f.npy", npy("<f4", true, "(2, 3)", &floats(&[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]))),
        ]);
        assert_eq!(npz.array("c").expect("c"), npz.array("f").expect("f"));
    }

    #[test]
    fn half_floats_and_small_integers_are_read() {
        let one_and_half = half::f16::from_f32(1.5).to_le_bytes();
        let npz = archive(&[
            ("h.npy", npy("<f2", false, "(1,)", &one_and_half)),
            ("u.npy", npy("<u2", false, "(2,)", &[1, 0, 255, 255])),
        ]);
        assert_eq!(npz.floats("h", &[Some(1)]).expect("h").1, [1.5]);
        assert_eq!(npz.ints("u", &[None]).expect("u").1, [1, 65535]);
    }

    #[test]
    fn a_pickle_is_refused_by_name_and_its_neighbours_still_load() {
        let npz = archive(&[
            ("evil.npy", npy("|O", false, "()", b"\x80\x04cos\nsystem\n.")),
            ("good.npy", npy("<f4", false, "(1,)", &floats(&[2.0]))),
        ]);
        let error = npz.array("evil").expect_err("pickles are never opened");
        assert!(matches!(error, NpzError::NotNumbers { .. }), "{error}");
        assert_eq!(npz.floats("good", &[None]).expect("good").1, [2.0]);
    }

    #[test]
    fn damaged_arrays_give_typed_errors_that_name_file_and_array() {
        let mut huge_header = b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec();
        huge_header.extend([b' '; 64]);
        let npz = archive(&[
            ("short.npy", npy("<f4", false, "(1000000,)", &floats(&[1.0]))),
            ("absurd.npy", npy("<f4", false, "(4294967296, 4294967296, 4294967296)", &[])),
            ("nan.npy", npy("<f4", false, "(2,)", &floats(&[0.0, f32::NAN]))),
            ("text.npy", b"hello".to_vec()),
            ("header.npy", huge_header),
        ]);
        for name in ["short", "absurd", "text", "header", "nan", "none"] {
            let error = npz.floats(name, &[None]).expect_err(name).to_string();
            assert!(error.contains("test.npz") && error.contains(name), "{error}");
        }
        let error = npz.floats("nan", &[Some(3)]).expect_err("shape");
        assert!(matches!(error, NpzError::Shape { .. }), "{error}");
    }

    #[test]
    fn bytes_that_are_no_archive_are_refused() {
        for bytes in [&b""[..], b"PK\x03\x04", b"not a zip at all"] {
            assert!(matches!(Npz::from_bytes("x.npz", bytes), Err(NpzError::Archive { .. })));
        }
    }
}
