//! Every level at which something is decided, and what they spend.
//!
//! The budget is `Options::alpha`, 0.05: the probability of adding anything at all where nothing is
//! missing. Half goes to single effects, a quarter to pairs of effects, a quarter to shapes along
//! covariates; Holm shares each out over what is tried. Passes after something was added work at
//! two fifths of it: `0.4 α` for each, as long as there are such. What is left of the residual is
//! looked at beside this budget: neighbours in order and in place at 0.005 each, groups set aside at
//! 0.005, additivity at 0.01 over all names and covariates; lack of fit, a group that is unlike the
//! others, groups that lie apart, χ² beside the declared noise, parameters that change while they are measured, and two
//! single readings that hide each other at 0.001 each.
//! Where nothing is missing, one answer in fourteen at most, 0.05 + 3 · 0.005 + 6 · 0.001 = 0.071, says otherwise; additivity asks only once
//! something was named.

use std::ops::RangeInclusive;

// Shares of alpha.

/// Share of `alpha` for the catalogue; pairs and covariates get a quarter each.
pub(crate) const CATALOGUE_SHARE: f64 = 0.5;

/// Share of `alpha` for pairs of effects, and for covariates.
pub(crate) const QUARTER: f64 = 0.25;

/// Share of `alpha` for passes after something was added: what is found beside a name counts
/// against the whole answer, and there may be several such passes.
pub(crate) const LATER: f64 = 0.4;

// Levels of single questions.

/// Significance that an effect must keep once others are beside it.
pub(crate) const STAY: f64 = 0.05;

/// Significance below which the accepted effect is needed beside a rival, whatever the error on
/// unseen groups says: the true name is refused once in a hundred times.
pub(crate) const DECIDED: f64 = 0.01;

/// Significance from which on a named effect is not what its name says.
pub(crate) const NOT_ADDITIVE: f64 = 0.01;

/// The same for data that scatter more than declared, judged as though the noise had no memory; so
/// small that noise whose variance is a few times what memory leaves of it does not reach it.
pub(crate) const PLAINLY_NOT_ADDITIVE: f64 = 1e-6;

/// Share of the probability that a named effect is the same everywhere below which a single reading is to blame, and
/// not that effect.
pub(crate) const FAR_CLEARER: f64 = 1e-6;
/// Share of the misfit that names may leave and still stand although
/// they are not what they promise: a drift that is not quite even leaves some hundredths, and is a
/// drift.
pub(crate) const EXCESS_LEFT: f64 = 0.05;

/// The same where no noise was declared: what a departure takes is noise, too, and data from a
/// machine have some of everything.
pub(crate) const EXCESS_LEFT_UNDECLARED: f64 = 0.1;

/// χ² per degree of freedom from which on that share is enough, whatever is left: with structure, which is
/// not the noise, twice the declared standard deviation; without, where the noise may be larger than
/// declared, ten times.
pub(crate) const GROSS_STRUCTURE: f64 = 4.0;
pub(crate) const GROSS_SCATTER: f64 = 100.0;

/// The same beside one name that leaves a tenth of the misfit: six times.
pub(crate) const LARGE_SCATTER: f64 = 36.0;

/// Different effects that an answer may name at most: of four and more that a greedy choice took together in blind
/// cases none were the truth, as a smooth shape is a sum of a few smooth others.
pub(crate) const MOST_NAMES: usize = 3;

/// Names, of two effects or more, that must leave no more than the declared noise: what is left is of the same that they
/// are parts of.
pub(crate) const MANY_NAMES: usize = 3;

/// The share that is enough beside structure of that size, or of several names beside any: two that are the
/// whole leave none.
pub(crate) const STRUCTURE_LEFT: f64 = 0.02;

/// Share of that excess that names must leave, beside structure, to be taken back for it alone: what
/// has no name is then larger than what has.
pub(crate) const MOSTLY_LEFT: f64 = 0.5;

/// The same where what is left has no structure that shows: the noise may be larger than declared, and
/// a name that takes less than a third of what exceeds it is as likely a part of the rest.
pub(crate) const HARDLY_EXPLAINED: f64 = 2.0 / 3.0;

/// Significance from which on check groups are predicted too badly.
pub(crate) const BADLY_PREDICTED: f64 = 0.005;

