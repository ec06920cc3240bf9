//! Words and comments of one line.

use super::error::Refused;

/// A piece of a line, in order.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Piece<'a> {
    /// A letter with its number, and how it was written.
    Word { letter: char, value: f64, text: &'a str },
    /// Comment, blank or sign that is kept as it is.
    Kept(&'a str),
}

/// Splits a line; `(…)` and `;…` are comments, `%` and a leading `/` are kept.
pub(super) fn pieces(line: &str) -> Result<Vec<Piece<'_>>, Refused> {
    let mut pieces = Vec::new();
    let mut rest = line;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '(' => rest.find(')').map(|end| end + 1),
            ';' => Some(rest.len()),
            c if c.is_whitespace() || c == '%' || c == '/' => Some(c.len_utf8()),
            c if c.is_ascii_alphabetic() => {
                let (length, value) = word(rest)?;
                let (text, after) = rest.split_at(length);
                pieces.push(Piece::Word { letter: c.to_ascii_uppercase(), value, text });
                rest = after;
                continue;
            }
            _ => None,
        };
        let Some(length) = length else { return Err(unreadable(rest)) };
        let (text, after) = rest.split_at(length);
        pieces.push(Piece::Kept(text));
        rest = after;
    }
    Ok(pieces)
}

/// Length of the word at the start, blanks before its number included, and the number.
fn word(rest: &str) -> Result<(usize, f64), Refused> {
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.');
    let blanks = rest[1..].len() - rest[1..].trim_start_matches([' ', '\t']).len();
    let start = 1 + blanks;
    let digits = rest[start..].find(|c| !is_number(c)).unwrap_or(rest.len() - start);
    let end = start + digits;
    let value = rest[start..end].parse::<f64>().map_err(|_| unreadable(rest))?;
    Ok((end, value))
}

fn unreadable(rest: &str) -> Refused {
    const SHOWN: usize = 20;
    Refused::Word { text: rest.chars().take(SHOWN).collect() }
}
