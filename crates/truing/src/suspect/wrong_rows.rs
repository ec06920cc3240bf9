//! Rows that are wrong where no change to a whole column is.

use super::hypothesis::{Hypothesis, Proof};
use super::late::late_channels;
use super::misfit::Misfit;
use super::search::{Found, Trials, misfit_with};
use super::stretch::Stretch;
use super::typed::set_free;
use crate::case::Change;
use crate::kind::Files;

/// Degrees of freedom that rows must leave without which a case can be fitted that cannot with them.
const FEWEST_LEFT: usize = 4;

/// What is asked of a misfit.
pub(super) type Asked<'a> = &'a dyn Fn(&Misfit) -> bool;

/// What is wrong with some rows of a case that no change to all of them explains; else, that they are not of it,
/// where the others fit without them: of readings that physics may have made only where the misfit `is_gross`, or where
/// they leave what `sessions` asks of the others.
pub(super) fn of_rows(
    files: &Files,
    last: Vec<Hypothesis>,
    is_sound: &(impl Fn(&Misfit) -> bool + Sync),
    (is_gross, sessions): (bool, Option<Asked<'_>>),
) -> (Option<Found>, Option<Found>) {
    let mut stretches = Stretch::all_of(files, is_sound);
    let first_of = |list| Trials::of_those(files, list, None).restoring(is_sound);
    let changed = |stretches: &[Stretch]| {
        let found = first_of(stretches.iter().flat_map(|s| s.changes(files)).collect());
        let found =
            found.map(|found| stretches.iter().fold(found, |found, s| s.sharpened(files, found)));
        found.filter(|found| fits_as_the_others(files, found))
    };
    let beyond = || first_of(late_channels(files)).or_else(|| first_of(set_free(files)));
    match changed(&stretches).or_else(|| first_of(last)).or_else(beyond) {
        None => {
            for others in Stretch::in_other_orders(files, is_sound) {
                if let Some(found) = changed(&others) {
                    return (Some(found), None);
                }
                stretches.extend(others);
            }
            if let Some(found) = changed(&Stretch::scattered(files, is_sound)) {
                return (Some(found), None);
            }
            let misplaced = |may_be: &dyn Fn(&&Stretch) -> bool| {
                let those = stretches.iter().filter(may_be);
                Trials::of_those(files, those.filter_map(|s| s.misplaced(files)).collect(), None)
            };
            let of_no_physics = misplaced(&|s| is_gross || s.is_of_places());
            let of_session = |is_session: Asked<'_>| {
                misplaced(&|s| s.is_of_a_session() && s.is_of_the_few())
                    .leaving_most(|misfit| is_session(misfit))
            };
            let found = of_no_physics.leaving_most(is_sound);
            (None, found.or_else(|| sessions.and_then(of_session)))
        }
        found => (found, None),
    }
}

/// Whether rows that a mistake multiplies fit as well as the others then: among dozens of factors one takes most of what
/// lies apart for another reason.
fn fits_as_the_others(files: &Files, found: &Found) -> bool {
    let is_worse = || {
        let (file, rows) = found.named.multiplied()?;
        let of = files.kind.readings.iter().find(|of| of.file == file)?;
        let without = misfit_with(files, &of.without(&files.folder, rows)?)?;
        Some(found.after?.is_worse_of_some(&without))
    };
    !is_worse().unwrap_or(false)
}

/// Whether what is left of a case is noise, of enough rows.
pub(super) fn fits_alone(misfit: &Misfit) -> bool {
    misfit.is_only_noise() && misfit.dof >= FEWEST_LEFT
}

/// Another unit, order or sign of some rows, where that brings the case to the noise as well as leaving out the readings
/// at an end of a range.
pub(super) fn of_no_end(files: &Files, found: Found, last: &[Hypothesis]) -> Found {
    if !found.named.is_of_an_end() {
        return found;
    }
    let kept = found.after.map_or(FEWEST_LEFT, |after| after.dof);
    let (changed, _) = of_rows(files, last.to_vec(), &fits_alone, (true, None));
    let is_of_all = |other: &Found| {
        !other.named.only_leaves_out() && other.after.is_some_and(|after| after.dof > kept)
    };
    changed.filter(is_of_all).unwrap_or(found)
}

/// Rows that are left out for a label that they share, or for the end of a range at which they read, without those that
/// fit: where most do, that is not to blame.
pub(super) fn of_its_wrong_rows(
    files: &Files,
    found: Found,
    fits: &impl Fn(&Misfit) -> bool,
) -> Found {
    let of_few = || {
        let kept = found.named.edits.iter().find_map(|edit| match &edit.change {
            Change::Keep { rows } => {
                let of = files.kind.readings.iter().find(|of| of.file == edit.file)?;
                Some((of, rows))
            }
            _ => None,
        });
        let (of, rows) = kept?;
        let n = files.folder.table(of.file, &[]).ok()?.n_rows();
        let gone: Vec<usize> = (0..n).filter(|row| rows.binary_search(row).is_err()).collect();
        let n_gone = gone.len();
        let wrong = Stretch::of_wrong_ones(files, of, gone, fits)?;
        let named = (2 * wrong.n_wrong() <= n_gone).then(|| wrong.misplaced(files)).flatten()?;
        let after = misfit_with(files, &named.edits);
        Some(Found { named, after, rivals: Vec::new(), is_subtle: found.is_subtle })
    };
    let may_be = found.named.effect == "input:misplaced"
        || found.named.is_of_an_end() && found.named.proof == Proof::Fit;
    may_be.then(of_few).flatten().unwrap_or(found)
}