/// Significance from which on neighbours agree too well.
pub(crate) const NEIGHBOURS_AGREE: f64 = 0.005;

/// The same where the data scatter more than declared, which is not to be called noise while they may do.
pub(crate) const ONLY_NOISE: f64 = 0.02;

/// Significance from which on parameters change while they are measured.
pub(crate) const CONSTANT: f64 = 1e-3;

/// χ² per degree of freedom from which on what is left is not called noise, whatever else it is not: fifteen times the
/// declared standard deviation.
pub(crate) const HARDLY_NOISE: f64 = 225.0;

/// The same from which on a name that is not beyond doubt may be a part of it: three times.
pub(crate) const SEVERAL_TIMES: f64 = 9.0;

/// Significance of χ² from which on declared uncertainties are widened by the scatter found.
pub(crate) const TOO_NOISY: f64 = 0.01;

/// Significance from which on repeats agree too well with each other to be noise.
pub(crate) const LACK_OF_FIT: f64 = 1e-3;

/// Chance from which on a single reading far off may be the tail of the noise, whose law is known
/// from the other readings and the declared uncertainty.
///
/// Of 1000 simulated mirrors, spheres and surveys with Student's t of three degrees of freedom, and of 400 sets of a tracer's ranges, one or two
/// in a hundred have a reading that is called a mistake; of mistakes of 10 σ along one axis of one of 18 points with normal noise nine in ten are.
pub(crate) const IN_TAILS: f64 = 0.004;

/// The same where no uncertainty is declared.
pub(crate) const IN_TAILS_UNDECLARED: f64 = 0.009;

/// The same of readings set aside, which no fit has followed, by those that were fitted.
pub(crate) const REACHED: f64 = 0.005;

/// The same where no uncertainty is declared.
pub(crate) const REACHED_UNDECLARED: f64 = 0.01;

/// Significance of the best of all pairs of single readings that hide each other.
pub(crate) const MASKED: f64 = 1e-3;

/// How many single readings there are where all pairs of them are tried. Among more, two do not hide each
/// other: each moves the fit by less than a twentieth of what it is off by.
pub(crate) const MASKED_AMONG: RangeInclusive<usize> = 2..=40;

/// Most classes of effects of which all pairs are tried.
pub(crate) const MAX_CLASSES: usize = 15;

/// Probability of the normal law from which on the noise has heavy tails.
pub(crate) const HEAVY_TAILS: f64 = 0.01;

/// Share of the repetitions without some groups that must find a name again for it to be added.
pub(crate) const FOUND_AGAIN: f64 = 0.5;

/// The same share from which on what is predicted where something else was found says nothing of a name:
/// in one repetition of ten chance may choose otherwise, and far from the rest it predicts anything.
pub(crate) const STEADY: f64 = 0.9;

/// Significance from which on one group differs from the others, all groups together.
pub(crate) const ODD_GROUP: f64 = 1e-3;

/// The same of a stretch of readings that scatters otherwise, all stretches together: of heavy tails some lie together.
pub(crate) const ODD_STRETCH: f64 = 1e-6;

/// Significance that must be left of a name once check groups that it predicts no better are heard: that which it
/// needed without them, as what is there shows in them as well.
pub(crate) const HEARD: f64 = 1e-3;

/// Significance that chance hardly has: a name that is less clear, that unseen groups speak against and without which all
/// is the declared noise was one.
pub(crate) const HARDLY_CHANCE: f64 = 1e-4;

/// Squared error on check groups over that without a name, from which on they refute it: what they are
/// off by from other causes turns it a little either way.
pub(crate) const REFUTED: f64 = 1.25;

/// Significance from which on a name stands whatever it predicts of groups left out, and whatever is left
/// beside it: one that is weaker may be a part of that.
pub(crate) const BEYOND_DOUBT: f64 = 1e-9;

/// Share of the misfit that is small whatever it is: names beside it explained all the others.
pub(crate) const HARDLY_LEFT: f64 = 0.01;

/// Significance from which on groups scatter by more along an effect than elsewhere: then it is judged by that.
pub(crate) const UNEVEN: f64 = 0.05;

/// Significance from which on groups differ from each other by more than their readings.
pub(crate) const GROUPS_APART: f64 = 1e-3;

