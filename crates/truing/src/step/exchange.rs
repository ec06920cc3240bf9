//! Where every entity of a Part 21 file is; each is read when it is asked for.

use super::StepProblem;
use super::entity::Entity;
use super::scanner::Scanner;
use super::value::Value;

/// A file and its entities.
#[derive(Debug)]
pub(super) struct Exchange<'a> {
    bytes: &'a [u8],
    /// By number.
    places: Vec<Place>,
    /// Entities that may hold the shapes of a part, in the order of the file.
    pub(super) representations: Vec<u64>,
    /// Whether parts are placed in an assembly.
    pub(super) is_assembly: bool,
}

/// Where an entity is.
#[derive(Clone, Copy, Debug)]
struct Place {
    id: u64,
    /// Behind the `=`.
    at: usize,
    line: usize,
}

/// First words of a file.
const MAGIC: &str = "ISO-10303-21";

impl<'a> Exchange<'a> {
    /// Looks through a file once, without reading what entities hold.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, StepProblem> {
        let from = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let mut scanner = Scanner::new(bytes, from, 1);
        scanner.skip_blank()?;
        if scanner.word() != MAGIC {
            return Err(StepProblem::NotStep);
        }
        scanner.skip_statement()?;
        let mut this =
            Self { bytes, places: Vec::new(), representations: Vec::new(), is_assembly: false };
        loop {
            scanner.skip_blank()?;
            match scanner.peek() {
                None => return Err(StepProblem::Truncated { line: scanner.line }),
                Some(b'#') => this.note(&mut scanner)?,
                Some(_) if scanner.word() == "END-ISO-10303-21" => break,
                Some(_) => scanner.skip_statement()?,
            }
        }
        this.places.sort_by_key(|place| place.id);
        match this.places.windows(2).find(|pair| pair[0].id == pair[1].id) {
            Some(&[first, second]) => {
                let (id, line, first_line) = (first.id, second.line, first.line);
                Err(StepProblem::Twice { id, line, first_line })
            }
            _ => Ok(this),
        }
    }

    /// Notes where the entity at hand is, and passes it.
    fn note(&mut self, scanner: &mut Scanner<'a>) -> Result<(), StepProblem> {
        let line = scanner.line;
        let id = scanner.id()?;
        scanner.expect(b'=', "`=` behind the number of an entity")?;
        scanner.skip_blank()?;
        self.places.push(Place { id, at: scanner.at, line });
        let keyword = scanner.word();
        if keyword.ends_with("REPRESENTATION") {
            self.representations.push(id);
        }
        self.is_assembly |= matches!(keyword, "ITEM_DEFINED_TRANSFORMATION" | "MAPPED_ITEM");
        scanner.skip_statement()
    }

    /// The entity of a number, which `by` refers to.
    pub(super) fn entity(&self, id: u64, by: u64) -> Result<Entity<'a>, StepProblem> {
        let place = |id: u64| {
            self.places.binary_search_by_key(&id, |place| place.id).ok().map(|at| self.places[at])
        };
        let Some(found) = place(id) else {
            let line = place(by).map_or(0, |by| by.line);
            return Err(StepProblem::Missing { line, by, id });
        };
        let mut scanner = Scanner::new(self.bytes, found.at, found.line);
        let mut records = Vec::new();
        if scanner.peek() == Some(b'(') {
            scanner.pass();
            loop {
                scanner.skip_blank()?;
                if scanner.peek() == Some(b')') {
                    scanner.pass();
                    break;
                }
                records.push(record(&mut scanner)?);
            }
        } else {
            records.push(record(&mut scanner)?);
        }
        scanner.expect(b';', "`;` behind an entity")?;
        Ok(Entity { id, line: found.line, records })
    }
}

/// A keyword and its attributes.
fn record<'a>(scanner: &mut Scanner<'a>) -> Result<(&'a str, Vec<Value<'a>>), StepProblem> {
    let here = scanner.clone();
    let keyword = scanner.word();
    if keyword.is_empty() {
        return Err(here.unexpected("a keyword"));
    }
    Ok((keyword, Value::read_list(scanner, 0)?))
}
