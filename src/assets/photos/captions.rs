//! Captions as csv: a header with `image_id` and `caption` (or `prompt`), then one caption a line; quoted fields may
//! hold commas, doubled quotes and line breaks.

use super::super::budget::Budget;
use super::{Fault, MAX_PEOPLE, PhotoSet, key_of_name, key_of_number};

/// Columns that may hold the caption.
const TEXTS: [&str; 2] = ["caption", "prompt"];

/// Whether a line is the header.
pub(super) fn is_header(line: &str) -> bool {
    let names = fields(line).next().unwrap_or_default();
    names.iter().any(|n| n == "image_id") && names.iter().any(|n| TEXTS.contains(&n.as_str()))
}

pub(super) fn add(set: &mut PhotoSet, text: &str) -> Result<(), Fault> {
    let mut records = fields(text).enumerate().filter(|(_, record)| record.iter().any(|f| !f.is_empty()));
    let (_, header) = records.next().unwrap_or_default();
    let column = |is: &dyn Fn(&str) -> bool| header.iter().position(|name| is(name));
    let found = column(&|n| n == "image_id").zip(column(&|n| TEXTS.contains(&n)));
    let Some((image, caption)) = found else {
        return Err(Fault::malformed("record 1", "it names no \"image_id\" and \"caption\""));
    };
    for (number, record) in records {
        let place = || format!("record {}", number + 1);
        Budget::check(&place(), "captions", number as u64, MAX_PEOPLE as u64)?;
        let (Some(image), Some(caption)) = (record.get(image), record.get(caption)) else {
            return Err(Fault::malformed(place(), format!("it has {} fields", record.len())));
        };
        let key = image.parse().map_or_else(|_| key_of_name(image), key_of_number);
        set.photo(&key)?.put_caption(caption);
    }
    Ok(())
}

/// The records of a csv text (RFC 4180), each as its fields.
fn fields(text: &str) -> impl Iterator<Item = Vec<String>> + '_ {
    let mut chars = text.chars().peekable();
    std::iter::from_fn(move || {
        chars.peek()?;
        let (mut record, mut field, mut quoted) = (Vec::new(), String::new(), false);
        while let Some(c) = chars.next() {
            match (c, quoted) {
                ('"', true) if chars.peek() == Some(&'"') => {
                    chars.next();
                    field.push('"');
                }
                ('"', _) => quoted = !quoted,
                (',', false) => record.push(std::mem::take(&mut field)),
                ('\n', false) => break,
                ('\r', false) => {}
                _ => field.push(c),
            }
        }
        record.push(field);
        Some(record)
    })
}
