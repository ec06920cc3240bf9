use super::yardstick::Yardstick;
use crate::measured::{Fitted, Measured};
use crate::residual::Residual;

/// χ² per degree of freedom that still is the declared noise, with physics of its size beside it.
const NOISE: f64 = 2.5;
/// Below this a fit is better than the declared noise allows: the data were shrunk.
const TOO_GOOD: f64 = 0.2;
/// Degrees of freedom from which on that is no chance.
const ENOUGH: usize = 15;
/// Share of χ² that a change leaves at most, whose misfit is a smaller share of what was measured.
const NEARER: f64 = 0.5;
/// Share of a misfit that is all of it.
const TAKEN_UP: f64 = 0.9;
/// Share of a gross misfit below which a case is taken for sound, whatever noise was declared.
const SOUND: f64 = 0.1;
/// Components of a residual in one unit: what follows them, as moments do forces, is in another.
const COMPONENTS: usize = 3;
/// χ² of readings over that of others from which on they fit worse, and standard deviations that are no accident, of noise
/// that is correlated, too.
const WORSE_CHI2: f64 = 4.0;
const NO_ACCIDENT: f64 = 10.0;
/// Misfits as close as this are the same.
pub(super) const TIE: f64 = 1.25;

/// How far a case is from what it should be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Misfit {
    /// Residual, with what free parameters took up.
    pub(super) rms: f64,
    /// Of that what free parameters took up.
    taken_up: f64,
    /// Share of what was measured.
    pub(super) share: f64,
    /// Share beyond which no physics of usual size explains it.
    pub(super) gross: f64,
    pub(super) chi2_per_dof: Option<f64>,
    pub(super) dof: usize,
    pub(super) unit: &'static str,
}

impl Misfit {
    pub(super) fn of(measured: &dyn Measured, fitted: &Fitted) -> (Self, Yardstick) {
        let yardstick = measured.yardstick(fitted);
        let rms = Residual::of(fitted.observations.iter(), COMPONENTS, fitted.unit).rms;
        let rms = rms.unwrap_or(f64::NAN).hypot(yardstick.taken_up);
        let misfit = Self {
            rms,
            taken_up: yardstick.taken_up,
            share: rms / yardstick.spread,
            gross: yardstick.gross,
            chi2_per_dof: fitted.chi2_per_dof,
            dof: fitted.degrees_of_freedom,
            unit: fitted.unit,
        };
        (misfit, yardstick)
    }

    /// How many times less another misfit is, by itself and beside what was measured: numbers made large make any misfit
    /// a small share of them.
    pub(super) fn gain(&self, after: &Self) -> f64 {
        (self.share / after.share).min(self.rms / after.rms)
    }

    /// Whether no more is left than of noise, or clearly less than before: a column a thousand times as large makes
    /// any misfit a small share of what was measured, one that the misfit does not go with as well. What free
    /// parameters took up was never in χ².
    pub(super) fn is_nearer_to_noise(&self, before: &Self) -> bool {
        let both = self.chi2_per_dof.zip(before.chi2_per_dof);
        let is_taken_up = before.taken_up >= TAKEN_UP * before.rms;
        self.is_noise()
            || is_taken_up
            || both.is_none_or(|(after, before)| after <= NEARER * before)
    }

    /// What the change takes off the misfit, in standard uncertainties of one amplitude.
    pub(super) fn significance(&self, after: &Self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let dof = after.dof as f64;
        let fall = match (self.chi2_per_dof, after.chi2_per_dof) {
            (Some(before), Some(after)) => before - after,
            _ => self.gain(after).powi(2) - 1.0,
        };
        (dof * fall.max(0.0)).sqrt()
    }

    /// How much worse the readings fit that another fit is without, in standard deviations of noise
    /// as that fit has it; `None` where no noise is declared.
    pub(super) fn by_what_is_left_out(&self, without: &Self) -> Option<f64> {
        let (square, [out, kept]) = self.left_out(without)?;
        (out > 0.0 && kept > 0.0).then(|| (square - out) / (2.0 * out * (1.0 + out / kept)).sqrt())
    }

    /// Whether the readings that another fit is without fit clearly worse than the others: twice as far off, and by no
    /// accident.
    pub(super) fn is_worse_of_some(&self, without: &Self) -> bool {
        let is_far =
            self.left_out(without).is_some_and(|(square, [out, _])| square > WORSE_CHI2 * out);
        is_far && self.by_what_is_left_out(without).is_some_and(|sigmas| sigmas > NO_ACCIDENT)
    }

    /// χ² of the readings that another fit is without, in units of the noise of the others, and how many they and the
    /// others are.
    fn left_out(&self, without: &Self) -> Option<(f64, [f64; 2])> {
        let (all, noise) = self.chi2_per_dof.zip(without.chi2_per_dof)?;
        #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
        let [dof, kept] = [self.dof as f64, without.dof as f64];
        Some(((all * dof - noise * kept) / noise, [dof - kept, kept]))
    }

    /// Whether it is the noise, or next to nothing.
    pub(super) fn is_sound(&self) -> bool {
        self.is_noise() || self.is_next_to_nothing()
    }

    /// Whether it is a small part of what would be gross.
    pub(super) fn is_next_to_nothing(&self) -> bool {
        self.share < SOUND * self.gross
    }

    /// Whether it is the declared noise, of rows that only check the fit too, or next to nothing where none was
    /// declared.
    pub(super) fn is_only_noise(&self) -> bool {
        self.is_noise() && self.share < self.gross || self.chi2_per_dof.is_none() && self.is_sound()
    }

    /// Whether no case has it once its mistake is mended: gross still, or of numbers made too small to miss
    /// anything.
    pub(super) fn is_of_none(&self) -> bool {
        self.chi2_per_dof.is_some() && self.share >= self.gross || self.is_too_good()
    }

    /// Whether less is left than the declared noise leaves: numbers were made small.
    pub(super) fn is_too_good(&self) -> bool {
        self.dof >= ENOUGH && self.chi2_per_dof.is_some_and(|chi2| chi2 < TOO_GOOD)
    }

    /// χ² per degree of freedom that is left above the declared noise, where that is clearly more.
    pub(super) fn above_noise(&self) -> Option<f64> {
        self.chi2_per_dof.filter(|chi2| *chi2 > NOISE).map(|chi2| chi2 - 1.0)
    }

    /// The same of the residual, in its unit.
    pub(super) fn above_noise_rms(&self) -> Option<f64> {
        let chi2 = self.chi2_per_dof?;
        Some(self.rms * (self.above_noise()? / chi2).sqrt())
    }

    pub(super) fn is_noise(&self) -> bool {
        self.chi2_per_dof.is_some_and(|chi2| (TOO_GOOD..NOISE).contains(&chi2))
    }
}
