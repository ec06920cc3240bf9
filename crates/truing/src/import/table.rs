use std::path::Path;
use std::str::FromStr;

use super::heading::{Factor, factor, has_unit, heading};
use super::target::{SYNONYMS, Target, targets};
use crate::Error;
use crate::case::{Ledger, Location, Problem, Table, decode, list, nearest, quote};
use crate::file::{InputFile, MAX_BYTES, read_bytes};
use crate::kinds::KINDS;

/// A column of a foreign table, the column that it becomes, and its unit where its heading says none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnMap {
    /// Heading in the foreign table.
    pub theirs: String,
    /// Column of the case's table.
    pub ours: String,
    /// Unit of the foreign column, in place of the one that its heading says.
    pub unit: Option<String>,
}

impl FromStr for ColumnMap {
    type Err = &'static str;

    /// `their column=our column[unit]`, the unit optional.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const EXPECTED: &str = "expected \"their column=our column[unit]\", the unit optional";
        let (theirs, ours) = text.rsplit_once('=').ok_or(EXPECTED)?;
        let (ours, unit) = match ours.split_once('[') {
            Some((ours, unit)) => (ours, Some(unit.trim().strip_suffix(']').ok_or(EXPECTED)?)),
            None => (ours, None),
        };
        let [theirs, ours] = [theirs, ours].map(|name| name.trim().to_owned());
        if theirs.is_empty() || ours.is_empty() || unit.is_some_and(str::is_empty) {
            return Err(EXPECTED);
        }
        Ok(Self { theirs, ours, unit: unit.map(str::to_owned) })
    }
}

/// What a foreign table is to become.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TableImport {
    /// Kind of the case.
    pub kind: String,
    /// Its table; `None` where the kind has one that is usual.
    pub table: Option<String>,
    /// Columns that are not to be guessed.
    pub map: Vec<ColumnMap>,
}

/// A foreign table as files of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ImportedTable {
    /// Rows.
    pub n_rows: usize,
    /// `case.toml`, with its keys for the user to fill in.
    pub case: (&'static str, String),
    /// The table.
    pub table: (&'static str, String),
    /// How the foreign table was understood.
    pub notes: Vec<String>,
}

/// Why a foreign table does not become one of a case.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImportProblem {
    /// No such table, or several of which none was named.
    #[error(
        "{}a case of kind {kind} has the tables {}; say which by --table",
        found.as_ref().map_or_else(String::new, |f| format!("there is no {}: ", quote(f))),
        list(known)
    )]
    WhichTable {
        /// Kind of the case.
        kind: &'static str,
        /// The table asked for.
        found: Option<String>,
        /// Those that there are.
        known: Vec<&'static str>,
    },
    /// A map from a column that the file does not have.
    #[error("there is no column {} in it{}; it has {}", quote(theirs), did_you_mean(nearest.as_deref()), list(columns))]
    NotTheirs {
        /// The column asked for.
        theirs: String,
        /// One with a similar name.
        nearest: Option<String>,
        /// Those that there are.
        columns: Vec<String>,
    },
    /// A map to a column that the table does not have.
    #[error("{table} has no column {}{}; it has {}", quote(ours), did_you_mean(nearest.as_deref()), list(columns))]
    NotOurs {
        /// The table.
        table: &'static str,
        /// The column asked for.
        ours: String,
        /// One with a similar name.
        nearest: Option<String>,
        /// Those that there are.
        columns: Vec<&'static str>,
    },
    /// Two columns for one.
    #[error("{} and {} cannot both become `{ours}`", quote(first), quote(second))]
    Twice {
        /// The column.
        ours: String,
        /// One.
        first: String,
        /// The other.
        second: String,
    },
    /// Several columns that could be meant.
    #[error("`{ours}` may be any of {}; say which by --map \"{}={ours}\"", list(candidates), candidates[0])]
    Ambiguous {
        /// The column.
        ours: &'static str,
        /// Columns of the file that could be meant.
        candidates: Vec<String>,
    },
    /// No columns that could be meant.
    #[error(
        "none of its columns is {} by its name; say which by {}; it has {}",
        list(ours),
        maps(ours),
        list(candidates)
    )]
    Unmatched {
        /// The columns.
        ours: Vec<String>,
        /// Columns of the file that are not used.
        candidates: Vec<String>,
    },
    /// A column of which the unit is not known.
    #[error(
        "column {} says no unit; say it by --map \"{theirs}={ours}[UNIT]\", such as [mm]",
        quote(theirs)
    )]
    NoUnit {
        /// The column of the file.
        theirs: String,
        /// What it becomes.
        ours: &'static str,
    },
    /// A unit of another quantity, or none.
    #[error("column {} is in {}, which is no unit of `{ours}`", quote(theirs), quote(unit))]
    OtherUnit {
        /// The column of the file.
        theirs: String,
        /// What it becomes.
        ours: &'static str,
        /// The unit.
        unit: String,
    },
    /// A column that stays and one that is mapped under the same name.
    #[error(
        "column {} would stay beside the one that becomes `{}`; rename it, or map it",
        quote(name),
        name
    )]
    NameTaken {
        /// The name.
        name: String,
    },
}

