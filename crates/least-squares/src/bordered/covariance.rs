//! Covariance of shared point and blocks, one part at a time.

use std::fmt;
use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::block::{Place, Rows};
use super::parts::{BlockPart, BlockParts};
use super::passes::{Room, Setting, chunk_length, map_chunks};
use super::program::{PANEL, Program};
use super::rank::Rank;
use super::reduced::Reduced;
use super::solve::{Tally, report_at};
use super::strips::TILE;
use super::{BorderedOptions, BorderedPoint, BorderedProblem};
use crate::SolveError;

/// Share of a diagonal entry, left by the elimination, from which normal equations give the
/// covariance: they then lose six of a double's sixteen digits at most.
const STEADY_PIVOT: f64 = 1e-6;

/// Uncertainty of a point, as its data and their whitening determine it.
///
/// It holds the shared part; the parts of a block are computed when they are asked for, from the
/// block's rows alone. All are a priori: multiply covariances by `variance_factor` for the
/// a-posteriori ones.
pub struct BorderedCovariance<'a, P> {
    problem: &'a P,
    point: &'a BorderedPoint,
    options: BorderedOptions,
    pub(super) program: Program,
    /// Whether the normal equations of blocks and shared point are well enough conditioned.
    is_steady: bool,
    /// Inverse triangle by rows, under one of noughts for the residual's column; filled up with noughts.
    pub(super) root: Vec<f64>,
    /// Inverse triangle of the free shared columns, in the program's order.
    inverse: DMatrix<f64>,
    /// Their covariance.
    columns: DMatrix<f64>,
    /// Condition number of the whitened, column-scaled Jacobian of the shared directions, once
    /// the blocks are eliminated.
    pub condition: f64,
    /// Residuals used minus free directions.
    pub degrees_of_freedom: usize,
    /// `Σ w r² / degrees_of_freedom`; `None` when there is no redundancy.
    pub variance_factor: Option<f64>,
}

/// Covariance at a point, by elimination of one block after the other: of their normal equations
/// where these are well conditioned, orthogonal where not.
///
/// # Errors
///
/// [`SolveError::Unobservable`] when a direction is free, and the errors of bad input;
/// never [`SolveError::NotConverged`] or [`SolveError::Stalled`].
pub fn bordered_covariance<'a, P: BorderedProblem>(
    problem: &'a P,
    point: &'a BorderedPoint,
    options: &BorderedOptions,
) -> Result<BorderedCovariance<'a, P>, SolveError<BorderedPoint>> {
    let mut program = Program::new(problem, point, options)?;
    program.sort_chunks(chunk_length(&program));
    let place = Place { problem, program: &program, robust: &options.robust, point };
    let steady = steady(place, options.rank_tolerance);
    let is_steady = steady.is_some();
    let (triangle, rank, twice_cost) = if let Some((triangle, rank, twice_cost)) = steady {
        (triangle, rank, Some(twice_cost))
    } else {
        super::diagnose::all_finite(place)?;
        let shared = place.shared();
        (shared.triangle(), place.rank(&shared, options.rank_tolerance), None)
    };
    let tally = Tally::new(place, twice_cost);
    if !rank.directions.is_empty() {
        let report = Box::new(report_at(&program, &tally, &rank));
        let best = Box::new(point.clone());
        return Err(SolveError::Unobservable { directions: rank.directions, best, report });
    }
    let n = program.free.len();
    let mut inverse = DMatrix::identity(n, n);
    triangle.solve_upper_triangular_mut(&mut inverse);
    Ok(BorderedCovariance {
        columns: &inverse * inverse.transpose(),
        root: by_rows(&inverse, program.first.len() * PANEL),
        inverse,
        is_steady,
        condition: rank.condition,
        degrees_of_freedom: tally.degrees_of_freedom(&program),
        variance_factor: tally.variance_factor(&program),
        problem,
        point,
        options: options.clone(),
        program,
    })
}

/// Rows of a square matrix under one of noughts, so many in all and as wide as fills a number of tiles.
fn by_rows(matrix: &DMatrix<f64>, height: usize) -> Vec<f64> {
    let width = matrix.ncols().next_multiple_of(TILE);
    let mut rows = vec![0.0; height * width];
    for (row, from) in rows.chunks_exact_mut(width.max(1)).skip(1).zip(matrix.row_iter()) {
        row.iter_mut().zip(from.iter()).for_each(|(to, from)| *to = *from);
    }
    rows
}

