//! What a file is by its first bytes, where that is no text.

/// First bytes that no text begins with, and what begins with them.
const SIGNATURES: [(&[u8], &str); 4] = [
    (b"PK\x03\x04", "a spreadsheet workbook (.xlsx, .ods, .numbers) or another zip archive"),
    (b"\xd0\xcf\x11\xe0", "a spreadsheet workbook (.xls) or another Office document"),
    (b"\x1f\x8b", "a compressed file (gzip)"),
    (b"%PDF-", "a PDF document"),
];

/// What bytes are that are no text.
pub(crate) fn no_text(bytes: &[u8]) -> Option<&'static str> {
    let found = SIGNATURES.iter().find(|(first, _)| bytes.starts_with(first));
    found.map(|(_, what)| *what)
}
