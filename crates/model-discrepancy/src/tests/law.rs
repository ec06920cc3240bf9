//! A law of the noise, seen in what a fit leaves of the readings.

use std::array::from_fn;
use std::collections::BTreeMap;
use std::sync::OnceLock;

use statrs::distribution::{ChiSquared, Continuous, ContinuousCDF, Normal, StudentsT};

use crate::count::count;

/// Degrees of freedom of Student's t that noise may have beside the normal law; beyond 20 the two
/// cannot be told apart by data that fit in a case.
/// Beside each twice what is one more: the fourth root of `1 + z²/ν` to that power is what the density
/// falls by.
pub(crate) const FREEDOMS: [(f64, i32); 7] =
    [(2.5, 7), (3.0, 8), (4.0, 10), (5.0, 12), (7.0, 16), (10.0, 22), (20.0, 42)];

/// Share of the other readings that are mistakes, where any are, which is as likely beforehand as that
/// none is: they lie anywhere. Without the one case a tail that is seen would pass for mistakes, without
/// the other two mistakes for a tail.
const MISTAKEN: f64 = 0.01;

/// What a fit leaves of a reading is looked up in twentieths of one.
const LEFTS: usize = 20;

/// Steps of the logarithm of a residual in a table of densities, and where the table ends: at 74 scales
/// the density of the one with most degrees of freedom falls as a power of the residual to within 1 %.
const STEPS: usize = 64;
const END: usize = 5 * STEPS;

/// Readings are alike within such a part of what a table tells apart near zero, where the root mean square is
/// the scale; and the farthest cell for them: no number is farther than e^750 times the smallest.
const FINER: f64 = 4.0;
const FARTHEST: usize = 1500 * STEPS;

/// Standard deviations of the normal law that are summed over, and the widest step: sums of a
/// function so smooth in such steps are integrals to 1e-9 of the density.
const SUMMED: f64 = 6.0;
const WIDEST: f64 = 0.5;

/// A residual of one reading over its own standard uncertainty, and what the fit leaves of the reading, of one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) z: f64,
    pub(crate) left: f64,
}

/// Readings that are as far off as each other and of which as much is left, within what a table tells apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alike {
    seen: Seen,
    n: f64,
}

/// Of thousands of readings some hundred sorts; of those of one, z is the root of the mean square.
pub(crate) fn alike(rows: &[Seen], rms: f64) -> Vec<Alike> {
    let mut sorts: BTreeMap<(usize, usize), (f64, f64)> = BTreeMap::new();
    for seen in rows {
        let cell = steps_of(FINER * seen.z / rms).round().min(count(FARTHEST));
        let (n, squares) = sorts.entry((twentieths(seen.left), whole(cell))).or_default();
        *n += 1.0;
        *squares += seen.z * seen.z;
    }
    let of_sort = |((twentieths, _), (n, squares)): ((usize, usize), (f64, f64))| {
        let left = count(twentieths) / count(LEFTS);
        Alike { seen: Seen { z: (squares / n).sqrt(), left }, n }
    };
    sorts.into_iter().map(of_sort).collect()
}

/// A law of the noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    /// Which of [`FREEDOMS`]; `None` for the normal law.
    of: Option<usize>,
    scale: f64,
}

impl Law {
    pub(crate) fn new(of: Option<usize>, scale: f64) -> Self {
        Self { of, scale }
    }

    /// Degrees of freedom of Student's t; `None` for the normal law.
    pub(crate) fn freedom(&self) -> Option<f64> {
        self.of.map(|of| FREEDOMS[of].0)
    }

    pub(crate) fn standard_deviation(&self) -> f64 {
        self.scale * self.freedom().map_or(1.0, deviation)
    }