/// Triangle of the shared columns and its rank from normal equations, and `Σ ρ`; `None` where they
/// are too weak, or a number is not finite.
fn steady<P: BorderedProblem>(
    place: Place<'_, P>,
    tolerance: f64,
) -> Option<(DMatrix<f64>, Rank, f64)> {
    let Place { problem, program, robust, point } = place;
    let mut room = Room::new(program);
    Setting { problem, program, robust }.eliminate(&mut room, point, 0.0);
    let sums = &room.sums;
    let mut reduced = Reduced::new(program, problem.shared_residual_count());
    reduced.collect(problem, program, &point.shared, sums);
    reduced.solve(program, 0.0);
    let is_finite = reduced.twice_cost.is_finite() && reduced.promised.is_finite();
    let least = sums.least_pivot.min(reduced.least_pivot);
    // Not `<`, so that NaN is refused too.
    if !(is_finite && least >= STEADY_PIVOT) {
        return None;
    }
    let n = program.free.len();
    let triangle = reduced.triangle(n);
    if n == 0 {
        let rank = Rank { directions: Vec::new(), condition: 1.0 };
        return Some((triangle, rank, reduced.twice_cost));
    }
    let mut scaled = triangle.clone();
    for (mut column, length) in scaled.column_iter_mut().zip(&reduced.lengths()) {
        column.unscale_mut(*length);
    }
    let values = scaled.singular_values();
    let (largest, smallest) = (values.max(), values.min());
    let rank = Rank { directions: Vec::new(), condition: largest / smallest };
    (smallest > tolerance * largest).then_some((triangle, rank, reduced.twice_cost))
}

impl<P> fmt::Debug for BorderedCovariance<'_, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BorderedCovariance")
            .field("condition", &self.condition)
            .field("degrees_of_freedom", &self.degrees_of_freedom)
            .field("variance_factor", &self.variance_factor)
            .finish_non_exhaustive()
    }
}

impl<P: BorderedProblem> BorderedCovariance<'_, P> {
    /// Covariance of the shared tangent step, `shared_dim × shared_dim`; zero rows and columns
    /// for held directions.
    #[must_use]
    pub fn shared(&self) -> DMatrix<f64> {
        let dim = self.program.shared_dim;
        let mut covariance = DMatrix::zeros(dim, dim);
        for (i, &a) in self.program.free.iter().enumerate() {
            for (j, &b) in self.program.free.iter().enumerate() {
                covariance[(a, b)] = self.columns[(i, j)];
            }
        }
        covariance
    }

    /// Covariance of the tangent step of one block, `block_dim × block_dim`; zero where held.
    ///
    /// # Panics
    ///
    /// If there is no such block; so do all methods that take one.
    #[must_use]
    pub fn block(&self, block: usize) -> DMatrix<f64> {
        self.between(block, block)
    }

    /// Covariance of the tangent steps of one block (rows) and another (columns).
    #[must_use]
    pub fn between(&self, block: usize, other: usize) -> DMatrix<f64> {
        let (moved, own) = self.of_block(block);
        if block == other {
            own + &moved * &self.columns * moved.transpose()
        } else {
            moved * &self.columns * self.of_block(other).0.transpose()
        }
    }

    /// Covariance of the tangent steps of one block (rows) and of the shared point (columns),
    /// `block_dim × shared_dim`.
    #[must_use]
    pub fn cross(&self, block: usize) -> DMatrix<f64> {
        let columns = self.of_block(block).0 * &self.columns;
        let mut cross = DMatrix::zeros(columns.nrows(), self.program.shared_dim);
        for (i, &direction) in self.program.free.iter().enumerate() {
            cross.set_column(direction, &columns.column(i));
        }
        cross
    }

    /// Leverage of each residual of a block: the share of its error that the estimate follows.
    ///
    /// 1 minus it is the residual's redundancy number; all leverages, those of
    /// [`BorderedCovariance::shared_leverages`] included, sum to the number of free directions.
    #[must_use]
    pub fn leverages(&self, block: usize) -> DVector<f64> {
        let factor = self.place().factor(&mut Rows::new(self.program.limits), block);
        let b = factor.diagonal.len();
        let mut inverse = DMatrix::identity(b, b);
        factor.triangle().solve_upper_triangular_mut(&mut inverse);
        let own = &factor.by_block * inverse;
        let shared = factor.projected() * &self.inverse;
        DVector::from_fn(own.nrows(), |i, _| {
            own.row(i).norm_squared() + shared.row(i).norm_squared()
        })
    }

    /// Leverage of each residual that depends on the shared point alone.
    #[must_use]
    pub fn shared_leverages(&self) -> DVector<f64> {
        let rows = self.place().shared_rows().1 * &self.inverse;
        DVector::from_fn(rows.nrows(), |i, _| rows.row(i).norm_squared())
    }

    /// Room for [`BorderedCovariance::fill`].
    #[must_use]
    pub fn parts(&self) -> BlockParts {
        BlockParts::new(&self.program)
    }

    /// Computes the parts of the first of some blocks, as many of them as are worked out side by side, in
    /// room that is used again; their number.
    ///
    /// # Panics
    ///
    /// If there are none.
    pub fn fill(&self, blocks: &[usize], parts: &mut BlockParts) -> usize {
        if !self.is_steady {
            parts.fill_orthogonally(self.place(), &self.inverse, blocks[0]);
            return 1;
        }
        let group = self.program.together(blocks[0], blocks[1..].iter().copied());
        parts.fill(self.place(), &self.root, &group);
        group.count
    }

    /// Parts of some blocks, one after the other.
    pub fn in_turn<'b>(&'b self, blocks: &'b [usize], parts: &'b mut BlockParts) -> InTurn<'b, P> {
        InTurn { covariance: self, rest: blocks, parts, filled: 0, taken: 0 }
    }

    /// Calls `work` on ranges that together are `0..count`, on as many threads as there are, each
    /// with room for the parts of a block, and hands `take` in turn what it makes of each; the ranges do
    /// not depend on the number of threads.
    pub fn in_chunks<T: Send>(
        &self,
        count: usize,
        work: impl Fn(Range<usize>, &mut BlockParts) -> T + Sync + Send,
        take: impl FnMut(T),
    ) {
        map_chunks(count, |range| work(range, &mut self.parts()), take);
    }

    fn place(&self) -> Place<'_, P> {
        let Self { problem, program, point, options, .. } = self;
        Place { problem, program, robust: &options.robust, point }
    }

    /// The block's step for a step of each shared column, and its covariance with those held.
    fn of_block(&self, block: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let dim = self.program.block_dim;
        if self.program.is_held(block) {
            return (DMatrix::zeros(dim, self.program.free.len()), DMatrix::zeros(dim, dim));
        }
        let factor = self.place().factor(&mut Rows::new(self.program.limits), block);
        let mut inverse = DMatrix::identity(dim, dim);
        factor.triangle().solve_upper_triangular_mut(&mut inverse);
        (-factor.coupling(), &inverse * inverse.transpose())
    }
}

