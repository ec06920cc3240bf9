use super::declared::{noise_in_another_unit, uncertainties_of_some_rows};
use super::every_table::{numbers_of_every_table, other_rows_of_every_table};
use super::hypothesis::{Hypothesis, Proof};
use super::late::late_channels;
use super::misfit::Misfit;
use super::named::Suspect;
use super::physics::{Contest, Physics};
use super::readings::Readings;
use super::rounded::rounded;
use super::search::{FAR_LESS_NOISE, Found, Plain, Trials, misfit_with};
use super::spike::far_apart;
use super::typed::{SETTING, mistyped};
use super::wrong_rows::{Asked, of_its_wrong_rows, of_no_end, of_rows};
use crate::case::Edit;
use crate::kind::Files;
use crate::measured::Fitted;
use crate::settled::Settled;
use crate::{Case, Error};

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

impl Examined {
    fn unmatched(files: &Files, before: &Misfit) -> Self {
        let suspects = vec![Suspect::of(&unmatched(files, before), Some(before))];
        Self { suspects, ..Self::default() }
    }
}

/// Looks for mistakes in the input of a case that can be fitted.
pub(crate) fn examine(case: &Case, fitted: &Fitted) -> Result<Examined, Error> {
    let mut examined = Examined::default();
    let mut named: Vec<Hypothesis> = Vec::new();
    let mut physics: Option<Physics> = None;
    let mut plainly: Option<Misfit> = None;
    // What the last change leaves, which nothing but the fit speaks for.
    let mut mended: Option<Misfit> = None;
    while examined.suspects.len() < MOST_MISTAKES {
        let current = examined.corrected.as_ref().unwrap_or(case);
        let refitted = examined.corrected.as_ref().map(|c| c.measured.fit()).transpose()?;
        let fitted = refitted.as_ref().unwrap_or(fitted);
        let (misfit, yardstick) = Misfit::of(&*current.measured, fitted);
        let plain = Plain { misfit, yardstick };
        plainly.get_or_insert(misfit);
        let files = &current.files;
        let list = mistakes(files, Some(fitted));
        let certain = Trials::proved(files, &list, Proof::Certain).first();
        let clear: Vec<Hypothesis> =
            list.iter().filter(|mistake| mistake.proof == Proof::Clear).cloned().collect();
        // Where rows were left out, what is left of the mistake at their ends looks like others.
        let left_out = examined.suspects.last().is_some_and(Suspect::leaves_out_what_misfits);
        let (found, after) = if certain.is_some() {
            (certain, None)
        } else if left_out && !plain.is_gross() {
            break;
        } else if plain.is_suspicious() {
            decide(current, &plain, list, &mut physics)
        } else if plain.is_too_good() {
            (Trials::of_units(files, list).to_noise(), None)
        } else {
            (Trials::proved(files, &list, Proof::Data).missing(&plain), None)
        };
        let found = found.or_else(|| rounded_beside(current, &plain, &mut physics));
        let found = found.or_else(|| noise_too_small(current, &plain, &mut physics));
        let found = found.or_else(|| Trials::of_those(files, clear, None).first());
        let Some(found) = found.map(|found| found.of_all(&current.files)) else { break };
        if let Some(again) = named.iter().position(|known| known.is(&found.named)) {
            return without_what_is_undone(case, named, again, &plainly.unwrap_or(misfit));
        }
        examined.suspects.push(Suspect::of(&found, Some(&misfit)));
        if found.named.edits.is_empty() {
            mended = None;
            break;
        }
        mended = found.after.filter(|_| found.named.proof == Proof::Fit);
        named.push(found.named);
        examined.corrected = Some(case.with(&edits_of(&named))?);
        physics = after;
    }
    // Changes that leave the case as it never is, or numbers too small to miss anything, mend nothing.
    if let Some(before) = plainly.filter(|_| mended.is_some_and(|left| left.is_of_none())) {
        return Ok(Examined::unmatched(&case.files, &before));
    }
    examined.closed = physics.and_then(Physics::closed);
    Ok(examined)
}

/// What may be wrong with the input of a case.
pub(super) fn mistakes(files: &Files, fitted: Option<&Fitted>) -> Vec<Hypothesis> {
    let mut all = numbers_of_every_table(files, fitted);
    all.extend((files.kind.mistakes)(files, fitted));
    all.extend(other_rows_of_every_table(files));
    all.extend(mistyped(&files.document, files.kind.typed));
    all
}

