//! The model of a case, linearised: whitened columns of what was measured and of what could be.

use model_discrepancy::{Effect, Layout, Model, Role, Row, State, whole_tangent};
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
    /// Columns of a shift of everything planned against everything measured, one for each component; none
    /// where a later session cannot be one of its own.
    session: Vec<usize>,
}

/// Which rows of the table of measurements the observations of a model are.
pub(super) struct Origins<'r> {
    /// Row with which each begins; `None` where every row is one.
    pub(super) rows: Option<Vec<usize>>,
    /// Rows that there were; those after them could be made.
    pub(super) n_rows: usize,
    /// Rows of each measurement that could be made.
    pub(super) sizes: &'r [usize],
    /// Whether all may have been set up anew before what is planned.
    pub(super) new_session: bool,
}

impl Origins<'_> {
    /// Rows of a layout that could be made, each with which measurement it is of.
    pub(super) fn of_plan<'a>(
        &'a self,
        layout: &'a Layout,
    ) -> impl Iterator<Item = (usize, usize)> + 'a {
        let of_row: Vec<usize> = (self.sizes.iter().enumerate())
            .flat_map(|(n, size)| std::iter::repeat_n(n, *size))
            .collect();
        let origin = |observation: usize| match &self.rows {
            // Knowledge from outside comes after all.
            Some(rows) => rows.get(observation).copied().unwrap_or(usize::MAX),
            None => observation,
        };
        layout.rows.iter().enumerate().filter_map(move |(index, row)| {
            let n = origin(row.observation).checked_sub(self.n_rows)?;
            Some((index, *of_row.get(n)?))
        })
    }
}

impl Linear {
    /// Of a model of what was measured and of what could be; `noise` is the standard uncertainty of a scalar
    /// that the final model leaves: it counts where the rows have none of their own, and where groups scatter
    /// beyond theirs.
    pub(super) fn of(
        model: &dyn Model,
        effects: &[usize],
        origins: &Origins<'_>,
        noise: f64,
    ) -> Self {
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
        let components = layout.rows.iter().map(|row| row.component + 1).max().unwrap_or(0);
        let session: Vec<usize> =
            if origins.new_session { (next..next + components).collect() } else { Vec::new() };
        let width = next + session.len();
        let mut planned = vec![Vec::new(); origins.sizes.len()];
        let mut is_planned = vec![false; layout.rows.len()];
        for (row, n) in origins.of_plan(layout) {
            planned[n].push(row);
            is_planned[row] = true;
        }
        let is_check =
            |row: &Row| layout.groups[layout.observations[row.observation]].role == Role::Check;
        let measured: Vec<usize> = (0..layout.rows.len())
            .filter(|&row| !is_planned[row] && !is_check(&layout.rows[row]))
            .collect();
        let sigma = Sigma::of(model, &measured, noise);
        let block = |rows: &Vec<usize>, is_planned: bool| {
            let mut block = DMatrix::zeros(rows.len(), width);
            for (to, &from) in rows.iter().enumerate() {
                let cells = columns
                    .iter()
                    .flat_map(|part| part.row(from).iter().copied().collect::<Vec<_>>());
                let sigma = sigma.of_row(&layout.rows[from]);
                for (column, cell) in cells.enumerate() {
                    block[(to, column)] = cell / sigma;
                }
                if let Some(&column) =
                    session.get(layout.rows[from].component).filter(|_| is_planned)
                {
                    block[(to, column)] = sigma.recip();
                }
            }
            block
        };
        Self {
            measured: block(&measured, false),
            planned: planned.iter().map(|rows| block(rows, true)).collect(),
            n_base,
            starts,
            session,
        }
    }

    /// Columns of an effect; none where it was not asked for.
    pub(super) fn columns(&self, model: &dyn Model, effect: usize) -> Vec<usize> {
        let count = model.declared().effects[effect].parameters.len();
        self.starts[effect].map_or_else(Vec::new, |start| (start..start + count).collect())
    }

    /// Columns of a session of its own, of what is planned.
    pub(super) fn session(&self) -> &[usize] {
        &self.session
    }

    pub(super) fn base(&self) -> Vec<usize> {
        (0..self.n_base).collect()
    }
}

/// What a row scatters by.
struct Sigma {
    /// Factor of a row's own.
    scale: f64,
    /// Beside it, from group to group.
    between: f64,
}

impl Sigma {
    fn of(model: &dyn Model, measured: &[usize], noise: f64) -> Self {
        let declared = model.declared();
        let rows = &declared.layout.rows;
        if declared.between_variance {
            // As the loop has it: what groups scatter beyond their own noise is the same for all.
            let own = measured.iter().map(|&row| &rows[row]).filter(|row| row.reported);
            let squares: Vec<f64> = own.map(|row| row.sigma.powi(2)).collect();
            #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
            let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
            return Self { scale: 1.0, between: (noise * noise - mean).max(0.0).sqrt() };
        }
        let scale = if declared.layout.sigma_declared { 1.0 } else { noise };
        Self { scale, between: 0.0 }
    }

    fn of_row(&self, row: &Row) -> f64 {
        let own = self.scale * row.sigma;
        if row.reported { own.hypot(self.between) } else { own }
    }
}

/// An effect as answers call it.
pub(super) fn label(effect: &Effect) -> String {
    match &effect.subject {
        Some(subject) => format!("{} [{subject}]", effect.id),
        None => effect.id.clone(),
    }
}
