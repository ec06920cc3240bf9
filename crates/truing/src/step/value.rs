//! Values of the attributes of an entity.

use super::StepProblem;
use super::scanner::Scanner;

/// What an attribute holds; that of a type, `LENGTH_MEASURE(25.4)`, is what the type holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value<'a> {
    Number(f64),
    /// As written, escapes included.
    Text(&'a [u8]),
    /// Without its dots.
    Enumeration(&'a str),
    Reference(u64),
    /// `$`, or `*` where it follows from others.
    Absent,
    List(Vec<Self>),
}

/// Lists within lists; surfaces have two.
const MAX_DEPTH: usize = 16;

impl<'a> Value<'a> {
    /// The number of an entity that it refers to.
    pub(super) fn reference(&self) -> Option<u64> {
        match self {
            Self::Reference(id) => Some(*id),
            _ => None,
        }
    }

    pub(super) fn read(scanner: &mut Scanner<'a>, depth: usize) -> Result<Self, StepProblem> {
        if depth > MAX_DEPTH {
            return Err(StepProblem::TooDeep { line: scanner.line });
        }
        scanner.skip_blank()?;
        let Some(byte) = scanner.peek() else {
            return Err(StepProblem::Truncated { line: scanner.line });
        };
        Ok(match byte {
            b'#' => Self::Reference(scanner.id()?),
            b'\'' => Self::Text(scanner.quoted(byte)?),
            b'"' => {
                scanner.quoted(byte)?;
                Self::Absent
            }
            b'$' | b'*' => {
                scanner.pass();
                Self::Absent
            }
            b'(' => Self::List(Self::read_list(scanner, depth)?),
            b'.' if !scanner.is_fraction() => {
                scanner.pass();
                let name = scanner.word();
                scanner.expect(b'.', "`.` behind a name")?;
                Self::Enumeration(name)
            }
            b'0'..=b'9' | b'+' | b'-' | b'.' => Self::read_number(scanner)?,
            byte if byte.is_ascii_alphabetic() || byte == b'!' => {
                scanner.word();
                let mut inner = Self::read_list(scanner, depth)?;
                if inner.len() == 1 { inner.remove(0) } else { Self::List(inner) }
            }
            _ => return Err(scanner.unexpected("a value")),
        })
    }

    /// Values between parentheses.
    pub(super) fn read_list(
        scanner: &mut Scanner<'a>,
        depth: usize,
    ) -> Result<Vec<Self>, StepProblem> {
        scanner.expect(b'(', "`(`")?;
        scanner.skip_blank()?;
        let mut values = Vec::new();
        if scanner.peek() == Some(b')') {
            scanner.pass();
            return Ok(values);
        }
        loop {
            values.push(Self::read(scanner, depth + 1)?);
            scanner.skip_blank()?;
            match scanner.peek() {
                Some(b',') => scanner.pass(),
                Some(b')') => {
                    scanner.pass();
                    return Ok(values);
                }
                _ => return Err(scanner.unexpected("`,` or `)`")),
            }
        }
    }

    fn read_number(scanner: &mut Scanner<'a>) -> Result<Self, StepProblem> {
        let here = scanner.clone();
        let belongs =
            |byte: u8| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.' | b'E' | b'e');
        let number = scanner.while_(belongs).parse::<f64>().ok().filter(|v| v.is_finite());
        number.map(Self::Number).ok_or_else(|| here.unexpected("a finite number"))
    }
}