/// The mistake that a case shows, with what physics makes of the case so mended, where known;
/// `physics` is what it makes of the case as it is, once that was asked.
fn decide(
    case: &Case,
    plain: &Plain,
    list: Vec<Hypothesis>,
    physics: &mut Option<Physics>,
) -> (Option<Found>, Option<Physics>) {
    if plain.is_far_from_noise() {
        let of_noise = Trials::of_those(&case.files, uncertainties_of_some_rows(&case.files), None);
        if let Some(found) = of_noise.restoring(Misfit::is_noise) {
            return (Some(found), None);
        }
    }
    let last = of_last_resort(&list);
    let trials = Trials::of(&case.files, list, Some(plain));
    let mut found = trials.explaining(plain);
    let mut misplaced = None;
    let is_mended = |found: &Found| found.after.is_some_and(|after| after.is_sound());
    let is_far = plain.is_gross() || plain.is_far_from_noise();
    if found.is_none() && !is_far {
        found = Trials::of_those(&case.files, late_channels(&case.files), None).explaining(plain);
    }
    let is_mended = found.as_ref().is_some_and(is_mended);
    if is_mended && is_far {
        let is_sound = |misfit: &Misfit| plain.is_sound(misfit);
        found = found.map(|found| of_no_end(&case.files, found, &last));
        found = found.map(|found| of_its_wrong_rows(&case.files, found, &is_sound));
    }
    if !is_mended && is_far {
        let is_sound = |misfit: &Misfit| plain.is_sound(misfit);
        let is_session = |misfit: &Misfit| plain.is_of_another_session(misfit);
        // Of a gross misfit all stretches are asked for already.
        let may_be_sessions = !plain.is_gross() && plain.may_be_of_another_session();
        let sessions = may_be_sessions.then_some(&is_session as Asked<'_>);
        let (of_some, elsewhere) =
            of_rows(&case.files, last, &is_sound, (plain.is_gross(), sessions));
        if of_some.is_some() || elsewhere.is_some() {
            found = of_some.map(|of_some| {
                // A number that is free explains what physics does.
                let is_subtle = !plain.is_gross() || of_some.named.effect == SETTING;
                Found { is_subtle, ..of_some }
            });
        }
        misplaced = elsewhere;
    }
    if found.as_ref().is_some_and(|found| !found.is_subtle && found.named.physics.is_none()) {
        return (found, None);
    }
    let helping = Physics::helping(&trials, plain);
    if found.is_none()
        && let Some(found) = beside_far_readings(case, &trials, &helping)
    {
        return (Some(found), None);
    }
    let is_unmatched = plain.misfit.share >= plain.yardstick.unmatched;
    let mut is_misplaced = misplaced.is_some();
    if found.is_none() && helping.is_empty() && !is_unmatched && !is_misplaced {
        return (None, None);
    }
    // Readings that lie apart together, as those of one load do while it is warm, need not be of another session.
    if found.is_none() && is_misplaced && !plain.is_gross() {
        let physics = physics.get_or_insert_with(|| Physics::of(case));
        if physics.sets_some_apart() {
            (misplaced, is_misplaced) = (None, false);
        }
    }
    // What physics may have made may have been rounded.
    if found.is_none()
        && is_misplaced
        && !plain.is_gross()
        && let Some(found) = rounded_beside(case, plain, physics)
    {
        return (Some(found), None);
    }
    let of_place = misplaced.as_ref().is_some_and(|found| is_of_a_place(&case.files, found));
    let unmatched = || misplaced.unwrap_or_else(|| unmatched(&case.files, &plain.misfit));
    if found.is_none() && plain.misfit.share >= plain.yardstick.beyond_physics {
        return (Some(unmatched()), None);
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
    let is_unmatched = if is_misplaced {
        // A place that moved while it was measured is no wrong number of a table.
        let moved = !plain.is_gross() && of_place && physics.takes_most(&plain.yardstick);
        let explained = physics.has_names() && physics.is_explained() && physics.has_names_alone();
        !(moved || explained)
    } else {
        is_unmatched && !physics.takes_most(&plain.yardstick)
    };
    (is_unmatched.then(unmatched), None)
}

/// The mistake that a case shows without a few readings which are far off all others once it is mended: these are for
/// the next look.
fn beside_far_readings(case: &Case, trials: &Trials, helping: &[Found]) -> Option<Found> {
    let of_one = |helps: &Found| {
        let without = without_far(&case.files, &helps.named)?;
        let left = case.with(&without).ok()?;
        let (misfit, yardstick) = Misfit::of(&*left.measured, &left.measured.fit_alone().ok()?);
        let changes = trials.in_their_order(helping);
        let whole = changes.iter().filter(|change| !change.leaves_out());
        let found =
            Trials::of_those(&case.files, whole.map(|change| change.and(&without)).collect(), None)
                .explaining(&Plain { misfit, yardstick })?;
        let loses = || {
            let contest = Physics::of(&left).beside_alone(case, &found, &misfit);
            matches!(contest, Contest::Lost)
        };
        let named = changes.iter().find(|change| change.is(&found.named))?.clone();
        // What it leaves is of the case without these readings.
        (!found.is_subtle || loses()).then_some(Found { named, after: None, ..found })
    };
    helping.iter().find_map(of_one)
}

/// The case without the few readings that are far off all others once a mistake is mended.
pub(super) fn without_far(files: &Files, mistake: &Hypothesis) -> Option<Vec<Edit>> {
    // Rows are counted as before.
    if mistake.leaves_out() {
        return None;
    }
    let mended = files.with(&mistake.edits);
    let measured = mended.read().ok()?.measured;
    let fitted = measured.fit_alone().ok()?;
    let far = far_apart(&fitted)?;
    // What is fitted must be rows of a table: all, or those that it says.
    let n = fitted.observations.len();
    let some = measured.rows().filter(|rows| rows.len() == n);
    let last = some.iter().flatten().max().copied();
    let has_them = |of: &&Readings| {
        let table = mended.folder.table(of.file, &[]).map(|table| table.n_rows());
        table.is_ok_and(|n_rows| n_rows == n || last.is_some_and(|last| last < n_rows))
    };
    let of = mended.kind.readings.iter().filter(|of| mended.folder.has(of.file)).find(has_them)?;
    let all = mended.folder.table(of.file, &[]).ok()?.n_rows() == n;
    let row = |observation: usize| match &some {
        Some(rows) if !all => rows[observation],
        _ => observation,
    };
    let far: Vec<usize> = far.into_iter().map(row).collect();
    of.without(&files.folder, &far)
}

/// What remains of two changes where the first is needed again after the other: what is exchanged twice stands as it
/// stood, if the other is enough; what makes numbers small is needed again and again, and mends nothing.
fn without_what_is_undone(
    case: &Case,
    mut named: Vec<Hypothesis>,
    again: usize,
    before: &Misfit,
) -> Result<Examined, Error> {
    named.remove(again);
    let left = misfit_with(&case.files, &edits_of(&named)).filter(Misfit::is_sound);
    let Some((named, left)) = named.pop().filter(|_| named.is_empty()).zip(left) else {
        return Ok(Examined::unmatched(&case.files, before));
    };
    let corrected = Some(case.with(&named.edits)?);
    let found = Found { named, after: Some(left), rivals: Vec::new(), is_subtle: false };
    Ok(Examined { suspects: vec![Suspect::of(&found, Some(before))], corrected, closed: None })
}

fn edits_of(named: &[Hypothesis]) -> Vec<Edit> {
    named.iter().flat_map(|hypothesis| hypothesis.edits.iter().cloned()).collect()
}

/// Rounding that explains what is left, where no names of physics take most of it.
fn rounded_beside(case: &Case, plain: &Plain, physics: &mut Option<Physics>) -> Option<Found> {
    let found = rounded(&case.files, plain, &*case.measured)?;
    let physics = physics.get_or_insert_with(|| Physics::of(case));
    (!physics.names_most()).then_some(found)
}

/// A declared noise that is no noise of these data: what physics leaves is small beside what was measured, goes with
/// nothing, and is a hundred times as large.
fn noise_too_small(case: &Case, plain: &Plain, physics: &mut Option<Physics>) -> Option<Found> {
    if !plain.is_small_beside_far_less_noise() {
        return None;
    }
    let physics = physics.get_or_insert_with(|| Physics::of(case));
    let chi2 = physics.only_scatters().filter(|chi2| *chi2 >= FAR_LESS_NOISE)?;
    let named = noise_in_another_unit(&case.files, chi2.sqrt())?;
    Some(Found { named, after: None, rivals: Vec::new(), is_subtle: false })
}

/// Those of the list that are looked at where no other explains the case.
pub(super) fn of_last_resort(list: &[Hypothesis]) -> Vec<Hypothesis> {
    list.iter().filter(|hypothesis| hypothesis.proof == Proof::FitIfNoOther).cloned().collect()
}

/// Whether rows that are places are left out.
fn is_of_a_place(files: &Files, found: &Found) -> bool {
    let mut places = files.kind.readings.iter().filter(|of| of.are_places);
    places.any(|of| found.named.edits.iter().any(|edit| edit.file == of.file))
}

/// Tables whose numbers have nothing to do with each other, whatever the reason.
pub(super) fn unmatched(files: &Files, misfit: &Misfit) -> Found {
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
