use super::quote::{list, quote};
use super::unit::unit_of;

/// What is wrong with a case, and what to do about it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The path leads nowhere.
    #[error("there is no such folder; a case is a folder with a `case.toml` and its tables")]
    NoFolder,
    /// The path is a file.
    #[error("a case is a folder, and this is a file; give the folder that holds `case.toml`")]
    NotAFolder,
    /// A file that the kind needs is absent.
    #[error("the file is missing{}", found_instead(nearest.as_deref()))]
    MissingFile {
        /// A file of the folder with a similar name.
        nearest: Option<String>,
    },
    /// A file that the kind needs is absent, and a workbook is there.
    #[error(
        "the file is missing; there is the workbook {}: save its sheet as CSV, by the name {}",
        quote(workbook),
        quote(file)
    )]
    WorkbookInstead {
        /// The workbook.
        workbook: String,
        /// The file that is missing.
        file: String,
    },
    /// The system refuses to hand the file over.
    #[error("cannot be read: {reason}")]
    Unreadable {
        /// What the system says.
        reason: std::io::ErrorKind,
    },
    /// A folder, a device or a pipe in place of a file.
    #[error("expected an ordinary file, found {found}")]
    NotAFile {
        /// What it is.
        found: &'static str,
    },
    /// Too large to be a table typed or recorded for this purpose.
    #[error("the file has {bytes} bytes; at most {limit} can be read; split the recording")]
    TooLargeFile {
        /// Size.
        bytes: u64,
        /// Largest size accepted.
        limit: u64,
    },
    /// What a program saved in a form of its own, such as a workbook.
    #[error("this is {found}, not a text table; save the sheet as CSV")]
    NotText {
        /// What it is.
        found: &'static str,
    },
    /// Not text.
    #[error("expected UTF-8 text, found byte 0x{byte:02x}; save the file as UTF-8")]
    NotUtf8 {
        /// The first byte that is not part of a character.
        byte: u8,
    },
    /// UTF-16 that breaks off.
    #[error("the UTF-16 text breaks off here; save the file as UTF-8")]
    NotUtf16,
    /// Every other byte is zero, and no mark says in which order.
    #[error("this is UTF-16 without a byte order mark; save the file as UTF-8")]
    Utf16WithoutMark,
    /// A file that `case.toml` names outside of the case folder.
    #[error(
        "{} is outside of the case folder; copy the file into it, or allow it by --allow-outside",
        quote(file)
    )]
    OutsideFolder {
        /// As it is named.
        file: String,
    },
    /// The file holds nothing but comments and blank lines.
    #[error("the table is empty; expected a header row with the columns {}", list(columns))]
    EmptyTable {
        /// Columns that the table needs.
        columns: Vec<String>,
    },
    /// A header and nothing else.
    #[error("the table has a header but no rows")]
    NoRows,
    /// `case.toml` is not TOML.
    #[error("not valid TOML: {message}")]
    Syntax {
        /// What the parser says.
        message: String,
    },
    /// A key that the kind does not have.
    #[error("unknown key {}; {}", quote(found), key_advice(found, nearest.as_deref(), expected))]
    UnknownKey {
        /// The key.
        found: String,
        /// The key that was probably meant.
        nearest: Option<String>,
        /// All keys that may stand there.
        expected: Vec<String>,
    },
    /// A key that must be there.
    #[error("{} is missing: {purpose}", quote(key))]
    MissingKey {
        /// The key with its section.
        key: String,
        /// What it is and what to write.
        purpose: &'static str,
    },
    /// A key with a value of the wrong type or range.
    #[error("{message}")]
    WrongValue {
        /// What was found and what was expected.
        message: String,
    },
    /// A word that is not on the list.
    #[error("{}, found {}{}", expected_words(expected), quote(found), did_you_mean(nearest.as_deref()))]
    UnknownWord {
        /// The word.
        found: String,
        /// The word that was probably meant.
        nearest: Option<String>,
        /// Words that may stand there.
        expected: Vec<String>,
    },
    /// A kind of case that this version does not know.
    #[error("unknown kind {}{}; the kinds are {}", quote(found), did_you_mean(nearest.as_deref()), list(expected))]
    UnknownKind {
        /// The kind asked for.
        found: String,
        /// The kind that was probably meant.
        nearest: Option<String>,
        /// Kinds that there are.
        expected: Vec<String>,
    },
    /// Neither of the sets of tables that the kind can work from.
    #[error("no table found; this kind needs {needs}{}", workbook_there(workbook.as_deref()))]
    NoTables {
        /// The alternatives in words.
        needs: &'static str,
        /// A workbook of the folder.
        workbook: Option<String>,
    },
    /// Tables of which only one may be there.
    #[error("this file and {} exclude each other; move one to a case of its own", quote(other))]
    ExclusiveTables {
        /// The other one.
        other: String,
    },
    /// A column that must be there.
    #[error("column {} is missing{}{}", quote(column), in_unit(column), found_instead(nearest.as_deref()))]
    MissingColumn {
        /// Its name.
        column: String,
        /// A column with a similar name.
        nearest: Option<String>,
    },
    /// A column with another unit than the one expected.
    #[error("column {} is not in the unit expected: give it {} and name it {}", quote(found), unit_of(expected).map_or_else(String::new, |u| format!("in {u}")), quote(expected))]
    WrongUnit {
        /// The column's name.
        found: String,
        /// The name expected.
        expected: String,
    },
    /// An optional column whose name differs in letter case alone.
    #[error("column {} is not known; name it {}", quote(found), quote(expected))]
    WrongCase {
        /// The column's name.
        found: String,
        /// The name expected.
        expected: String,
    },
    /// Columns of which only one may be there.
    #[error("columns {} and {} exclude each other; remove one", quote(column), quote(other))]
    ExclusiveColumns {
        /// One.
        column: String,
        /// The other.
        other: String,
    },
    /// Readings of another axis in a table of one.
    #[error(
        "it is of axis {}, and the rows before are of {}; a case is one axis, keep one per folder",
        quote(second),
        quote(first)
    )]
    SecondAxis {
        /// That of the first row.
        first: String,
        /// That of this one.
        second: String,
    },
    /// Two columns with one name.
    #[error("duplicate column {}; it is column {first} already", quote(column))]
    DuplicateColumn {
        /// The name.
        column: String,
        /// Number of the first column with that name, from 1.
        first: usize,
    },
    /// A column without a name.
    #[error("the header's cell is empty; name the column or remove it")]
    UnnamedColumn,
    /// More columns than anybody recorded on purpose.
    #[error("the header has {got} columns; at most {limit} can be read")]
    TooManyColumns {
        /// Number of columns.
        got: usize,
        /// Largest number accepted.
        limit: usize,
    },
    /// A header whose cells are separated in two ways.
    #[error(
        "the header has both a {first} and a {second} between its cells; write `sep=;` (or the \
         separator that it is) as the first line, or put names with a {first} between quotes"
    )]
    MixedSeparators {
        /// Name of one separator.
        first: &'static str,
        /// Name of the other.
        second: &'static str,
    },
    /// Digits in groups of three.
    #[error(
        "found {}: digits in groups cannot be told from decimals; write the number without them",
        quote(found)
    )]
    GroupedDigits {
        /// The cell.
        found: String,
    },
    /// Decimals with a point in one cell and with a comma in another.
    #[error(
        "found {}, with a point, where {} in line {line} has a comma; write all decimals alike",
        quote(found),
        quote(other)
    )]
    MixedDecimals {
        /// The cell with a point.
        found: String,
        /// The cell with a comma.
        other: String,
        /// Its line.
        line: usize,
    },
    /// A comma that may be that of decimals or that of thousands.
    #[error(
        "found {}, which may be {} or {}, and no other cell decides it; write decimals with a point",
        quote(found),
        found.replacen(',', ".", 1),
        found.replacen(',', "", 1)
    )]
    CommaOrGroups {
        /// The cell.
        found: String,
    },
    /// The first row holds data.
    #[error("the first row holds numbers; expected the names of the columns")]
    NoHeader,
    /// A row with too many or too few cells.
    #[error(
        "expected {expected} cells as in the header, found {found}{}",
        if found > expected && *separator == "comma" {
            "; where decimals have a comma, separate the cells by semicolons"
        } else {
            ""
        }
    )]
    RaggedRow {
        /// Columns of the header.
        expected: usize,
        /// Cells of the row.
        found: usize,
        /// Name of what separates the cells.
        separator: &'static str,
    },
    /// A cell that runs over the end of a line.
    #[error("the cell spans several lines; close the quote opened in it")]
    LineBreakInCell,
    /// Nothing where something must be.
    #[error("expected {expected}, found an empty cell")]
    EmptyCell {
        /// What belongs there.
        expected: String,
    },
    /// Text where a number must be.
    #[error("expected {expected}, found {}{}", quote(found), comma_advice(found))]
    NotANumber {
        /// The cell.
        found: String,
        /// What belongs there.
        expected: String,
    },
    /// A number too large for any measurement, or infinite, or NaN.
    #[error("expected {expected} of magnitude below {limit:e}, found {}", quote(found))]
    OutOfRange {
        /// The cell.
        found: String,
        /// What belongs there.
        expected: String,
        /// Largest magnitude accepted.
        limit: f64,
    },
    /// A standard uncertainty or a length that is zero, negative or absurdly small.
    #[error("expected {expected} above {limit:e}, found {}", quote(found))]
    NotPositive {
        /// The cell.
        found: String,
        /// What belongs there.
        expected: String,
        /// Values must be larger.
        limit: f64,
    },
    /// The same id twice.
    #[error(
        "duplicate {what} {}, first used in line {first}; every {what} needs a name of its own",
        quote(id)
    )]
    DuplicateId {
        /// What it names.
        what: &'static str,
        /// The id.
        id: String,
        /// Line of its first use.
        first: usize,
    },
    /// A reference to an id that does not exist.
    #[error("{what} {} is not in {table}{}", quote(id), did_you_mean(nearest.as_deref()))]
    UnknownId {
        /// What it names.
        what: &'static str,
        /// The id.
        id: String,
        /// Where it should be.
        table: &'static str,
        /// An id with a similar name.
        nearest: Option<String>,
    },
    /// An id that nothing refers to.
    #[error("{what} {} has no rows in {table}; measure it or remove it", quote(id))]
    UnusedId {
        /// What it names.
        what: &'static str,
        /// The id.
        id: String,
        /// Where its rows should be.
        table: &'static str,
    },
    /// A quaternion that is not one.
    #[error("expected a unit quaternion (qw, qx, qy, qz), found one of length {length}")]
    NotAUnitQuaternion {
        /// Its length.
        length: f64,
    },
    /// A column that `[loop]` names and that is not there.
    #[error("no column {}{}; the columns are {}", quote(column), did_you_mean(nearest.as_deref()), list(columns))]
    NoGroupColumn {
        /// The column asked for.
        column: String,
        /// The column that was probably meant.
        nearest: Option<String>,
        /// Columns that there are.
        columns: Vec<String>,
    },
    /// Something recorded over several rows with two values of what it has but one of.
    #[error(
        "{what} {} has {} and {} in column {}; one {what} has one {}",
        quote(id),
        quote(first),
        quote(second),
        quote(column),
        quote(column)
    )]
    TwoValues {
        /// What the id names.
        what: &'static str,
        /// The id.
        id: String,
        /// The column.
        column: String,
        /// One value.
        first: String,
        /// Another.
        second: String,
    },
    /// A press, recorded over several rows, that lies in two groups.
    #[error(
        "{what} {} has both {} and {} in column {}; one {what} belongs to one group",
        quote(id),
        quote(first),
        quote(second),
        quote(column)
    )]
    SplitGroup {
        /// What the id names.
        what: &'static str,
        /// The id.
        id: String,
        /// The column.
        column: String,
        /// One value.
        first: String,
        /// Another.
        second: String,
    },
}

