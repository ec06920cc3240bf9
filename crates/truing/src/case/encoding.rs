//! Text out of bytes: UTF-8, or UTF-16 that says so by its byte order mark.

use super::Problem;
use crate::file::no_text;

/// Byte order marks.
const UTF_8: &[u8] = b"\xef\xbb\xbf";
const UTF_16_LE: &[u8] = b"\xff\xfe";
const UTF_16_BE: &[u8] = b"\xfe\xff";

/// Text, and how it was written where that is not UTF-8.
#[derive(Debug)]
pub(crate) struct Decoded {
    pub(crate) text: String,
    pub(crate) encoding: Option<&'static str>,
}

/// What keeps bytes from being text, with line and column from 1.
#[derive(Debug)]
pub(crate) struct Undecoded {
    pub(crate) line: usize,
    pub(crate) column: usize,
    pub(crate) problem: Box<Problem>,
}

/// The text without its byte order mark.
pub(crate) fn decode(bytes: Vec<u8>) -> Result<Decoded, Undecoded> {
    if let Some(found) = no_text(&bytes) {
        let problem = Box::new(Problem::NotText { found });
        return Err(Undecoded { line: 1, column: 1, problem });
    }
    if let Some(rest) = bytes.strip_prefix(UTF_16_LE) {
        return utf_16(rest, u16::from_le_bytes, "UTF-16 LE");
    }
    if let Some(rest) = bytes.strip_prefix(UTF_16_BE) {
        return utf_16(rest, u16::from_be_bytes, "UTF-16 BE");
    }
    if matches!(bytes[..], [0, other, ..] | [other, 0, ..] if other != 0) {
        let problem = Box::new(Problem::Utf16WithoutMark);
        return Err(Undecoded { line: 1, column: 1, problem });
    }
    let mut text = String::from_utf8(bytes).map_err(|e| not_utf_8(&e))?;
    if text.as_bytes().starts_with(UTF_8) {
        text.drain(..UTF_8.len());
    }
    Ok(Decoded { text, encoding: None })
}

fn utf_16(
    bytes: &[u8],
    unit: fn([u8; 2]) -> u16,
    name: &'static str,
) -> Result<Decoded, Undecoded> {
    let (pairs, rest) = bytes.as_chunks::<2>();
    let mut text = String::with_capacity(pairs.len());
    let broken = |text: &str| {
        let (line, column) = end_of(text);
        Undecoded { line, column, problem: Box::new(Problem::NotUtf16) }
    };
    for unit in char::decode_utf16(pairs.iter().map(|pair| unit(*pair))) {
        text.push(unit.map_err(|_| broken(&text))?);
    }
    if !rest.is_empty() {
        return Err(broken(&text));
    }
    Ok(Decoded { text, encoding: Some(name) })
}

fn not_utf_8(error: &std::string::FromUtf8Error) -> Undecoded {
    let (before, rest) = error.as_bytes().split_at(error.utf8_error().valid_up_to());
    let (line, column) = end_of(&String::from_utf8_lossy(before));
    let byte = rest.first().copied().unwrap_or_default();
    Undecoded { line, column, problem: Box::new(Problem::NotUtf8 { byte }) }
}

/// Line and column, from 1, of the character after `text`.
fn end_of(text: &str) -> (usize, usize) {
    let line_start = text.rfind('\n').map_or(0, |at| at + 1);
    (1 + text.matches('\n').count(), 1 + text[line_start..].chars().count())
}

#[cfg(test)]
mod tests {
    use super::decode;

    /// Written by hand from the tables of Unicode: µ is U+00B5, 𝛼 is U+1D6FC.
    #[test]
    fn utf_16_in_both_orders() {
        let little = b"\xff\xfea\x00\xb5\x00\x35\xd8\xfc\xde".to_vec();
        let big = b"\xfe\xff\x00a\x00\xb5\xd8\x35\xde\xfc".to_vec();
        for (bytes, name) in [(little, "UTF-16 LE"), (big, "UTF-16 BE")] {
            let decoded = decode(bytes).unwrap();
            assert_eq!((decoded.text.as_str(), decoded.encoding), ("aµ𝛼", Some(name)));
        }
    }

    #[test]
    fn what_breaks_off_is_refused_where_it_does() {
        for bytes in [&b"\xff\xfea\x00\n\x00b"[..], b"\xff\xfea\x00\n\x00\x35\xd8"] {
            let Err(e) = decode(bytes.to_vec()) else { panic!("{bytes:?} is no text") };
            assert_eq!((e.line, e.column), (2, 1));
        }
        assert!(decode(b"a\x00b\x00".to_vec()).is_err());
    }
}
