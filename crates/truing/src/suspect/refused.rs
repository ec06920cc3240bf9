//! The cause of a refusal: a mistake in the input with which a case that cannot be fitted could be.

use super::examine::{mistakes, of_last_resort, unmatched, without_far};
use super::hypothesis::{Hypothesis, Proof};
use super::misfit::Misfit;
use super::named::Suspect;
use super::order::{exchanged_with, farthest};
use super::search::{Found, Trials, misfit_with};
use super::some_rows::changes_of_row;
use super::stretch::Stretch;
use super::wrong_rows::{fits_alone, of_no_end, of_rows};
use crate::Error;
use crate::case::{Change, Edit};
use crate::kind::Files;
use crate::measured::Reading;

/// Touches left out at most to see whether the others fit: of more, the refusal says enough.
const MOST_FAR_OFF: usize = 20;
/// Mistakes of a case that cannot be fitted that are looked at beside readings far off, those that leave the least.
const NEAREST: usize = 4;

/// The error of a case that cannot be fitted, with the mistake that would explain it.
pub(crate) fn named_cause(files: &Files, source: Error) -> Error {
    // What is wrong in form says so itself, but for what the data prove to be its cause.
    if matches!(source, Error::Case { .. }) {
        let mut list = mistakes(files, None);
        list.retain(|mistake| !mistake.edits.is_empty());
        return match Trials::proved(files, &list, Proof::Certain).first() {
            Some(found) => caused_by(&found.of_all(files), source),
            None => source,
        };
    }
    // What is left free by too few data, another unit does not hold unless it brings them to the noise.
    let is_free = source.is_undetermined() && !source.is_unsettled();
    let mut list = mistakes(files, None);
    list.extend(with_another(files, &source));
    let last = of_last_resort(&list);
    let trials = Trials::of(files, list, None);
    let found = trials.mending(is_free);
    let beside_far = || {
        let restores = |change: &Hypothesis| {
            let without = without_far(files, change)?;
            let fits = |edits: &[Edit]| {
                misfit_with(files, edits).is_some_and(|left| left.is_noise() && fits_alone(&left))
            };
            // What changes those readings alone is not needed without them.
            let restores = !fits(&without) && fits(&change.and(&without).edits);
            let named = change.clone();
            restores.then(|| Found { named, after: None, rivals: Vec::new(), is_subtle: false })
        };
        trials.nearest(NEAREST).find_map(restores)
    };
    let elsewhere = || {
        let (found, misplaced) = of_rows(files, last.clone(), &fits_alone, (true, None));
        found.or(misplaced).filter(|_| !is_free)
    };
    let found = found.map(|found| of_no_end(files, found, &last));
    let found = found.or_else(beside_far).or_else(elsewhere);
    let found = found.map(|found| found.of_all(files));
    match found.or_else(|| unmatched_but_for_some(files, &source)) {
        Some(found) => caused_by(&found, source),
        None => source,
    }
}

fn caused_by(found: &Found, source: Error) -> Error {
    let suspect = Suspect::of(found, None);
    Error::Input { source: Box::new(source), suspect: Box::new(suspect) }
}

/// Some touches so far off that nothing can be fitted, and others that fit no better: where the rest fits, one change to
/// all of them that mends them, or that they are not of the part; the tables do not belong together where it does not.
fn unmatched_but_for_some(files: &Files, source: &Error) -> Option<Found> {
    let file = files.kind.touches?;
    let mut touch = source.touch()?;
    let n = files.folder.table(file, &[]).ok()?.n_rows();
    let mut rows: Vec<usize> = (0..n).collect();
    for _ in 0..MOST_FAR_OFF {
        if touch >= rows.len() {
            return None;
        }
        rows.remove(touch);
        let edit = Edit { file, change: Change::Keep { rows: rows.clone() } };
        let fit = |reading: Reading| {
            let fitted = reading.measured.fit_alone()?;
            Ok((Misfit::of(&*reading.measured, &fitted), farthest(&fitted, 1)))
        };
        match files.with(&[edit]).read().and_then(fit) {
            Ok(((misfit, yardstick), _)) if misfit.share >= yardstick.unmatched => {
                return Some(unmatched(files, &misfit));
            }
            Ok(((misfit, _), _)) if fits_alone(&misfit) => {
                let wrong = (0..n).filter(|row| rows.binary_search(row).is_err()).collect();
                let stretch = Stretch::of_those(files, file, wrong)?;
                let changed = Trials::of_those(files, stretch.changes(files), None);
                let misplaced = || stretch.misplaced(files).map(Found::unmended);
                return changed.restoring(fits_alone).or_else(misplaced);
            }
            Ok((_, far)) => touch = *far.first()?,
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
    let exchanged = |column: &&str| exchanged_with(file, table.as_ref(), &[*column], touch);
    let mut all: Vec<_> = XYZ.iter().flat_map(exchanged).collect();
    all.extend(changes_of_row((file, table.as_ref()), touch, &XYZ));
    all
}
