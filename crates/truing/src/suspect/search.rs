//! Every hypothesis of a kind refitted, and the one that the data bear out.

use rayon::prelude::*;

use super::declared::NOISES_MM;
use super::hypothesis::{Hypothesis, Proof};
use super::misfit::{Misfit, TIE};
use super::setting::scaled_setting;
use super::thinned::Thinned;
use super::yardstick::Yardstick;
use crate::case::Edit;
use crate::kind::Files;

/// Refits at most: the longest list of a kind is half as long.
const MOST_TRIALS: usize = 1000;
/// A gross mistake that is mended takes this factor off the misfit; half of it would still leave
/// room for a second mistake to be half mended.
const GROSS_GAIN: f64 = 5.0;
/// A misfit that any physics may cause must fall by this factor, and to the noise.
const SUBTLE_GAIN: f64 = 1.3;
/// The same where the noise is not known.
const BLIND_GAIN: f64 = 3.0;
/// Logarithm of the likelihood ratio that a subtle mistake must reach: odds of 1 to 10¹³, for
/// lists of hundreds of hypotheses over thousands of cases.
const EVIDENCE: f64 = 30.0;
/// χ² per degree of freedom from which on a mistake in some rows is looked for, five times the noise; and ten times,
/// from which on any mistake is, however small the misfit is beside what was measured, and rows from somewhere to the
/// end, or to there, may be of another session.
const FAR_FROM_NOISE: f64 = 25.0;
const OF_ANOTHER_SESSION: f64 = 100.0;
/// Degrees of freedom from which χ² at the declared noise is no accident of a change to the input.
const MANY: usize = 15;
/// Standard deviations by which readings that are all equal at the end of a range fit worse than the
/// others, where the whole is within the noise: that they clip needs no fit to be seen, only that it
/// matters.
const WORSE: f64 = 2.0;
/// A change must leave one in so many degrees of freedom: a stretch that the fit has not chosen may be
/// larger than rows that it has.
const LEAST_LEFT: usize = 2;
const LEAST_OF_A_STRETCH: usize = 4;
/// The same where rows are left out for how they misfit: a row too many shifts all that come after it.
const LEAST_BESIDE_ROWS: usize = 6;
/// χ² per degree of freedom below which the declared noise is a hundred times what is left: then it is
/// in another unit, or the readings are.
const NO_NOISE: f64 = 1e-4;
/// χ² per degree of freedom from which on the declared noise is in another unit, where what is left goes with nothing: a
/// hundred times.
pub(super) const FAR_LESS_NOISE: f64 = 1e4;

/// A hypothesis with the misfit that it leaves, where it can be fitted.
type Tried = (Hypothesis, Option<Misfit>);

/// What is known of the case as it stands.
pub(super) struct Plain {
    pub(super) misfit: Misfit,
    pub(super) yardstick: Yardstick,
}

/// A mistake that the data bear out.
pub(super) struct Found {
    pub(super) named: Hypothesis,
    pub(super) after: Option<Misfit>,
    /// Other mistakes that would explain the data as well.
    pub(super) rivals: Vec<Hypothesis>,
    /// Whether physics may still explain as much.
    pub(super) is_subtle: bool,
}

impl Found {
    pub(super) fn is_to_noise(&self) -> bool {
        self.after.is_some_and(|after| after.is_noise())
    }

    /// The same with what it leaves of all samples, in the words of the files.
    pub(super) fn of_all(self, files: &Files) -> Self {
        let after = trial(files, &self.named, None);
        let rivals =
            self.rivals.into_iter().map(|rival| rival.in_words_of(&files.folder)).collect();
        Self { named: self.named.in_words_of(&files.folder), after, rivals, ..self }
    }

    /// One without a change that mends it.
    pub(super) fn unmended(named: Hypothesis) -> Self {
        let named = Hypothesis { edits: Vec::new(), ..named };
        Self { named, after: None, rivals: Vec::new(), is_subtle: false }
    }
}

