//! How the cells of a table are separated, and how its numbers are written.

/// Separators of cells, and their names.
const SEPARATORS: [(char, &str); 3] = [(',', "comma"), (';', "semicolon"), ('\t', "tab")];

/// What separates the cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Separator {
    pub(crate) character: char,
    pub(crate) name: &'static str,
    /// Bytes of the first line that says so, where one does.
    pub(crate) declared: Option<usize>,
}

/// Separators of which each would give another table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MixedSeparators {
    pub(crate) first: &'static str,
    pub(crate) second: &'static str,
}

/// Finds the separator from a first line `sep=;`, else from the header.
pub(crate) fn separator(text: &str) -> Result<Separator, MixedSeparators> {
    if let Some(declared) = declared(text) {
        return Ok(declared);
    }
    let lines = text.split(['\n', '\r']).filter(|line| !line.starts_with('#'));
    let has_name = |line: &&str| line.contains(|c: char| !c.is_whitespace() && !is_separator(c));
    let header = lines.into_iter().find(has_name).unwrap_or_default();
    let header = without_quoted(header);
    let mut clean = Vec::new();
    let mut present = Vec::new();
    for (character, name) in SEPARATORS {
        // Blanks around cells mean nothing, and a tab beside a comma is a blank.
        let mut cells = header.split(character).map(str::trim);
        if !header.contains(character) {
            continue;
        }
        present.push(name);
        if cells.all(|cell| !cell.contains(is_separator)) {
            clean.push(Separator { character, name, declared: None });
        }
    }
    match (clean.first(), &present[..]) {
        (Some(first), _) => Ok(*first),
        (None, [first, second, ..]) => Err(MixedSeparators { first, second }),
        (None, _) => Ok(Separator { character: ',', name: "comma", declared: None }),
    }
}

/// The first line `sep=;` that spreadsheets write and read.
fn declared(text: &str) -> Option<Separator> {
    let end = text.find(['\n', '\r'])?;
    let line = text[..end].trim_matches(['"', ' ']);
    let (key, value) = line.split_at_checked("sep=".len())?;
    if !key.eq_ignore_ascii_case("sep=") {
        return None;
    }
    let (character, name) = SEPARATORS.into_iter().find(|(c, _)| value.chars().eq([*c]))?;
    Some(Separator { character, name, declared: Some(end) })
}

fn is_separator(c: char) -> bool {
    SEPARATORS.iter().any(|(s, _)| *s == c)
}

/// `line` with nothing between double quotes.
fn without_quoted(line: &str) -> String {
    line.split('"').step_by(2).collect()
}

/// A number as it is written, in a table whose cells no comma separates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Writing {
    /// `1.5`.
    Point,
    /// `1,5`.
    Comma,
    /// `1,234`: a number with three decimals, or one of four digits.
    CommaOrGroups,
    /// `1.234,5`, `1,234.5`, `1,234,567`.
    Groups,
    /// Digits alone, or no number.
    Plain,
}

/// How one cell is written.
pub(crate) fn writing(cell: &str) -> Writing {
    let is_of_number = |c: char| c.is_ascii_digit() || ",.+-eE".contains(c);
    if !cell.contains([',', '.'])
        || !cell.contains(|c: char| c.is_ascii_digit())
        || !cell.chars().all(is_of_number)
    {
        return Writing::Plain;
    }
    let is_number = |text: &str| text.parse::<f64>().is_ok();
    let bare = cell.trim_start_matches(['+', '-']);
    match (cell.matches(',').count(), cell.matches('.').count()) {
        (0, _) if is_number(cell) => Writing::Point,
        (1, 0) if is_number(&with_point(cell)) => {
            let (whole, decimals) = bare.split_once(',').unwrap_or((bare, ""));
            if is_leading_group(whole) && is_group(decimals) {
                Writing::CommaOrGroups
            } else {
                Writing::Comma
            }
        }
        (1.., _) if is_number(&cell.replace([',', '.'], "")) => {
            let mut groups = bare.split([',', '.']);
            let leads = groups.next().is_some_and(is_leading_group);
            // What follows a point or a comma may be decimals; the first must be a group.
            if leads && groups.next().is_some_and(is_group) {
                Writing::Groups
            } else {
                Writing::Plain
            }
        }
        _ => Writing::Plain,
    }
}

/// The number with a point for its comma.
pub(crate) fn with_point(cell: &str) -> String {
    cell.replacen(',', ".", 1)
}

/// Up to three digits that may stand before a separator of thousands.
fn is_leading_group(digits: &str) -> bool {
    (1..=3).contains(&digits.len())
        && digits.bytes().all(|b| b.is_ascii_digit())
        && !digits.starts_with('0')
}

fn is_group(digits: &str) -> bool {
    digits.len() == 3 && digits.bytes().all(|b| b.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::{Writing, separator, writing};

    #[test]
    fn numbers_by_how_they_are_written() {
        for (cell, expected) in [
            ("1.5", Writing::Point),
            ("-1.234e-3", Writing::Point),
            ("1,5", Writing::Comma),
            ("-0,123", Writing::Comma),
            ("+12,3456", Writing::Comma),
            ("1234,567", Writing::Comma),
            ("1,234e2", Writing::Comma),
            (",5", Writing::Comma),
            ("1,234", Writing::CommaOrGroups),
            ("-110,004", Writing::CommaOrGroups),
            ("1.234,5", Writing::Groups),
            ("1,234.5", Writing::Groups),
            ("1,234,567", Writing::Groups),
            ("1234", Writing::Plain),
            ("P1,2", Writing::Plain),
            ("1,2,3", Writing::Plain),
            ("1.2.3", Writing::Plain),
            ("-", Writing::Plain),
            ("e,e", Writing::Plain),
        ] {
            assert_eq!(writing(cell), expected, "{cell}");
        }
    }

    #[test]
    fn separators_by_the_header() {
        let of = |text: &str| separator(text).map(|s| (s.character, s.declared.is_some()));
        assert_eq!(of("a,b\n1,2\n"), Ok((',', false)));
        assert_eq!(of("# a, b\n\na;b\n"), Ok((';', false)));
        assert_eq!(of(";;\na;b;\n"), Ok((';', false)));
        assert_eq!(of("a\tb\n"), Ok(('\t', false)));
        assert_eq!(of("a ,\t b\n"), Ok((',', false)), "a tab beside a comma is a blank");
        assert_eq!(of("\"a,b\";c\n"), Ok((';', false)));
        assert_eq!(of("SEP=;\r\na, b;c\n"), Ok((';', true)));
        assert_eq!(of("only\n1\n"), Ok((',', false)));
        assert!(of("a,b;c\n").is_err());
    }
}