    /// Probability that components together, root of their sum of squares, lie beyond `seen`; of a law with heavy tails it
    /// is one of them that does.
    pub(crate) fn outside(&self, seen: Seen, components: usize) -> f64 {
        let z = seen.z.abs() / self.scale;
        let n = count(components.max(1));
        match self.freedom() {
            Some(freedom) => {
                let t = StudentsT::new(0.0, 1.0, freedom);
                let beyond = |z: f64| t.as_ref().map_or(0.0, |t| t.sf(z));
                let one = 2.0 * mixed_with_normal(freedom, seen.left, z, beyond);
                1.0 - (1.0 - one).powf(n)
            }
            None => ChiSquared::new(n).map_or(0.0, |square| square.sf(z * z)),
        }
    }

    /// Logarithms of the likelihood of rows: none of them a mistake, and some, up to `end`.
    pub(crate) fn log_likelihoods(&self, rows: &[Alike], end: f64) -> [f64; 2] {
        let anywhere = MISTAKEN / (2.0 * end);
        let (mut none, mut some) = (0.0, 0.0);
        for Alike { seen, n } in rows {
            let log_density = self.log_density(*seen);
            none += n * log_density;
            some += n * ((1.0 - MISTAKEN) * log_density.exp() + anywhere).ln();
        }
        [none, some]
    }

    fn log_density(&self, seen: Seen) -> f64 {
        let z = seen.z / self.scale;
        let of_unit_scale = match self.of {
            Some(of) => table(of, seen.left).log_density(z),
            None => Normal::standard().ln_pdf(z),
        };
        of_unit_scale - self.scale.ln()
    }
}

/// Standard deviation of Student's t of unit scale.
fn deviation(freedom: f64) -> f64 {
    (freedom / (freedom - 2.0)).sqrt()
}

/// Mean of `of` at the reading's own part of a residual `z`, the rest of which is that of the readings that were
/// fitted with it: many together, so normal, of the law's standard deviation.
///
/// `z = √left·e + √(1 − left)·σ·g`, which has the standard deviation σ of one reading `e`.
fn mixed_with_normal(freedom: f64, left: f64, z: f64, of: impl Fn(f64) -> f64) -> f64 {
    let (own, others) = (left.sqrt(), (1.0 - left).max(0.0).sqrt() * deviation(freedom));
    if others <= f64::EPSILON {
        return of(z);
    }
    let step = WIDEST.min(own / others);
    let normal = Normal::standard();
    let at = |k: f64| normal.pdf(k * step) * of((z - others * k * step) / own);
    let mut sum = at(0.0);
    let mut k = 1.0;
    while k * step < SUMMED {
        sum += at(k) + at(-k);
        k += 1.0;
    }
    sum * step
}

/// Logarithms of the density of residuals of readings of unit scale, at equal steps of their inverse
/// hyperbolic sine.
struct Table {
    log_densities: Vec<f64>,
    freedom: f64,
}

impl Table {
    fn new((freedom, quarters): (f64, i32), left: f64) -> Self {
        let peak = StudentsT::new(0.0, 1.0, freedom).map_or(0.0, |t| t.pdf(0.0));
        let density = |z: f64| {
            let fall = 1.0 + z * z / freedom;
            peak * fall.sqrt().sqrt().powi(-quarters)
        };
        let at = |i: usize| (count(i) / count(STEPS)).sinh();
        let own = left.sqrt();
        let of_residual = |z| (mixed_with_normal(freedom, left, z, density) / own).ln();
        Self { log_densities: (0..=END).map(|i| of_residual(at(i))).collect(), freedom }
    }

    fn log_density(&self, z: f64) -> f64 {
        let steps = steps_of(z);
        let before = whole(steps.min(count(END)));
        if before == END {
            let further = (steps - count(END)) / count(STEPS);
            return self.log_densities[END] - (self.freedom + 1.0) * further;
        }
        let (first, second) = (self.log_densities[before], self.log_densities[before + 1]);
        first + (second - first) * (steps - count(before))
    }
}

/// Where a residual lies in a table.
fn steps_of(z: f64) -> f64 {
    z.abs().asinh() * count(STEPS)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "neither negative nor large"
)]
fn whole(steps: f64) -> usize {
    steps as usize
}

/// What is left of a reading, at least one twentieth.
fn twentieths(left: f64) -> usize {
    whole((left * count(LEFTS)).round().clamp(1.0, count(LEFTS)))
}