impl Plain {
    /// Whether the misfit is more than any physics of usual size makes.
    pub(super) fn is_gross(&self) -> bool {
        self.misfit.share >= self.yardstick.gross
    }

    /// Whether the misfit is as many times the noise as hardly any physics makes.
    pub(super) fn is_far_from_noise(&self) -> bool {
        self.misfit.chi2_per_dof.is_some_and(|chi2| chi2 >= FAR_FROM_NOISE)
    }

    /// Whether it is as many times the noise as readings of another session make.
    pub(super) fn may_be_of_another_session(&self) -> bool {
        self.misfit.chi2_per_dof.is_some_and(|chi2| chi2 >= OF_ANOTHER_SESSION)
    }

    /// Whether the rows that are left fit so much better than all that the others are of another session: what scatters
    /// beyond the declared noise by itself is measured by itself.
    pub(super) fn is_of_another_session(&self, left: &Misfit) -> bool {
        self.is_sound(left) && self.misfit.gain(left).powi(2) >= OF_ANOTHER_SESSION
    }

    /// Whether a change to some rows leaves what a sound case would.
    pub(super) fn is_sound(&self, after: &Misfit) -> bool {
        let is_left = LEAST_BESIDE_ROWS * after.dof >= self.misfit.dof;
        let gain = self.misfit.gain(after);
        // The seats of presses scatter beyond the noise of their records, which alone is declared.
        let is_next_to_nothing =
            self.is_gross() && gain >= GROSS_GAIN.powi(2) && after.is_next_to_nothing();
        is_left && (gain >= GROSS_GAIN && after.is_only_noise() || is_next_to_nothing)
    }

    /// Whether there is any misfit to explain.
    pub(super) fn is_suspicious(&self) -> bool {
        let Misfit { share, chi2_per_dof, dof, .. } = self.misfit;
        // Six standard deviations of χ² per degree of freedom, beside a tenth of model.
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let noise = 1.1 + 6.0 * (2.0 / dof.max(1) as f64).sqrt();
        share > QUIET * self.yardstick.gross && chi2_per_dof.is_none_or(|chi2| chi2 > noise)
            || share > self.yardstick.gross
            || self.may_be_of_another_session()
    }

    /// Whether it is far above the noise that was declared, and hardly anything beside what was measured.
    pub(super) fn is_small_beside_far_less_noise(&self) -> bool {
        let is_far = self.misfit.chi2_per_dof.is_some_and(|chi2| chi2 >= FAR_LESS_NOISE);
        is_far && self.misfit.is_next_to_nothing()
    }

    /// Whether hardly anything is left of the noise that was declared.
    pub(super) fn is_too_good(&self) -> bool {
        let Misfit { chi2_per_dof, dof, .. } = self.misfit;
        dof >= MANY && chi2_per_dof.is_some_and(|chi2| chi2 > 0.0 && chi2 < NO_NOISE)
    }
}

/// Every hypothesis of a case, refitted.
pub(super) struct Trials {
    all: Vec<Tried>,
    /// Degrees of freedom of the case as it stands, of the samples that were tried; `None` of all.
    dof: Option<usize>,
}

impl Trials {
    /// Of a long record on some of its samples: what is named is to be tried on all of them.
    pub(super) fn of(files: &Files, mut list: Vec<Hypothesis>, plain: Option<&Plain>) -> Self {
        let is_gross = plain.is_some_and(Plain::is_gross);
        list.retain(|hypothesis| match hypothesis.proof {
            Proof::FitIfGross => is_gross,
            Proof::FitIfNoOther => false,
            _ => true,
        });
        let thinned = Thinned::of(files, plain.map(|plain| &plain.misfit));
        Self::of_those(files, list, thinned.as_ref())
    }

    /// Only of what has that proof.
    pub(super) fn proved(files: &Files, list: &[Hypothesis], proof: Proof) -> Self {
        let those = list.iter().filter(|h| h.proof == proof).cloned();
        Self::of_those(files, those.collect(), None)
    }

