//! Takes a GLB apart (glTF 2.0 §4.4) and reads the JSON, whether it comes in a GLB or alone.

use super::json::Document;
use crate::assets::error::{Fault, Problem};

const GLB_MAGIC: [u8; 4] = *b"glTF";
const CHUNK_JSON: u32 = 0x4e4f_534a;
const CHUNK_BIN: u32 = 0x004e_4942;

/// The document and the bytes of a GLB's BIN chunk.
pub fn open(bytes: &[u8]) -> Result<(Document, Option<&[u8]>), Fault> {
    let (json, bin) = if bytes.starts_with(&GLB_MAGIC) { glb_chunks(bytes)? } else { (bytes, None) };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    let document: Document = serde_json::from_slice(&json[..end]).map_err(|e| {
        Fault::malformed(
            format!("JSON line {} column {}", e.line(), e.column()),
            format!("the glTF JSON is not valid: {e}"),
        )
    })?;
    check_version(&document)?;
    Ok((document, bin))
}

fn check_version(document: &Document) -> Result<(), Fault> {
    match document.asset.version.split('.').next() {
        Some("2") => Ok(()),
        Some("1") => Err(Fault::new(
            "asset.version",
            Problem::Unsupported {
                feature: "glTF 1.0".to_string(),
                remedy: "Import it into Blender and export it as glTF 2.0.",
            },
        )),
        _ => Err(Fault::malformed("asset.version", "a glTF 2.0 file must say version \"2.0\" here")),
    }
}

fn glb_chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), Fault> {
    let there = bytes.len() as u64;
    let number = |at: usize| {
        let word = bytes.get(at..at + 4).and_then(|w| w.first_chunk::<4>());
        word.map(|w| u32::from_le_bytes(*w)).ok_or_else(|| {
            Fault::new(
                format!("GLB header at byte {at}"),
                Problem::Truncated { needed: at as u64 + 4, there },
            )
        })
    };
    if number(4)? != 2 {
        return Err(Fault::new(
            "GLB header at byte 4",
            Problem::Unsupported {
                feature: format!("GLB version {}", number(4)?),
                remedy: "Import it into Blender and export it as glTF 2.0.",
            },
        ));
    }
    let length = u64::from(number(8)?);
    if length > there {
        return Err(Fault::new("GLB header at byte 8", Problem::Truncated { needed: length, there }));
    }
    let (mut json, mut bin) = (None, None);
    let mut at = 12;
    while at + 8 <= length as usize {
        let (size, kind) = (number(at)? as usize, number(at + 4)?);
        let chunk = bytes[..length as usize].get(at + 8..at + 8 + size).ok_or_else(|| {
            Fault::new(
                format!("GLB chunk at byte {at}"),
                Problem::Truncated { needed: (at + 8 + size) as u64, there },
            )
        })?;
        match kind {
            CHUNK_JSON if json.is_none() => json = Some(chunk),
            CHUNK_BIN if bin.is_none() => bin = Some(chunk),
            _ => {}
        }
        at += 8 + size.next_multiple_of(4);
    }
    let json = json.ok_or_else(|| Fault::malformed("GLB header at byte 12", "there is no JSON chunk"))?;
    Ok((json, bin))
}