/// Makes a table of a case of one that another program wrote.
///
/// Columns that are not mapped are guessed where their heading says what they are; the others stay
/// as they are, to be covariates or labels.
///
/// # Errors
///
/// [`Error::UnknownKind`], [`Error::NotRead`], [`Error::Case`] for a table that cannot be read,
/// [`Error::Import`].
pub fn import_table(path: &Path, import: &TableImport) -> Result<ImportedTable, Error> {
    let fail = |problem| Error::Import { path: path.to_owned(), problem: Box::new(problem) };
    let target = target(import)?.map_err(fail)?;
    let bytes = read_bytes(path, MAX_BYTES).map_err(|problem| Error::not_read(path, problem))?;
    let input = InputFile::given(path, &bytes);
    let (at, ledger) = (Location::file(path), Ledger::default());
    let decoded = decode(bytes)
        .map_err(|e| Error::case(at.clone().line(e.line).column(e.column), *e.problem))?;
    if let Some(encoding) = decoded.encoding {
        ledger.note(&at, encoding.to_owned());
    }
    let table = Table::read(at, &decoded.text, target.needed, &ledger)?;
    let columns = assigned(&table, target, &import.map).map_err(fail)?;
    for column in columns.iter().filter(|c| c.is_guessed) {
        table.note(format!("{} taken for `{}`", quote(&table.names()[column.theirs]), column.ours));
    }
    let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let origin = format!("{}, sha256 {}", name.escape_debug(), input.sha256);
    Ok(ImportedTable {
        n_rows: table.n_rows(),
        case: ("case.toml", case_toml(target.kind, &origin)),
        table: (target.file, format!("# {origin}\n{}", written(&table, &columns)?)),
        notes: ledger.notes(),
    })
}

fn target(import: &TableImport) -> Result<Result<&'static Target, ImportProblem>, Error> {
    let kind = KINDS.iter().map(|kind| kind.name).find(|name| *name == import.kind);
    let Some(kind) = kind else {
        let names = KINDS.iter().map(|kind| kind.name);
        return Err(Error::UnknownKind {
            found: import.kind.clone(),
            nearest: nearest(&import.kind, names.clone()),
            expected: names.collect(),
        });
    };
    let found = match &import.table {
        Some(name) => targets(kind).find(|target| target.file == name),
        None => targets(kind).next().filter(|_| kind != "ft-center"),
    };
    Ok(found.ok_or_else(|| ImportProblem::WhichTable {
        kind,
        found: import.table.clone(),
        known: targets(kind).map(|target| target.file).collect(),
    }))
}