    /// Only of units, with that of the declared noise.
    pub(super) fn of_units(files: &Files, mut list: Vec<Hypothesis>) -> Self {
        list.retain(|hypothesis| hypothesis.effect == "input:unit");
        let of_noise = NOISES_MM.into_iter().filter_map(|key| {
            let what = "in another unit, µm instead of mm, as what is left is a thousandth of it";
            scaled_setting(&files.document, &["noise", key], "input:unit", what, 1e-3)
        });
        Self::of_those(files, of_noise.chain(list).collect(), None)
    }

    pub(super) fn of_those(
        files: &Files,
        mut list: Vec<Hypothesis>,
        thinned: Option<&Thinned>,
    ) -> Self {
        list.truncate(MOST_TRIALS);
        let tried: Vec<Option<Misfit>> =
            list.par_iter().map(|hypothesis| trial(files, hypothesis, thinned)).collect();
        let dof = thinned.and_then(|thinned| thinned.dof);
        Self { all: list.into_iter().zip(tried).collect(), dof }
    }

    /// The mistake with which a case that cannot be fitted is sound, if there is one.
    ///
    /// Where something is left free, it must be with the declared noise, on many readings.
    pub(super) fn mending(&self, is_free: bool) -> Option<Found> {
        let sound = |m: &Misfit| {
            if is_free { m.is_noise() && m.dof >= MANY } else { m.is_sound() }
        };
        // Rows in another order leave as much free as they do in theirs.
        let may_be = |h: &Hypothesis| !(is_free && h.effect == "input:row-shift");
        let is_possible = |(h, m): &&Tried| {
            !is_free && h.is_shown(true) || may_be(h) && m.as_ref().is_some_and(sound)
        };
        let found = best(self.all.iter().filter(is_possible).cloned().collect(), false);
        let is_it = |(h, _): &&Tried| !is_free && h.is_shown(true) && h.edits.is_empty();
        let shown = self.all.iter().find(is_it).map(|(h, _)| Found::unmended(h.clone()));
        // What brings the fit to the noise goes before what the data show and nothing mends.
        shown.filter(|_| !found.as_ref().is_some_and(Found::is_to_noise)).or(found)
    }

    /// The mistake with which the case is as it should be, if there is one.
    pub(super) fn restoring(&self, is_sound: impl Fn(&Misfit) -> bool) -> Option<Found> {
        best(self.pick(|_, m| is_sound(m)), false)
    }

    /// The same that leaves the most readings, if one restores the case.
    pub(super) fn leaving_most(&self, is_sound: impl Fn(&Misfit) -> bool) -> Option<Found> {
        let all = self.pick(|_, m| is_sound(m)).into_iter();
        let dof = |tried: &Tried| tried.1.map_or(0, |m| m.dof);
        // The first of those that leave as many.
        let (named, after) = all.rev().max_by_key(dof)?;
        Some(Found { named, after, rivals: Vec::new(), is_subtle: false })
    }

