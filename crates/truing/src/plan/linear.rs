//! The model of a case, linearised: whitened columns of what was measured and of what could be.

use model_discrepancy::{Effect, Model, Role, State, whole_tangent};
use nalgebra::DMatrix;

/// Columns of base and effects.
pub(super) struct Linear {
    /// Rows of what is fitted.
    pub(super) measured: DMatrix<f64>,
    /// Rows of each measurement that is planned.
    pub(super) planned: Vec<DMatrix<f64>>,
    pub(super) n_base: usize,
    /// First column of each effect, where it was asked for.
    starts: Vec<Option<usize>>,
}

/// Which rows of the table of measurements the observations of a model are.
pub(super) struct Origins<'r> {
    /// Row with which each begins; `None` where every row is one.
    pub(super) rows: Option<Vec<usize>>,
    /// Rows that there were; those after them could be made.
    pub(super) n_rows: usize,
    /// Rows of each measurement that could be made.
    pub(super) sizes: &'r [usize],
}

impl Linear {
    /// Of a model of what was measured and of what could be; `noise` is a standard uncertainty where
    /// the rows have none of their own.
    pub(super) fn of(
        model: &dyn Model,
        effects: &[usize],
        origins: &Origins<'_>,
        noise: f64,
    ) -> Self {
        let Origins { rows, n_rows, sizes } = origins;
        let declared = model.declared();
        let at = State::start(model);
        let mut columns = vec![model.base_jacobian(&at)];
        let n_base = columns[0].ncols();
        let (mut starts, mut next) = (vec![None; declared.effects.len()], n_base);
        for &effect in effects {
            starts[effect] = Some(next);
            let tangent = whole_tangent(model, &at, effect);
            next += tangent.ncols();
            columns.push(tangent);
        }
        let layout = &declared.layout;
        let scale = if layout.sigma_declared { 1.0 } else { noise };
        let of_row: Vec<usize> = (sizes.iter().enumerate())
            .flat_map(|(n, size)| std::iter::repeat_n(n, *size))
            .collect();
        let origin = |observation: usize| match rows {
            // Knowledge from outside comes after all.
            Some(rows) => rows.get(observation).copied().unwrap_or(usize::MAX),
            None => observation,
        };
        let (mut measured, mut planned) = (Vec::new(), vec![Vec::new(); sizes.len()]);
        for (index, row) in layout.rows.iter().enumerate() {
            let of_plan =
                origin(row.observation).checked_sub(*n_rows).and_then(|n| of_row.get(n).copied());
            let role = layout.groups[layout.observations[row.observation]].role;
            match of_plan {
                Some(n) => planned[n].push(index),
                None if role != Role::Check => measured.push(index),
                None => {}
            }
        }
        let block = |rows: &Vec<usize>| {
            let mut block = DMatrix::zeros(rows.len(), next);
            for (to, &from) in rows.iter().enumerate() {
                let cells = columns
                    .iter()
                    .flat_map(|part| part.row(from).iter().copied().collect::<Vec<_>>());
                let sigma = layout.rows[from].sigma * scale;
                for (column, cell) in cells.enumerate() {
                    block[(to, column)] = cell / sigma;
                }
            }
            block
        };
        Self {
            measured: block(&measured),
            planned: planned.iter().map(block).collect(),
            n_base,
            starts,
        }
    }

    /// Columns of an effect; none where it was not asked for.
    pub(super) fn columns(&self, model: &dyn Model, effect: usize) -> Vec<usize> {
        let count = model.declared().effects[effect].parameters.len();
        self.starts[effect].map_or_else(Vec::new, |start| (start..start + count).collect())
    }

    pub(super) fn base(&self) -> Vec<usize> {
        (0..self.n_base).collect()
    }
}

/// An effect as answers call it.
pub(super) fn label(effect: &Effect) -> String {
    match &effect.subject {
        Some(subject) => format!("{} [{subject}]", effect.id),
        None => effect.id.clone(),
    }
}