/// Probability of χ² outside its interval where the noise is as declared.
pub(crate) const CHI2_OUTSIDE: f64 = 1e-3;

/// Probability of finding an effect of the minimal detectable size.
pub(crate) const POWER: f64 = 0.9;

// What counts as clear.

/// Standard errors by which groups must gain where others cannot be predicted any more.
pub(crate) const CLEAR_GAIN: f64 = 2.0;

/// Share of the level below which a p-value from the rows' own colour leaves no doubt that the
/// colour of the readings behind them could confirm: it widens an uncertainty by a third at most.
pub(crate) const CLEAR_BEYOND_DOUBT: f64 = 1e-3;

/// Difference of the Bayesian information criterion that the last recorded digit can make: a
/// residual of three standard deviations that moves by a hundredth of one changes twice the
/// log-likelihood by 0.06.
pub(crate) const TIE: f64 = 0.06;

/// Difference of the Bayesian information criterion that is worth mentioning (Raftery 1995).
pub(crate) const WORTH_MENTIONING: f64 = 2.0;

/// Share of what a wider empirical shape explains that an effect must account for to keep its
/// name: with less, the name leaves a visible part of the same structure unexplained.
pub(crate) const NAME_SHARE: f64 = 0.9;

/// Share of what the best candidate explains that one with fewer amplitudes must explain to be held
/// against it: half of a sum of squares that was significant at a level shared out over a catalogue is
/// significant at [`STAY`] alone.
pub(crate) const PLACE_SHARE: f64 = 0.5;

/// F statistic of what the best explains beyond it from which on it is not: with a single degree of
/// freedom 254 is significant at [`STAY`], whatever the directions.
pub(crate) const PLACE_F: f64 = 400.0;

/// Colours less likely than this, beside the likeliest, are left out.
pub(crate) const NEGLIGIBLE: f64 = 1e-4;

/// A proposal within this share of the best separation is as good, and the cheaper one is named.
pub(crate) const AS_GOOD: f64 = 0.7;

/// A measurement is worth proposing when it separates the rivals by this many times more.
pub(crate) const WORTHWHILE: f64 = 1.5;

// What a design must leave.

/// Share of a tangent's norm that must be left beside the model for the effect to be tested.
///
/// At 0.045 the model absorbs 99.8 % of the effect: it would have to be 22 times larger than
/// one that the design was made for, and small errors of the design pass for it.
pub(crate) const MIN_KEPT: f64 = 0.045;

/// The same for an effect to be heard as a rival of another: it need not be likely, only possible.
pub(crate) const MIN_KEPT_CONFOUNDED: f64 = 1e-3;

/// The same for an effect driven by a covariate: its mean may be absorbed, not its variation.
pub(crate) const MIN_KEPT_DRIVEN: f64 = 1e-4;

/// Share of the squared residual of which several effects at once never leave less: noise is no sum of
/// them. The tangents of two that would be one, but are taken at a reading and at where it should be,
/// differ by the residual itself, and leave round-off.
pub(crate) const LEFT_BY_ANY: f64 = 1e-12;

/// Share of a shape's norm that must be left beside the model.
pub(crate) const MIN_SHAPE_KEPT: f64 = 0.02;

// Groups.

/// Fewest groups that can be left out in turn with something to compare.
pub(crate) const MIN_GROUPS: usize = 3;

/// Fewest groups whose agreement has a scatter of its own.
pub(crate) const MIN_AGREEING: usize = 5;

/// Fewest groups for which the scatter between groups is itself well enough known: one fewer than those with which
/// the choice is repeated, so that repetitions are judged as all are.
pub(crate) const MIN_CLUSTERS: usize = MIN_NESTED_GROUPS - 1;

/// Fewest groups with which the choice of effects can be repeated without each of them.
pub(crate) const MIN_NESTED_GROUPS: usize = 8;

/// Fewest fitted groups that show how much their scatter differs.
pub(crate) const MIN_SCATTERING_GROUPS: usize = 8;

/// Check groups of which one lies off alone, more than: the others must tell that they do not.
pub(crate) const MIN_SCATTERING_CHECKS: f64 = 3.0;

/// Most groups left out one by one while candidates are compared.
pub(crate) const CHOICE_FOLDS: usize = 64;