    /// The mistake that explains the whole misfit, if one does.
    pub(super) fn explaining(&self, plain: &Plain) -> Option<Found> {
        let is_gross = plain.is_gross();
        let gain = |m: &Misfit| plain.misfit.gain(m);
        // Few rows fit anything.
        let dof = self.dof.unwrap_or(plain.misfit.dof);
        let is_left = |h: &Hypothesis, m: &Misfit| {
            let least = if h.is_of_a_stretch() { LEAST_OF_A_STRETCH } else { LEAST_LEFT };
            h.is_shown(is_gross) || m.dof >= dof.div_ceil(least)
        };
        let gross = |h: &Hypothesis, m: &Misfit| {
            is_left(h, m)
                && gain(m) >= GROSS_GAIN
                && m.is_nearer_to_noise(&plain.misfit)
                && !m.is_too_good()
        };
        // A channel without a signal fits nothing, and numbers made small fit it best.
        let silent = self.all.iter().find(|(h, _)| h.is_silent() && h.is_shown(is_gross));
        let is_sound = |found: &Found| {
            silent.is_none()
                || found.after.is_some_and(|m| m.chi2_per_dof.is_none() || m.is_noise())
        };
        if is_gross && let Some(found) = best(self.pick(gross), false).filter(is_sound) {
            return Some(found);
        }
        let shown = self.pick(|h, m| h.is_shown(is_gross) && gain(m) >= SUBTLE_GAIN);
        if let Some(found) = best(shown, false) {
            return Some(found);
        }
        let subtle = |h: &Hypothesis, m: &Misfit| {
            let least = if m.chi2_per_dof.is_some() { SUBTLE_GAIN } else { BLIND_GAIN };
            // What is free without a table takes up physics as well as noise, which must be declared then.
            let to_noise = m.is_noise() || m.chi2_per_dof.is_none() && !h.omits_a_file();
            is_left(h, m) && to_noise && gain(m) >= least && is_evident(m.dof, gain(m))
        };
        let subtle = best(self.pick(subtle), true);
        let shown = self.all.iter().find(|(h, _)| h.is_shown(is_gross));
        // What brings the fit to the noise goes before what the data show and nothing mends.
        match shown.filter(|_| subtle.as_ref().is_none_or(|s| !s.is_to_noise())) {
            Some((shown, _)) => Some(Found::unmended(shown.clone())),
            None => subtle,
        }
    }

    /// The mistake whose readings fit worse than the others of a case that fits.
    pub(super) fn missing(&self, plain: &Plain) -> Option<Found> {
        let is_worse = |_: &Hypothesis, without: &Misfit| {
            plain.misfit.by_what_is_left_out(without).is_some_and(|sigmas| sigmas >= WORSE)
        };
        best(self.pick(is_worse), false)
    }

    /// The first mistake with whose change the case can be fitted, or that nothing mends.
    pub(super) fn first(self) -> Option<Found> {
        let is_it = |(named, misfit): &Tried| misfit.is_some() || named.edits.is_empty();
        let (named, after) = self.all.into_iter().find(is_it)?;
        Some(Found { named, after, rivals: Vec::new(), is_subtle: false })
    }

    /// The mistake that brings a case up to its declared noise.
    pub(super) fn to_noise(&self) -> Option<Found> {
        best(self.pick(|_, m| m.is_noise()), false)
    }

    /// The mistakes that take at least this factor off the misfit and leave something to physics, but no
    /// more than it makes, the best first.
    pub(super) fn helping(&self, plain: &Plain, least: f64, most: usize) -> Vec<Found> {
        let gain = |m: &Misfit| plain.misfit.gain(m);
        let is_of_physics = |m: &Misfit| !m.is_noise() && m.share < m.gross;
        let may_be = |h: &Hypothesis| plain.misfit.chi2_per_dof.is_some() || !h.omits_a_file();
        let helps = |h: &Hypothesis, m: &Misfit| {
            let least = if h.is_unphysical() { LITTLE } else { least };
            gain(m) >= least && is_evident(m.dof, gain(m))
        };
        let mut all = self.pick(|h, m| is_of_physics(m) && may_be(h) && helps(h, m));
        let share = |tried: &Tried| tried.1.map_or(f64::INFINITY, |m| m.share);
        all.sort_by(|a, b| share(a).total_cmp(&share(b)));
        all.truncate(most);
        let of = |(named, after)| Found { named, after, rivals: Vec::new(), is_subtle: true };
        all.into_iter().map(of).collect()
    }

    /// Changes with which the case can be fitted, those first that leave the least of what was measured.
    pub(super) fn nearest(&self, most: usize) -> impl Iterator<Item = &Hypothesis> {
        let share = |(_, m): &&Tried| m.as_ref().map_or(f64::INFINITY, |m| m.share);
        let mut all: Vec<&Tried> = self.all.iter().filter(|(_, m)| m.is_some()).collect();
        all.sort_by(|a, b| share(a).total_cmp(&share(b)));
        all.into_iter().take(most).map(|(h, _)| h)
    }