/// What to say on the command line for columns that were not found, the first one with a unit too.
fn maps(ours: &[String]) -> String {
    let map = |name: &str, unit: &str| format!("--map \"THEIRS={name}{unit}\"");
    match ours {
        [] => String::new(),
        [one] => map(one, ""),
        [first, ..] => {
            let with_unit = ours.iter().find(|name| has_unit(name));
            let unit = with_unit.map_or_else(String::new, |name| {
                format!(", where their heading says no unit also that: {}", map(name, "[UNIT]"))
            });
            format!("{}, one for each{unit}", map(first, ""))
        }
    }
}

/// A column of the table to write.
struct Assigned {
    ours: &'static str,
    /// Column of the foreign table.
    theirs: usize,
    factor: Factor,
    is_guessed: bool,
}

fn assigned(
    table: &Table,
    target: &Target,
    map: &[ColumnMap],
) -> Result<Vec<Assigned>, ImportProblem> {
    let names = table.names();
    let known: Vec<&'static str> = target.needed.iter().chain(target.optional).copied().collect();
    let mut columns = mapped(table, target, &known, map)?;
    let mut unmatched: Vec<String> = Vec::new();
    for &ours in known.iter().filter(|ours| map.iter().all(|m| m.ours != **ours)) {
        let is_found = guess(table, ours, &mut columns)?;
        if !is_found && target.needed.contains(&ours) {
            unmatched.push(ours.to_owned());
        }
    }
    if !unmatched.is_empty() {
        let free = (0..names.len()).filter(|index| columns.iter().all(|c| c.theirs != *index));
        let candidates = free.map(|index| names[index].clone()).collect();
        return Err(ImportProblem::Unmatched { ours: unmatched, candidates });
    }
    let stays = |index: &usize| columns.iter().all(|c| c.theirs != *index);
    let taken =
        (0..names.len()).filter(stays).find(|i| columns.iter().any(|c| c.ours == names[*i]));
    match taken {
        Some(index) => Err(ImportProblem::NameTaken { name: names[index].clone() }),
        None => Ok(columns),
    }
}

