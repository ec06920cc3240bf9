//! Force read along a programmed path, run after run.

use crate::ForceImpedanceError;

/// Places of a path at which the force is judged, at most: a repeated error of a hundredth of the
/// path is seen, and the loop stays quick.
const MAX_CELLS: usize = 96;
/// Fewest of them from which a path has a shape.
const MIN_CELLS: usize = 8;

/// One reading of a force instrument while a programmed path is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PathSample {
    /// Time of the reading.
    pub time_s: f64,
    /// Where on the path it was made; equal values are the same place in every run.
    pub path_mm: f64,
    /// Normal force that the instrument read.
    pub force_n: f64,
    /// Normal force asked for.
    pub reference_n: f64,
    /// Which run it belongs to, counted from 0; readings of one follow each other.
    pub run: usize,
}

/// Mean over one run's readings of one cell of the path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) run: usize,
    /// Position among the cells of the path.
    pub(crate) place: usize,
    /// Readings, in the order measured.
    pub(crate) samples: Vec<usize>,
    pub(crate) path_mm: f64,
    pub(crate) reference_n: f64,
    /// Force read − force asked for.
    pub(crate) residual_n: f64,
    /// Time from the first reading as a share of the whole.
    pub(crate) elapsed_share: f64,
}

/// The stretch of the path that every run went over, cut into equal cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) from_mm: f64,
    pub(crate) to_mm: f64,
    pub(crate) cells: usize,
}

impl Stretch {
    pub(crate) fn of(samples: &[PathSample]) -> Result<Self, ForceImpedanceError> {
        let (mut from_mm, mut to_mm) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut fewest = usize::MAX;
        let runs = || samples.chunk_by(|a, b| a.run == b.run);
        for run in runs() {
            let least = run.iter().map(|s| s.path_mm).fold(f64::INFINITY, f64::min);
            let most = run.iter().map(|s| s.path_mm).fold(f64::NEG_INFINITY, f64::max);
            (from_mm, to_mm) = (from_mm.max(least), to_mm.min(most));
        }
        if from_mm >= to_mm {
            return Err(ForceImpedanceError::NoCommonPath { runs: runs().count(), from_mm, to_mm });
        }
        for run in runs() {
            let within = |s: &&PathSample| (from_mm..=to_mm).contains(&s.path_mm);
            fewest = fewest.min(run.iter().filter(within).count());
        }
        if fewest < MIN_CELLS {
            return Err(ForceImpedanceError::TooFewSamples { got: fewest, needed: MIN_CELLS });
        }
        Ok(Self { from_mm, to_mm, cells: fewest.min(MAX_CELLS) })
    }

    /// Cell of a place; `None` outside the stretch.
    pub(crate) fn cell(&self, path_mm: f64) -> Option<usize> {
        let share = (path_mm - self.from_mm) / (self.to_mm - self.from_mm);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of cells"
        )]
        (0.0..=1.0)
            .contains(&share)
            .then(|| ((share * crate::count(self.cells)) as usize).min(self.cells - 1))
    }
}

/// Means of each run's readings by cell, run by run in the order measured.
pub(crate) fn cells(samples: &[PathSample], stretch: &Stretch) -> Vec<Cell> {
    let times = || samples.iter().map(|s| s.time_s);
    let first_s = times().fold(f64::INFINITY, f64::min);
    let last_s = times().fold(f64::NEG_INFINITY, f64::max);
    let runs_on = samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
    let whole_s = (last_s - first_s).max(f64::MIN_POSITIVE);
    let n = crate::count(samples.len().max(2) - 1);
    let elapsed = |i: usize| {
        if runs_on { (samples[i].time_s - first_s) / whole_s } else { crate::count(i) / n }
    };
    let mut all = Vec::new();
    let mut start = 0;
    for run in samples.chunk_by(|a, b| a.run == b.run) {
        let mut of_run = vec![Vec::new(); stretch.cells];
        for (i, sample) in run.iter().enumerate() {
            if let Some(place) = stretch.cell(sample.path_mm) {
                of_run[place].push(start + i);
            }
        }
        let seen = of_run.into_iter().enumerate().filter(|(_, members)| !members.is_empty());
        let mut found: Vec<Cell> = seen
            .map(|(place, members)| {
                let n = crate::count(members.len());
                let mean =
                    |of: &dyn Fn(usize) -> f64| members.iter().map(|&i| of(i)).sum::<f64>() / n;
                Cell {
                    run: run[0].run,
                    place,
                    path_mm: mean(&|i| samples[i].path_mm),
                    reference_n: mean(&|i| samples[i].reference_n),
                    residual_n: mean(&|i| samples[i].force_n - samples[i].reference_n),
                    elapsed_share: mean(&elapsed),
                    samples: members,
                }
            })
            .collect();
        found.sort_by_key(|cell| cell.samples[0]);
        all.extend(found);
        start += run.len();
    }
    all
}

/// Checks that every number is finite and that time runs on within each run.
pub(crate) fn check(samples: &[PathSample]) -> Result<(), ForceImpedanceError> {
    if samples.is_empty() {
        return Err(ForceImpedanceError::TooFewSamples { got: 0, needed: MIN_CELLS });
    }
    for (index, s) in samples.iter().enumerate() {
        let named = [
            ("time", s.time_s),
            ("path", s.path_mm),
            ("force", s.force_n),
            ("reference", s.reference_n),
        ];
        if let Some((quantity, _)) = named.iter().find(|(_, value)| !value.is_finite()) {
            let source = ForceImpedanceError::NotFinite { quantity, index: 1 };
            return Err(ForceImpedanceError::Sample { index, source: Box::new(source) });
        }
    }
    for (i, pair) in samples.windows(2).enumerate() {
        let (before_s, after_s) = (pair[0].time_s, pair[1].time_s);
        if pair[0].run == pair[1].run && after_s <= before_s {
            return Err(ForceImpedanceError::TimeNotIncreasing { index: i + 1, before_s, after_s });
        }
    }
    Ok(())
}