    /// Mistakes in the order of the list.
    pub(super) fn in_their_order(&self, those: &[Found]) -> Vec<Hypothesis> {
        let is_one = |h: &Hypothesis| those.iter().any(|found| found.named.is(h));
        self.all.iter().map(|(h, _)| h).filter(|h| is_one(h)).cloned().collect()
    }

    fn pick(&self, keep: impl Fn(&Hypothesis, &Misfit) -> bool) -> Vec<Tried> {
        let kept = self.all.iter().filter(|(h, m)| m.as_ref().is_some_and(|m| keep(h, m)));
        kept.cloned().collect()
    }
}

/// Whether a misfit so many times less is evidence enough.
pub(super) fn is_evident(dof: usize, gain: f64) -> bool {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let log_likelihood = dof as f64 * gain.ln();
    log_likelihood >= EVIDENCE
}

/// Factor that a mistake which no physics makes takes off the misfit at least.
const LITTLE: f64 = 1.1;

/// Share of a gross misfit below which it is not looked at.
const QUIET: f64 = 0.01;

/// The fit of the case with the change; `None` where it cannot be had.
fn trial(files: &Files, hypothesis: &Hypothesis, thinned: Option<&Thinned>) -> Option<Misfit> {
    if hypothesis.edits.is_empty() {
        return None;
    }
    let of_some = thinned.map(|thinned| thinned.edits(&hypothesis.edits));
    misfit_with(files, of_some.as_ref().unwrap_or(&hypothesis.edits))
}

/// The misfit of the case with some changes; `None` where it cannot be fitted.
pub(super) fn misfit_with(files: &Files, edits: &[Edit]) -> Option<Misfit> {
    let reading = files.with(edits).read().ok()?;
    let fitted = reading.measured.fit_alone().ok()?;
    let (misfit, _) = Misfit::of(&*reading.measured, &fitted);
    misfit.share.is_finite().then_some(misfit)
}

/// The first of those that fit best; what fits the declared noise goes before what does not, and what makes numbers
/// larger before what makes those beside them smaller: these fit in any unit in which they are small.
fn best(mut all: Vec<Tried>, is_subtle: bool) -> Option<Found> {
    let share = |m: &Option<Misfit>| m.map_or(f64::INFINITY, |m| m.share);
    let is_noise = |m: &Option<Misfit>| m.is_some_and(|m| m.is_noise());
    if all.iter().any(|(_, m)| is_noise(m)) {
        all.retain(|(_, m)| is_noise(m));
    }
    let larger: Vec<Tried> = all.iter().filter(|(h, _)| h.enlarges()).cloned().collect();
    let is_reverse = |(h, m): &Tried| {
        let fits_less = |of: &Option<Misfit>| share(of) > TIE * share(m);
        larger.iter().any(|(other, of)| h.is_reverse_of(other) && fits_less(of))
    };
    all.retain(|tried| !is_reverse(tried));
    let least = all.iter().map(|(_, m)| share(m)).fold(f64::INFINITY, f64::min);
    // Of two readings of opposite signs either may be the wrong one, whatever the spread is then.
    let rms = |m: &Option<Misfit>| m.map_or(f64::INFINITY, |m| m.rms);
    let is_best = |m: &Option<Misfit>| share(m) <= TIE * least;
    let signs = all.iter().filter(|(h, m)| h.is_of_signs() && is_best(m));
    let most_of_signs = signs.map(|(_, m)| rms(m)).fold(0.0, f64::max);
    all.retain(|(h, m)| is_best(m) || h.is_of_signs() && rms(m) <= TIE * most_of_signs);
    // Of those that leave readings out, the one with the fewest.
    let kept = |(h, m): &Tried| m.filter(|_| h.only_leaves_out()).map(|m| m.dof);
    if all.first().and_then(kept).is_some() {
        let most = (0..all.len()).rev().max_by_key(|&i| kept(&all[i]));
        all[..=most?].rotate_right(1);
    }
    let mut all = all.into_iter();
    let (named, after) = all.next()?;
    let rivals = all.map(|(rival, _)| rival).collect();
    Some(Found { named, after, rivals, is_subtle })
}