/// Columns that are said.
fn mapped(
    table: &Table,
    target: &Target,
    known: &[&'static str],
    map: &[ColumnMap],
) -> Result<Vec<Assigned>, ImportProblem> {
    let names = table.names();
    let mut columns: Vec<Assigned> = Vec::new();
    for ColumnMap { theirs, ours, unit } in map {
        let Some(ours) = known.iter().copied().find(|name| name == ours) else {
            let nearest = nearest(ours, known.iter().copied()).map(str::to_owned);
            let (table, ours) = (target.file, ours.clone());
            let columns = known.to_vec();
            return Err(ImportProblem::NotOurs { table, ours, nearest, columns });
        };
        let Some(index) = table.column(theirs) else {
            let nearest = nearest(theirs, names.iter().map(String::as_str)).map(str::to_owned);
            let (theirs, columns) = (theirs.clone(), names.to_vec());
            return Err(ImportProblem::NotTheirs { theirs, nearest, columns });
        };
        if let Some(other) = columns.iter().find(|c| c.ours == ours) {
            let (ours, first) = (ours.to_owned(), names[other.theirs].clone());
            return Err(ImportProblem::Twice { ours, first, second: theirs.clone() });
        }
        let factor = factor_of(theirs, ours, unit.as_deref())?;
        columns.push(Assigned { ours, theirs: index, factor, is_guessed: false });
    }
    Ok(columns)
}

/// Finds the column that `ours` is by its heading, among those that are not used; says whether
/// there is one.
fn guess(
    table: &Table,
    ours: &'static str,
    columns: &mut Vec<Assigned>,
) -> Result<bool, ImportProblem> {
    let names = table.names();
    let free: Vec<usize> =
        (0..names.len()).filter(|index| columns.iter().all(|c| c.theirs != *index)).collect();
    let named = |indices: &[usize]| indices.iter().map(|i| names[*i].clone()).collect();
    let candidates: Vec<usize> = match table.column(ours).filter(|own| free.contains(own)) {
        Some(own) => vec![own],
        None => free.iter().copied().filter(|index| means(&names[*index], ours)).collect(),
    };
    match candidates[..] {
        [] => Ok(false),
        [theirs] => {
            let factor = factor_of(&names[theirs], ours, None)?;
            columns.push(Assigned { ours, theirs, factor, is_guessed: names[theirs] != ours });
            Ok(true)
        }
        _ => Err(ImportProblem::Ambiguous { ours, candidates: named(&candidates) }),
    }
}

/// Whether a heading says the same as the name of a column, its unit aside.
fn means(theirs: &str, ours: &str) -> bool {
    let (words, own) = (heading(theirs).words, heading(ours).words);
    let synonyms = SYNONYMS.iter().find(|(name, _)| *name == ours).map_or(&[][..], |(_, s)| s);
    let is_meant = |word: &String| own.contains(word) || synonyms.contains(&word.as_str());
    words == own || !(synonyms.is_empty() || words.is_empty()) && words.iter().all(is_meant)
}

fn factor_of(
    theirs: &str,
    ours: &'static str,
    unit: Option<&str>,
) -> Result<Factor, ImportProblem> {
    if !has_unit(ours) {
        return Ok(Factor::ONE);
    }
    let said = heading(theirs).unit;
    let Some(unit) = unit.or(said.as_deref()) else {
        return Err(ImportProblem::NoUnit { theirs: theirs.to_owned(), ours });
    };
    let (theirs, unit) = (theirs.to_owned(), unit.to_owned());
    factor(&unit, ours).ok_or(ImportProblem::OtherUnit { theirs, ours, unit })
}

/// The table with its own columns first and the others as they are.
fn written(table: &Table, columns: &[Assigned]) -> Result<String, Error> {
    let others: Vec<usize> = (0..table.names().len())
        .filter(|index| columns.iter().all(|c| c.theirs != *index))
        .collect();
    let mut text = String::new();
    let own = columns.iter().map(|c| c.ours);
    push_row(&mut text, own.chain(others.iter().map(|i| table.names()[*i].as_str())));
    for row in 0..table.n_rows() {
        let own = columns.iter().map(|c| cell(table, row, c)).collect::<Result<Vec<_>, _>>()?;
        let rest = others.iter().map(|index| table.cell(row, *index));
        push_row(&mut text, own.iter().map(String::as_str).chain(rest));
    }
    Ok(text)
}

fn cell(table: &Table, row: usize, column: &Assigned) -> Result<String, Error> {
    let cell = table.cell(row, column.theirs);
    if column.factor == Factor::ONE || cell.is_empty() {
        return Ok(cell.to_owned());
    }
    cell.parse::<f64>().map(|value| column.factor.of(value).to_string()).map_err(|_| {
        let (found, expected) = (cell.to_owned(), "a number".to_owned());
        let problem = Problem::NotANumber { found, expected };
        Error::case(table.at_cell(row, column.theirs), problem)
    })
}

fn push_row<'c>(text: &mut String, cells: impl Iterator<Item = &'c str>) {
    for (n, cell) in cells.enumerate() {
        if n > 0 {
            text.push(',');
        }
        // A comment's sign at the start of a row would make it one.
        if cell.contains([',', '"', '#']) {
            text.push('"');
            text.push_str(&cell.replace('"', "\"\""));
            text.push('"');
        } else {
            text.push_str(cell);
        }
    }
    text.push('\n');
}

/// The settings of the kind's example, none of them in force: an example's numbers are nobody's.
fn case_toml(kind: &str, origin: &str) -> String {
    let example = KINDS.iter().find(|k| k.name == kind).map_or(&[][..], |k| k.example);
    let settings = example.iter().find(|(name, _)| *name == "case.toml").map_or("", |(_, t)| t);
    let mut text = format!(
        "# Imported from {origin}.\n# Below are settings of this kind with the values of an example: \
         take what you need, with your own.\n"
    );
    for line in settings.lines() {
        let is_set = !(line.is_empty() || line.starts_with('#') || line.starts_with("kind"));
        text.push_str(if is_set { "# " } else { "" });
        text.push_str(line);
        text.push('\n');
    }
    text
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map_or_else(String::new, |n| format!("; did you mean {}?", quote(n)))
}
