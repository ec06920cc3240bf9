use super::hypothesis::{Hypothesis, Proof};
use super::misfit::Misfit;
use super::named::Suspect;
use super::order::exchanged_with;
use super::physics::{Contest, Physics};
use super::search::{Found, Plain, Trials};
use crate::case::{Change, Edit};
use crate::kind::Files;
use crate::measured::{Fitted, Reading};
use crate::settled::Settled;
use crate::{Case, Error};

/// Touches left out at most to see whether the others fit: of more, the refusal says enough.
const MOST_FAR_OFF: usize = 20;
/// Mistakes named in one case at most: what needs more was not one case.
const MOST_MISTAKES: usize = 3;

/// A case with what is wrong with its input.
#[derive(Debug, Default)]
pub(crate) struct Examined {
    pub(crate) suspects: Vec<Suspect>,
    /// The case as it would be with every mistake mended that can be; `None` where none can.
    pub(crate) corrected: Option<Case>,
    /// The loop closed on that case with nothing carried to it, where it had to be.
    pub(crate) closed: Option<Settled>,
}

/// Looks for mistakes in the input of a case that can be fitted.
pub(crate) fn examine(case: &Case, fitted: &Fitted) -> Result<Examined, Error> {
    let mut examined = Examined::default();
    let mut edits: Vec<Edit> = Vec::new();
    let mut physics: Option<Physics> = None;
    while examined.suspects.len() < MOST_MISTAKES {
        let current = examined.corrected.as_ref().unwrap_or(case);
        let refitted = examined.corrected.as_ref().map(|c| c.measured.fit()).transpose()?;
        let fitted = refitted.as_ref().unwrap_or(fitted);
        let (misfit, yardstick) = Misfit::of(&*current.measured, fitted);
        let plain = Plain { misfit, yardstick };
        let files = &current.files;
        let list = (files.kind.mistakes)(files, Some(fitted));
        let certain = Trials::proved(files, &list, Proof::Certain).first();
        let (found, after) = if certain.is_some() {
            (certain, None)
        } else if plain.is_suspicious() {
            decide(current, &plain, list, &mut physics)
        } else if plain.is_too_good() {
            (Trials::of_units(files, list).to_noise(), None)
        } else {
            (Trials::proved(files, &list, Proof::Data).missing(&plain), None)
        };
        let Some(found) = found.map(|found| found.of_all(&current.files)) else { break };
        examined.suspects.push(Suspect::of(&found, Some(&misfit)));
        if found.named.edits.is_empty() {
            break;
        }
        edits.extend(found.named.edits);
        examined.corrected = Some(case.with(&edits)?);
        physics = after;
    }
    examined.closed = physics.and_then(Physics::closed);
    Ok(examined)
}

/// The mistake that a case shows, with what physics makes of the case so mended, where known;
/// `physics` is what it makes of the case as it is, once that was asked.
fn decide(
    case: &Case,
    plain: &Plain,
    list: Vec<Hypothesis>,
    physics: &mut Option<Physics>,
) -> (Option<Found>, Option<Physics>) {
    let trials = Trials::of(&case.files, list, Some(plain));
    let found = trials.explaining(plain);
    if found.as_ref().is_some_and(|found| !found.is_subtle) {
        return (found, None);
    }
    let helping = Physics::helping(&trials, plain);
    let is_unmatched = plain.misfit.share >= plain.yardstick.unmatched;
    if found.is_none() && helping.is_empty() && !is_unmatched {
        return (None, None);
    }
    if found.is_none() && plain.misfit.share >= plain.yardstick.beyond_physics {
        return (Some(unmatched(&case.files, &plain.misfit)), None);
    }
    let physics = physics.get_or_insert_with(|| Physics::of(case));
    if let Some(found) = found {
        match physics.beside_alone(case, &found, &plain.misfit) {
            Contest::Lost => return (Some(found), None),
            Contest::Tied(after_it) => physics.tie(&found, &after_it),
            Contest::Won => {}
        }
    }
    if let Some((found, after)) = physics.beside(case, helping, plain) {
        return (Some(found), Some(after));
    }
    let is_unmatched = is_unmatched && !physics.takes_most(&plain.yardstick);
    (is_unmatched.then(|| unmatched(&case.files, &plain.misfit)), None)
}

/// The error of a case that cannot be fitted, with the mistake that would explain it.
pub(crate) fn named_cause(files: &Files, source: Error) -> Error {
    // What is wrong in form says so itself.
    if matches!(source, Error::Case { .. }) {
        return source;
    }
    // What is left free by too few data, another unit does not hold unless it brings them to the noise.
    let is_free = source.is_undetermined() && !source.is_unsettled();
    let mut list = (files.kind.mistakes)(files, None);
    list.extend(with_another(files, &source));
    let found = Trials::of(files, list, None).mending(is_free).map(|found| found.of_all(files));
    match found.or_else(|| unmatched_but_for_some(files, &source)) {
        Some(found) => {
            let suspect = Suspect::of(&found, None);
            Error::Input { source: Box::new(source), suspect: Box::new(suspect) }
        }
        None => source,
    }
}

/// Tables that do not belong together, where some touches are so far off that nothing can be fitted: the
/// others do not fit either.
fn unmatched_but_for_some(files: &Files, source: &Error) -> Option<Found> {
    let file = files.kind.touches?;
    let mut touch = source.touch()?;
    let mut rows: Vec<usize> = (0..files.folder.table(file, &[]).ok()?.n_rows()).collect();
    for _ in 0..MOST_FAR_OFF {
        if touch >= rows.len() {
            return None;
        }
        rows.remove(touch);
        let edit = Edit { file, change: Change::Keep { rows: rows.clone() } };
        let fit = |reading: Reading| {
            let fitted = reading.measured.fit()?;
            Ok(Misfit::of(&*reading.measured, &fitted))
        };
        match files.with(&[edit]).read().and_then(fit) {
            Ok((misfit, yardstick)) if misfit.share >= yardstick.unmatched => {
                return Some(unmatched(files, &misfit));
            }
            Ok(_) => return None,
            Err(source) => touch = source.touch()?,
        }
    }
    None
}

/// What one touch has of any other, where a refusal says which one is to blame.
fn with_another(files: &Files, source: &Error) -> Vec<Hypothesis> {
    const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
    let Some((file, touch)) = files.kind.touches.zip(source.touch()) else { return Vec::new() };
    let table = files.folder.table(file, &XYZ).ok();
    XYZ.iter().flat_map(|column| exchanged_with(file, table.as_ref(), &[*column], touch)).collect()
}

/// Tables whose numbers have nothing to do with each other, whatever the reason.
fn unmatched(files: &Files, misfit: &Misfit) -> Found {
    let description = format!(
        "what is left is {:.0} % of what was measured, and no single change to a column explains \
         it: the tables do not belong together; look for a table from another session, a clock \
         far off, labels or rows in another order, columns exchanged in more than one place, or units \
         mixed",
        100.0 * misfit.share
    );
    Found::unmended(Hypothesis {
        effect: "input:unmatched",
        subject: files.kind.name.to_owned(),
        description,
        edits: Vec::new(),
        proof: Proof::Data,
        physics: None,
    })
}
