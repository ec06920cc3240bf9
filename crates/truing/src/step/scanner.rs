//! Words, numbers and quoted texts of a Part 21 file, one after the other.

use super::StepProblem;

/// A place in a file, from which it is read on.
#[derive(Clone, Debug)]
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    pub(super) at: usize,
    /// From 1.
    pub(super) line: usize,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize, line: usize) -> Self {
        Self { bytes, at, line }
    }

    /// The byte at hand; `None` at the end of the file.
    pub(super) fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Whether a number without a leading zero begins here, which some programs write.
    pub(super) fn is_fraction(&self) -> bool {
        self.bytes.get(self.at + 1).is_some_and(u8::is_ascii_digit)
    }

    /// Passes the byte at hand.
    pub(super) fn pass(&mut self) {
        if self.peek() == Some(b'\n') {
            self.line += 1;
        }
        self.at += 1;
    }

    /// Passes white space and comments.
    pub(super) fn skip_blank(&mut self) -> Result<(), StepProblem> {
        loop {
            match self.peek() {
                Some(byte) if byte.is_ascii_whitespace() || byte == 0 => self.pass(),
                Some(b'/') if self.bytes.get(self.at + 1) == Some(&b'*') => self.skip_comment()?,
                _ => return Ok(()),
            }
        }
    }

    /// Passes what is left of a statement and the semicolon behind it.
    pub(super) fn skip_statement(&mut self) -> Result<(), StepProblem> {
        let line = self.line;
        while let Some(byte) = self.peek() {
            match byte {
                b'\'' | b'"' => {
                    self.quoted(byte)?;
                }
                b'/' if self.bytes.get(self.at + 1) == Some(&b'*') => self.skip_comment()?,
                _ => {
                    self.pass();
                    if byte == b';' {
                        return Ok(());
                    }
                }
            }
        }
        Err(StepProblem::Truncated { line })
    }

    fn skip_comment(&mut self) -> Result<(), StepProblem> {
        let line = self.line;
        self.at += 2;
        while self.peek().is_some() {
            if self.bytes[self.at..].starts_with(b"*/") {
                self.at += 2;
                return Ok(());
            }
            self.pass();
        }
        Err(StepProblem::Truncated { line })
    }

    /// What stands between two quotes, a doubled one belonging to it.
    pub(super) fn quoted(&mut self, quote: u8) -> Result<&'a [u8], StepProblem> {
        let line = self.line;
        self.at += 1;
        let from = self.at;
        while let Some(byte) = self.peek() {
            self.pass();
            if byte == quote {
                if self.peek() != Some(quote) {
                    return Ok(&self.bytes[from..self.at - 1]);
                }
                self.pass();
            }
        }
        Err(StepProblem::Truncated { line })
    }

    /// The bytes at hand for as long as they belong together.
    pub(super) fn while_(&mut self, belongs: impl Fn(u8) -> bool) -> &'a str {
        let from = self.at;
        while self.peek().is_some_and(|byte| byte.is_ascii() && belongs(byte)) {
            self.at += 1;
        }
        std::str::from_utf8(&self.bytes[from..self.at]).unwrap_or_default()
    }

    /// A keyword: letters, digits, `_`; also `-` and a leading `!`.
    pub(super) fn word(&mut self) -> &'a str {
        self.while_(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'!'))
    }

    /// The number behind a `#`.
    pub(super) fn id(&mut self) -> Result<u64, StepProblem> {
        self.expect(b'#', "`#`")?;
        let digits = self.while_(|byte| byte.is_ascii_digit());
        digits.parse().map_err(|_| self.unexpected("a number of an entity behind `#`"))
    }

    /// Passes a byte that has to be there, and blanks before it.
    pub(super) fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), StepProblem> {
        self.skip_blank()?;
        if self.peek() != Some(byte) {
            return Err(self.unexpected(expected));
        }
        self.pass();
        Ok(())
    }

    /// What is at hand is not what has to be there.
    pub(super) fn unexpected(&self, expected: &'static str) -> StepProblem {
        /// As much as shows where it is.
        const SHOWN: usize = 20;
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let shown = rest.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let found = String::from_utf8_lossy(&shown[..shown.len().min(SHOWN)]).trim().to_owned();
        StepProblem::Syntax { line: self.line, expected, found }
    }
}
