//! A long record thinned, so that what is wrong with it need not be looked for in every sample.

use super::misfit::{Misfit, TIE};
use super::order::blocks;
use crate::case::{Change, Edit};
use crate::kind::Files;

/// Samples on which every hypothesis is tried: of a dozen segments or some fifty presses each keeps
/// hundreds, and what is named is tried on all of them afterwards.
const MOST_SAMPLES: usize = 20_000;

/// The samples that stay of a long record, evenly spaced in each of its groups.
#[derive(Debug)]
pub(super) struct Thinned {
    file: &'static str,
    rows: Vec<usize>,
    /// Degrees of freedom that they leave the case as it stands, where it can be fitted.
    pub(super) dof: Option<usize>,
}

impl Thinned {
    /// Of the record of a case; `None` where it is short, or where the case is another without most of
    /// its samples: where `misfit` of all of them, if they can be fitted, is not that of those that
    /// stay.
    pub(super) fn of(files: &Files, misfit: Option<&Misfit>) -> Option<Self> {
        let (file, group) = files.kind.record?;
        let table = files.folder.table(file, &[]).ok().filter(|t| t.n_rows() > MOST_SAMPLES)?;
        let blocks = blocks(&table, Some(group));
        let most = (MOST_SAMPLES / blocks.len()).max(1);
        let of_block = |block: std::ops::Range<usize>| {
            let step = block.len().div_ceil(most);
            block.step_by(step)
        };
        let rows = blocks.into_iter().flat_map(of_block).collect();
        let thinned = Self { file, rows, dof: None };
        let Some(misfit) = misfit else { return Some(thinned) };
        let reading = files.with(&thinned.edits(&[])).read().ok()?;
        let fitted = reading.measured.fit_alone().ok()?;
        let (of_few, _) = Misfit::of(&*reading.measured, &fitted);
        let ratio = of_few.share / misfit.share;
        let is_same = ratio <= TIE && ratio * TIE >= 1.0;
        is_same.then_some(Self { dof: Some(of_few.dof), ..thinned })
    }

    /// These changes, and of the record only the samples that stay; changes are those of rows as they
    /// stand in the file, and take rows away last.
    pub(super) fn edits(&self, edits: &[Edit]) -> Vec<Edit> {
        let mut thinned = edits.to_vec();
        let keeps = thinned.iter_mut().filter(|edit| edit.file == self.file);
        let kept = keeps.filter_map(|edit| match &mut edit.change {
            Change::Keep { rows } => Some(rows),
            _ => None,
        });
        if let Some(rows) = kept.last() {
            rows.retain(|row| self.rows.binary_search(row).is_ok());
        } else {
            let change = Change::Keep { rows: self.rows.clone() };
            thinned.push(Edit { file: self.file, change });
        }
        thinned
    }
}