fn expected_words(expected: &[String]) -> String {
    if expected.is_empty() {
        "expected nothing: this case has no such names".to_owned()
    } else {
        format!("expected one of {}", list(expected))
    }
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |n| format!("; did you mean {}?", quote(n)))
}

fn found_instead(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |n| format!("; there is {}: is that a slip?", quote(n)))
}

fn workbook_there(workbook: Option<&str>) -> String {
    let advice =
        |found| format!("; there is the workbook {}: save its sheets as CSV", quote(found));
    workbook.map_or_else(String::new, advice)
}

fn in_unit(column: &str) -> String {
    unit_of(column).map_or_else(String::new, |unit| format!(" (a number in {unit})"))
}

fn key_advice(found: &str, nearest: Option<&str>, expected: &[String]) -> String {
    match nearest {
        Some(n) if super::unit::differs_in_unit(found, n) => {
            let unit = unit_of(n).unwrap_or("its unit");
            format!("give the value in {unit} and name the key {}", quote(n))
        }
        Some(n) => format!("did you mean {}?", quote(n)),
        None if expected.is_empty() => "nothing belongs here".to_owned(),
        None => format!("expected one of {}", list(expected)),
    }
}

fn comma_advice(found: &str) -> &'static str {
    let with_point = found.replacen(',', ".", 1);
    if found.contains(',') && with_point.parse::<f64>().is_ok() {
        "; write decimals with a point"
    } else {
        ""
    }
}
