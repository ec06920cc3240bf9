//! Text from a file, made fit for one line of an error message.

/// Longest excerpt shown; a cell of a megabyte must not become the message.
const MAX_CHARS: usize = 40;

/// `text` between backticks, control characters escaped, shortened when long.
pub(crate) fn quote(text: &str) -> String {
    let mut quoted = String::from("`");
    for (n, c) in text.chars().enumerate() {
        if n == MAX_CHARS {
            quoted.push('…');
            break;
        }
        if c.is_control() {
            quoted.extend(c.escape_default());
        } else {
            quoted.push(c);
        }
    }
    quoted.push('`');
    quoted
}

/// `names` in backticks, separated by commas.
pub(crate) fn list<S: AsRef<str>>(names: &[S]) -> String {
    names.iter().map(|n| quote(n.as_ref())).collect::<Vec<_>>().join(", ")
}