/// Parts of blocks one after the other, a few of which are worked out at a time.
#[derive(Debug)]
pub struct InTurn<'a, P> {
    covariance: &'a BorderedCovariance<'a, P>,
    /// Blocks that are not filled.
    rest: &'a [usize],
    parts: &'a mut BlockParts,
    /// Number of blocks that are filled, and of those the number that were taken.
    filled: usize,
    taken: usize,
}

impl<P: BorderedProblem> InTurn<'_, P> {
    /// Parts of the next block; `None` after the last.
    pub fn next(&mut self) -> Option<&BlockPart> {
        if self.taken == self.filled {
            if self.rest.is_empty() {
                return None;
            }
            (self.filled, self.taken) = (self.covariance.fill(self.rest, self.parts), 0);
            self.rest = &self.rest[self.filled..];
        }
        self.taken += 1;
        Some(self.parts.nth(self.taken - 1))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::bordered_covariance;
    use crate::{BlockRows, BorderedOptions, BorderedPoint, BorderedProblem, Pattern};

    const BLOCKS: usize = 5;
    const ROWS: usize = 7;
    const OWN: usize = 3;
    const SHARED: usize = 4;
    /// Rounding of the whitened numbers, which are about one, times the condition.
    const TOLERANCE: f64 = 1e-11;

    /// A linear problem of arbitrary numbers; odd rows do not depend on the last own direction.
    struct Arbitrary {
        patterns: Vec<Pattern>,
    }

    impl Arbitrary {
        fn new() -> Self {
            let mut pattern = Pattern::new();
            for row in 0..ROWS {
                pattern.push(&[0, 1, 2][..OWN - row % 2], &[3, 1, 0, 2]);
            }
            Self { patterns: vec![pattern] }
        }
    }

    fn number(seed: usize) -> f64 {
        f64::sin(1.0 + 3.7 * f64::from(u32::try_from(seed).unwrap()).powf(1.3))
    }

    impl BorderedProblem for Arbitrary {
        fn shared_dim(&self) -> usize {
            SHARED
        }
        fn block_dim(&self) -> usize {
            OWN
        }
        fn block_count(&self) -> usize {
            BLOCKS
        }
        fn patterns(&self) -> &[Pattern] {
            &self.patterns
        }
        fn residuals(&self, block: usize, _: &[f64], _: &[f64], out: &mut [f64]) {
            (0..ROWS).for_each(|i| out[i] = number(1000 + block * ROWS + i));
        }
        fn linearise(&self, block: usize, shared: &[f64], point: &[f64], rows: BlockRows<'_>) {
            self.residuals(block, shared, point, rows.residuals);
            let (first, own) = (100 * block, rows.by_block.len());
            (0..own).for_each(|i| rows.by_block[i] = number(first + i));
            let by_shared = rows.by_shared.iter_mut().enumerate();
            by_shared.for_each(|(i, value)| *value = number(first + own + i));
        }
    }

    fn near(a: &DMatrix<f64>, b: &DMatrix<f64>) -> bool {
        (a - b).amax() <= TOLERANCE * b.amax()
    }

    /// Normal equations and reflections give the same parts, and these the covariance.
    #[test]
    fn parts_are_those_of_the_covariance_either_way() {
        let problem = Arbitrary::new();
        let point = BorderedPoint { shared: vec![0.0; SHARED], blocks: vec![0.0; BLOCKS * OWN] };
        let options =
            BorderedOptions { held_shared: vec![1], held_blocks: vec![3], ..Default::default() };
        let mut covariance = bordered_covariance(&problem, &point, &options).unwrap();
        assert!(covariance.is_steady);
        let (mut parts, mut other) = (covariance.parts(), covariance.parts());
        for is_steady in [true, false] {
            covariance.is_steady = is_steady;
            let blocks: Vec<usize> = (0..BLOCKS).collect();
            let mut in_turn = covariance.in_turn(&blocks, &mut parts);
            covariance.fill(&[0], &mut other);
            let width = other.width();
            for block in 0..BLOCKS {
                let parts = in_turn.next().unwrap();
                let own = DMatrix::from_row_slice(OWN, OWN, parts.own());
                let along = DMatrix::from_row_slice(OWN, width, parts.along());
                let whole = &own + &along * along.transpose();
                if block == 3 {
                    assert!(whole.iter().all(|value| value.to_bits() == 0), "a held block");
                } else {
                    assert!(near(&whole, &covariance.block(block)), "{block}");
                }
                let first = DMatrix::from_row_slice(OWN, width, other.nth(0).along());
                let between = covariance.between(block, 0);
                if block != 0 && block != 3 {
                    assert!(near(&(&along * first.transpose()), &between), "{block}");
                }
                let leverages = covariance.leverages(block);
                for (i, leverage) in parts.leverages().iter().enumerate() {
                    assert!((leverage - leverages[i]).abs() < TOLERANCE, "{block}, {i}");
                }
                let mut residuals = [0.0; ROWS];
                problem.residuals(block, &[], &[], &mut residuals);
                assert_eq!(parts.residuals(), residuals);
                let a = DMatrix::from_fn(2, OWN, |i, j| number(7 + 3 * i + j));
                let rows = a.transpose().as_slice().to_vec();
                let (mut added, mut followed) = ([0.0; 4], vec![0.0; 2 * width]);
                parts.add_combined(&rows, &mut added, &mut followed);
                let expected = &a * &own * a.transpose();
                assert!((DMatrix::from_row_slice(2, 2, &added) - expected).amax() < TOLERANCE);
                let expected = &a * &along;
                let followed = DMatrix::from_row_slice(2, width, &followed);
                assert!((followed - expected).amax() < TOLERANCE);
            }
            assert!(in_turn.next().is_none());
        }
    }

    /// Two columns that differ by a part in 1e5 leave a pivot of 1e-10: reflections take over, and the
    /// covariance is that of the exact numbers.
    #[test]
    fn weak_blocks_are_reflected() {
        struct Weak(Vec<Pattern>);
        impl BorderedProblem for Weak {
            fn shared_dim(&self) -> usize {
                1
            }
            fn block_dim(&self) -> usize {
                2
            }
            fn block_count(&self) -> usize {
                1
            }
            fn patterns(&self) -> &[Pattern] {
                &self.0
            }
            fn residuals(&self, _: usize, _: &[f64], _: &[f64], out: &mut [f64]) {
                out.fill(0.0);
            }
            fn linearise(&self, _: usize, _: &[f64], _: &[f64], rows: BlockRows<'_>) {
                rows.residuals.fill(0.0);
                rows.by_block.copy_from_slice(&[1.0, 1.0, 0.0, WEAK, 0.0, 0.0]);
                rows.by_shared.copy_from_slice(&[0.0, 0.0, 1.0]);
            }
        }
        const WEAK: f64 = 1e-5;
        let problem = Weak(vec![Pattern::dense(3, 2, 1)]);
        let point = BorderedPoint { shared: vec![0.0], blocks: vec![0.0; 2] };
        let covariance =
            bordered_covariance(&problem, &point, &BorderedOptions::default()).unwrap();
        assert!(!covariance.is_steady);
        let mut parts = covariance.parts();
        covariance.fill(&[0], &mut parts);
        // (JᵀJ)⁻¹ of [1 1; 0 w].
        let variance = WEAK.powi(-2);
        let expected = [1.0 + variance, -variance, -variance, variance];
        for (found, expected) in parts.nth(0).own().iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < TOLERANCE, "{found} for {expected}");
        }
    }
}
