//! Where the files that a file refers to may lie: in its own folder, or inside the URI itself.

use std::fs;
use std::path::{Component, Path, PathBuf};

use super::budget::Budget;
use super::error::{Fault, Problem};

/// The folder that a file's references are looked up in; none for a file in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings<'a> {
    pub folder: Option<&'a Path>,
    pub budget: &'a Budget,
}

impl Surroundings<'_> {
    /// The bytes that a percent-encoded `uri` stands for: a `data:` URI or a file in the folder.
    pub fn read_uri(&self, place: &str, uri: &str) -> Result<Vec<u8>, Fault> {
        match uri.strip_prefix("data:") {
            Some(data) => decode_data_uri(data).ok_or_else(|| {
                Fault::malformed(place, "its data: URI is not valid base64 (data:TYPE;base64,DATA)")
            }),
            None => self.read_file(place, &percent_decoded(uri)),
        }
    }

    /// The bytes of the file `name`, relative to the folder, with either kind of slash.
    pub fn read_file(&self, place: &str, name: &str) -> Result<Vec<u8>, Fault> {
        let path = self.resolve(place, name)?;
        read_plain_file(&path, self.budget)
            .map_err(|fault| Fault::new(format!("{place} ({name})"), fault.problem))
    }

    fn resolve(&self, place: &str, name: &str) -> Result<PathBuf, Fault> {
        let outside = || Fault::new(place, Problem::OutsideFolder(shortened(name)));
        let relative = inside(name).ok_or_else(outside)?;
        let Some(folder) = self.folder else {
            return Err(Fault::new(
                place,
                Problem::Unsupported {
                    feature: format!(
                        "the external file \"{}\" although it is itself not a file on disk",
                        shortened(name)
                    ),
                    remedy: "Embed everything in one GLB.",
                },
            ));
        };
        let path = folder.join(relative);
        let real =
            |path: &Path| fs::canonicalize(path).map_err(|e| Fault::new(format!("{place} ({name})"), e));
        if real(&path)?.starts_with(real(folder)?) { Ok(path) } else { Err(outside()) }
    }
}

/// `name` as a relative path that never climbs above its start, or `None`.
fn inside(name: &str) -> Option<PathBuf> {
    let name = name.replace('\\', "/");
    let first = name.split('/').next().unwrap_or("");
    if name.is_empty() || name.contains('\0') || name.starts_with('/') || first.contains(':') {
        return None;
    }
    let mut path = PathBuf::new();
    for component in Path::new(&name).components() {
        match component {
            Component::Normal(part) => path.push(part),
            Component::CurDir => {}
            Component::ParentDir => {
                if !path.pop() {
                    return None;
                }
            }
            Component::Prefix(_) | Component::RootDir => return None,
        }
    }
    Some(path)
}

/// Reads a plain file of at most the budget's size. Folders, pipes and devices are refused unread.
pub(super) fn read_plain_file(path: &Path, budget: &Budget) -> Result<Vec<u8>, Fault> {
    let place = "the file itself";
    let about = fs::metadata(path).map_err(|e| Fault::new(place, e))?;
    if !about.is_file() {
        return Err(Fault::malformed(place, "it is a folder or a device, not a file"));
    }
    budget.check_bytes(place, about.len())?;
    fs::read(path).map_err(|e| Fault::new(place, e))
}

/// Long URIs cut to what fits a message.
fn shortened(uri: &str) -> String {
    if uri.chars().count() <= 80 {
        uri.to_string()
    } else {
        uri.chars().take(77).chain("...".chars()).collect()
    }
}

fn percent_decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let hex = bytes.get(at + 1..at + 3).and_then(|h| std::str::from_utf8(h).ok());
        let escaped = (bytes[at] == b'%').then(|| hex.and_then(|h| u8::from_str_radix(h, 16).ok())).flatten();
        decoded.push(escaped.unwrap_or(bytes[at]));
        at += if escaped.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}

/// The bytes of `TYPE;base64,DATA`.
fn decode_data_uri(data: &str) -> Option<Vec<u8>> {
    let (kind, encoded) = data.split_once(',')?;
    if kind.ends_with(";base64") { decode_base64(encoded.as_bytes()) } else { None }
}

/// RFC 4648 §4; padding and line breaks may be missing or present.
fn decode_base64(encoded: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(encoded.len() / 4 * 3 + 3);
    let (mut bits, mut held) = (0u32, 0);
    let mut ended = false;
    for &c in encoded {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => {
                ended = true;
                continue;
            }
            b'\r' | b'\n' => continue,
            _ => return None,
        };
        if ended {
            return None;
        }
        bits = (bits << 6) | u32::from(value);
        held += 6;
        if held >= 8 {
            held -= 8;
            bytes.push((bits >> held) as u8);
            bits &= (1 << held) - 1;
        }
    }
    // A single left-over character carries six bits: not a byte.
    (held < 6).then_some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_length_comes_back() {
        assert_eq!(decode_base64(b"TWFu").as_deref(), Some(&b"Man"[..]));
        assert_eq!(decode_base64(b"TWE=").as_deref(), Some(&b"Ma"[..]));
        assert_eq!(decode_base64(b"TQ==").as_deref(), Some(&b"M"[..]));
        assert_eq!(decode_base64(b"TQ").as_deref(), Some(&b"M"[..]));
        assert_eq!(decode_base64(b"+/-_").as_deref(), Some(&[0xfb, 0xff, 0xbf][..]));
        for bad in [&b"T"[..], b"T*Fu", b"TQ==TQ=="] {
            assert_eq!(decode_base64(bad), None);
        }
    }

    #[test]
    fn no_name_leads_out_of_the_folder() {
        for bad in
            ["", "/etc/passwd", "../a", "a/../../b", "..\\a", "C:\\a", "file:///a", "http://h/a", "\\\\h\\a"]
        {
            assert_eq!(inside(bad), None, "{bad}");
        }
        assert_eq!(inside("./tex/../tex\\wood.png"), Some(PathBuf::from("tex/wood.png")));
    }

    #[test]
    fn percent_signs_are_decoded_and_lone_ones_kept() {
        assert_eq!(percent_decoded("a%20b%C3%A4%zz%"), "a bä%zz%");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_out_of_the_folder_is_not_followed() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("room");
        fs::create_dir(&folder).unwrap();
        fs::write(outer.path().join("secret"), b"secret").unwrap();
        std::os::unix::fs::symlink(outer.path().join("secret"), folder.join("link")).unwrap();
        fs::write(folder.join("own"), b"own").unwrap();
        let here = Surroundings { folder: Some(&folder), budget: &Budget::default() };
        assert_eq!(here.read_uri("p", "own").unwrap(), b"own");
        let refused = here.read_uri("p", "link").unwrap_err();
        assert!(matches!(refused.problem, Problem::OutsideFolder(_)));
    }
}