/// The table of one law for readings of which about so much is left.
fn table(of: usize, left: f64) -> &'static Table {
    static TABLES: OnceLock<[[OnceLock<Table>; LEFTS]; FREEDOMS.len()]> = OnceLock::new();
    let tables = TABLES.get_or_init(|| from_fn(|_| from_fn(|_| OnceLock::new())));
    let twentieths = twentieths(left);
    tables[of][twentieths - 1]
        .get_or_init(|| Table::new(FREEDOMS[of], count(twentieths) / count(LEFTS)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tables of all laws, for readings that no fit has touched, row by row, and each density by
    /// its library: straight lines between 64 points of each e-fold are within (1/64)²/8 of the
    /// logarithm's second derivative, which is 40 at most for 20 degrees of freedom.
    #[test]
    fn likelihoods_are_products_of_densities() {
        const CHORD: f64 = 40.0 / (64.0 * 64.0 * 8.0);
        let rows: Vec<f64> = (0..45).map(|i| 0.3 * f64::from(i) - 6.0).collect();
        let seen: Vec<Seen> = rows.iter().map(|z| Seen { z: *z, left: 1.0 }).collect();
        let seen = alike(&seen, 1.0);
        for of in (0..FREEDOMS.len()).map(Some).chain([None]) {
            let (scale, end) = (0.7, 9.0);
            let law = Law::new(of, scale);
            let density = |z: &f64| match law.freedom() {
                Some(freedom) => StudentsT::new(0.0, scale, freedom).expect("valid").pdf(*z),
                None => Normal::new(0.0, scale).expect("valid").pdf(*z),
            };
            let by_hand = |share: f64| -> f64 {
                let mixed = |z| (1.0 - share) * density(z) + share / (2.0 * end);
                rows.iter().map(|z| mixed(z).ln()).sum()
            };
            let [none, some] = law.log_likelihoods(&seen, end);
            let n = count(rows.len());
            assert!((none - by_hand(0.0)).abs() < n * CHORD, "{of:?} {none} {}", by_hand(0.0));
            assert!((some - by_hand(MISTAKEN)).abs() < n * CHORD, "{of:?}");
        }
    }

    /// What a fit leaves of readings with heavy tails: a probability, of the law's own variance, and
    /// nearer to the normal law the less is left.
    #[test]
    fn residuals_have_the_variance_of_the_readings() {
        /// Of a square under a density that falls with the sixth power, cut where the table ends.
        const CUT: f64 = 2e-3;
        let (freedom, quarters) = FREEDOMS[3];
        let mut peaks = Vec::new();
        for left in [1.0, 0.6, 0.2, 0.05] {
            let table = Table::new((freedom, quarters), left);
            let step = 0.01;
            let moment = |power: i32| -> f64 {
                let at = |i: i32| f64::from(i) * step;
                let of = |i: i32| at(i).powi(power) * table.log_density(at(i)).exp() * step;
                (-7000..=7000).map(of).sum()
            };
            assert!((moment(0) - 1.0).abs() < CUT, "{left}: {}", moment(0));
            let variance = freedom / (freedom - 2.0);
            assert!((moment(2) / variance - 1.0).abs() < 10.0 * CUT, "{left}: {}", moment(2));
            peaks.push(table.log_density(0.0));
        }
        assert!(peaks.windows(2).all(|two| two[1] < two[0]), "{peaks:?}");
    }

    /// Beyond and within make one.
    #[test]
    fn what_lies_outside_is_what_densities_leave() {
        const STEP: f64 = 0.002;
        for left in [1.0, 0.5, 0.1] {
            let law = Law::new(Some(3), 1.0);
            let within: f64 = (-1000..1000)
                .map(|i| {
                    let z = (f64::from(i) + 0.5) * STEP;
                    table(3, left).log_density(z).exp() * STEP
                })
                .sum();
            let outside = law.outside(Seen { z: 2.0, left }, 1);
            assert!((within + outside - 1.0).abs() < 2e-3, "{left}: {within} {outside}");
        }
    }
}
