use std::ops::ControlFlow;

use nalgebra::{DMatrix, Matrix2, Matrix4, Point2, Point3, RowVector4, Vector2, Vector4};

use crate::continued::continued_heights;
use crate::error::finite;
use crate::graph::{self, Graph, Jet};
use crate::univariate::Univariate;
use crate::{Curvature, Foot, GeometryError, Hit, Line, Surface};

/// Fewest places along either side: those of one cubic.
const MIN_PLACES: usize = 4;
/// Feet this many cells beside the grid are still given, as beside the aperture.
const MARGIN_CELLS: f64 = 1.0;
/// Share of a cell that round-off may put a foot beside the grid.
const RIM_SHARE: f64 = 1e-9;
/// Share of a cell in which two meetings with a line are one, found from both cells.
const SAME_MEETING: f64 = 1e-9;

/// Measured heights at evenly spaced places, joined by a bicubic B-spline; its normal points to +z.
///
/// The spline passes through every height and has two continuous derivatives. It repeats
/// quadratics to round-off and other smooth surfaces to the fourth order of the spacing. Closest points
/// are found as for a [`Polynomial`](crate::Polynomial): in the valley above which the query lies.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightGrid {
    origin_mm: Point2<f64>,
    spacing_mm: Vector2<f64>,
    /// Places along x and y.
    size: [usize; 2],
    /// One more on each side than there are places.
    coefficients: DMatrix<f64>,
    /// Places with a height, where some have none.
    measured: Option<DMatrix<bool>>,
}

impl HeightGrid {
    /// Heights row by row, x running fastest, the first at `origin_mm`.
    ///
    /// # Errors
    ///
    /// [`GeometryError::InvalidGrid`], [`GeometryError::InvalidRadius`] for a spacing that is not
    /// positive, [`GeometryError::NonFinite`].
    pub fn new(
        origin_mm: Point2<f64>,
        spacing_mm: Vector2<f64>,
        columns: usize,
        heights_mm: &[f64],
    ) -> Result<Self, GeometryError> {
        finite(origin_mm.iter(), "origin of the grid")?;
        finite(spacing_mm.iter(), "spacing of the grid")?;
        finite(heights_mm, "height of the grid")?;
        if spacing_mm.min() <= 0.0 {
            return Err(GeometryError::InvalidRadius { radius_mm: spacing_mm.min() });
        }
        let rows = heights_mm.len().checked_div(columns).unwrap_or(0);
        if columns.min(rows) < MIN_PLACES || columns * rows != heights_mm.len() {
            let heights = heights_mm.len();
            return Err(GeometryError::InvalidGrid { columns, rows, heights });
        }
        let heights = DMatrix::from_fn(columns, rows, |i, j| heights_mm[j * columns + i]);
        let along_x = interpolated(&heights);
        let coefficients = interpolated(&along_x.transpose()).transpose();
        let size = [columns, rows];
        Ok(Self { origin_mm, spacing_mm, size, coefficients, measured: None })
    }

    /// The same where some places have no height, as outside of a round part.
    ///
    /// Over them the spline goes on as smoothly as it can, and the surface is outside of its aperture;
    /// so it is over every cell that has such a place for a corner.
    ///
    /// # Errors
    ///
    /// As [`HeightGrid::new`], and [`GeometryError::InvalidGrid`] where no height is there.
    pub fn with_gaps(
        origin_mm: Point2<f64>,
        spacing_mm: Vector2<f64>,
        columns: usize,
        heights_mm: &[Option<f64>],
    ) -> Result<Self, GeometryError> {
        if heights_mm.iter().all(Option::is_none) {
            let rows = heights_mm.len().checked_div(columns).unwrap_or(0);
            return Err(GeometryError::InvalidGrid { columns, rows, heights: 0 });
        }
        finite(heights_mm.iter().flatten(), "height of the grid")?;
        let is_whole = columns > 0 && heights_mm.len().is_multiple_of(columns);
        let filled = if is_whole { continued_heights(columns, heights_mm) } else { Vec::new() };
        let mut grid = Self::new(origin_mm, spacing_mm, columns, &filled)?;
        if heights_mm.iter().any(Option::is_none) {
            let [columns, rows] = grid.size;
            let is_there = |i: usize, j: usize| heights_mm[j * columns + i].is_some();
            grid.measured = Some(DMatrix::from_fn(columns, rows, is_there));
        }
        Ok(grid)
    }

    /// Whether a place lies in a cell all corners of which have a height, its border included.
    #[must_use]
    pub fn is_measured(&self, x_mm: f64, y_mm: f64) -> bool {
        let place = self.place(x_mm, y_mm);
        if self.beside(place) > RIM_SHARE {
            return false;
        }
        let Some(measured) = &self.measured else { return true };
        let has_all =
            |i: usize, j: usize| measured.view((i, j), (2, 2)).iter().all(|is_there| *is_there);
        // On a border, either cell will do.
        let on = |axis: usize| {
            [-RIM_SHARE, RIM_SHARE].map(|aside| self.cell(axis, place[axis] + aside).0)
        };
        on(0).iter().any(|&i| on(1).iter().any(|&j| has_all(i, j)))
    }

    /// Height and derivatives; beside the grid it goes on along the slope at its border.
    pub(crate) fn continued(&self, x_mm: f64, y_mm: f64) -> Jet {
        let place = self.place(x_mm, y_mm);
        if self.beside(place) <= RIM_SHARE {
            return self.jet(x_mm, y_mm);
        }
        let border = |axis: usize| place[axis].clamp(0.0, self.last(axis));
        let x = self.origin_mm.x + border(0) * self.spacing_mm.x;
        let y = self.origin_mm.y + border(1) * self.spacing_mm.y;
        let Jet { z, gradient, .. } = self.jet(x, y);
        let beyond = Vector2::new(x_mm - x, y_mm - y);
        Jet { z: z + gradient.dot(&beyond), gradient, hessian: Matrix2::zeros() }
    }

    /// Corners of the grid with the least and the largest x and y.
    #[must_use]
    pub fn extent_mm(&self) -> [Point2<f64>; 2] {
        let across = Vector2::new(self.last(0), self.last(1)).component_mul(&self.spacing_mm);
        [self.origin_mm, self.origin_mm + across]
    }

    /// Distance of neighbouring places along x and y.
    #[must_use]
    pub fn spacing_mm(&self) -> Vector2<f64> {
        self.spacing_mm
    }

    /// Height over the xy plane.
    #[must_use]
    pub fn sag_mm(&self, x_mm: f64, y_mm: f64) -> f64 {
        self.jet(x_mm, y_mm).z
    }

    /// Place in units of the spacing.
    fn place(&self, x: f64, y: f64) -> [f64; 2] {
        [(x - self.origin_mm.x) / self.spacing_mm.x, (y - self.origin_mm.y) / self.spacing_mm.y]
    }

    /// The last place along an axis.
    fn last(&self, axis: usize) -> f64 {
        as_f64(self.size[axis] - 1)
    }

    /// The cell of a place, the outermost one beyond the grid, and the place within it.
    fn cell(&self, axis: usize, place: f64) -> (usize, f64) {
        let floor = place.floor().clamp(0.0, self.last(axis) - 1.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the cells of the grid; NaN becomes the first"
        )]
        let index = floor as usize;
        (index, place - floor)
    }

    fn patch(&self, [i, j]: [usize; 2]) -> Matrix4<f64> {
        self.coefficients.fixed_view::<4, 4>(i, j).into_owned()
    }

    /// How far a place is beside the grid, in cells.
    fn beside(&self, [u, v]: [f64; 2]) -> f64 {
        let out = |place: f64, last: f64| (-place).max(place - last).max(0.0);
        out(u, self.last(0)).max(out(v, self.last(1)))
    }

    fn outside(&self, at: Point2<f64>) -> GeometryError {
        let half = Vector2::new(self.last(0), self.last(1)).component_mul(&self.spacing_mm) * 0.5;
        let distance_mm = (at - (self.origin_mm + half)).norm();
        GeometryError::OutsideAperture { distance_mm, aperture_radius_mm: half.norm() }
    }

    /// Where the line is above the grid, in mm along it; infinite for a line along z.
    fn over(&self, from: [f64; 2], per_mm: [f64; 2]) -> Result<(f64, f64), GeometryError> {
        let (mut start, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..2 {
            let last = self.last(axis);
            if per_mm[axis] == 0.0 {
                if from[axis] < -RIM_SHARE || from[axis] > last + RIM_SHARE {
                    return Err(GeometryError::Misses);
                }
                continue;
            }
            let ends = [-from[axis] / per_mm[axis], (last - from[axis]) / per_mm[axis]];
            start = start.max(ends[0].min(ends[1]));
            end = end.min(ends[0].max(ends[1]));
        }
        if start > end { Err(GeometryError::Misses) } else { Ok((start, end)) }
    }

    /// The cell that the line enters at `at`, and where it leaves it.
    fn next_cell(&self, from: [f64; 2], per_mm: [f64; 2], at: f64, end: f64) -> ([usize; 2], f64) {
        let mut cell = [0; 2];
        let mut leave = end;
        for axis in 0..2 {
            let place = from[axis] + per_mm[axis] * at;
            // A little further on, so that a place on the border counts to the cell ahead.
            let ahead = place + per_mm[axis].signum() * RIM_SHARE;
            let (index, _) = self.cell(axis, if per_mm[axis] == 0.0 { place } else { ahead });
            cell[axis] = index;
            if per_mm[axis] != 0.0 {
                let border = as_f64(index + usize::from(per_mm[axis] > 0.0));
                leave = leave.min((border - from[axis]) / per_mm[axis]);
            }
        }
        (cell, leave.max(at))
    }

    /// Height of the line above a cell's patch, by mm from `at`.
    fn gap(&self, line: &Line, cell: [usize; 2], at: f64) -> Result<Univariate, GeometryError> {
        let start = line.at(at);
        let [u, v] = self.place(start.x, start.y);
        let along_x = [u - as_f64(cell[0]), line.direction.x / self.spacing_mm.x];
        let along_y = [v - as_f64(cell[1]), line.direction.y / self.spacing_mm.y];
        let (xs, ys) = (Univariate::powers(along_x), Univariate::powers(along_y));
        let powers = power_basis() * self.patch(cell) * power_basis().transpose();
        let mut gap = Univariate::linear([start.z, line.direction.z]);
        for (i, x) in xs.iter().enumerate().take(4) {
            for (j, y) in ys.iter().enumerate().take(4) {
                gap.subtract_product(x, y, powers[(i, j)]);
            }
        }
        gap.trimmed(6).ok_or(GeometryError::LineInSurface)
    }
}

impl Graph for HeightGrid {
    fn jet(&self, x: f64, y: f64) -> Jet {
        let [u, v] = self.place(x, y);
        let ((i, s), (j, t)) = (self.cell(0, u), self.cell(1, v));
        let patch = self.patch([i, j]);
        let [bx, dx, ddx] = basis(s);
        let [by, dy, ddy] = basis(t);
        let form = |a: &RowVector4<f64>, b: &RowVector4<f64>| (a * patch * b.transpose())[(0, 0)];
        let (hx, hy) = (self.spacing_mm.x, self.spacing_mm.y);
        let mixed = form(&dx, &dy) / (hx * hy);
        Jet {
            z: form(&bx, &by),
            gradient: Vector2::new(form(&dx, &by) / hx, form(&bx, &dy) / hy),
            hessian: Matrix2::new(
                form(&ddx, &by) / (hx * hx),
                mixed,
                mixed,
                form(&bx, &ddy) / (hy * hy),
            ),
        }
    }

    fn contains(&self, x: f64, y: f64) -> bool {
        self.is_measured(x, y)
    }

    fn each_hit(
        &self,
        line: &Line,
        visit: &mut impl FnMut(Hit) -> ControlFlow<()>,
    ) -> Result<(), GeometryError> {
        finite(line.point_mm.iter(), "point of the line")?;
        let from = self.place(line.point_mm.x, line.point_mm.y);
        let per_mm = [line.direction.x / self.spacing_mm.x, line.direction.y / self.spacing_mm.y];
        let (start, end) = self.over(from, per_mm)?;
        if !start.is_finite() {
            // Along z: the line stays above one place.
            let height = self.jet(line.point_mm.x, line.point_mm.y).z;
            let _ = visit(graph::hit(self, line, (height - line.point_mm.z) / line.direction.z));
            return Ok(());
        }
        let (mut at, mut last) = (start, f64::NEG_INFINITY);
        let same_mm = SAME_MEETING * self.spacing_mm.min();
        // Every step leaves one cell for another.
        for _ in 0..self.size[0] + self.size[1] + 2 {
            let (cell, leave) = self.next_cell(from, per_mm, at, end);
            let mut stopped = false;
            self.gap(line, cell, at)?.each_root(&mut |root| {
                let meeting = at + root;
                if root < -same_mm || meeting > leave + same_mm || meeting - last < same_mm {
                    return ControlFlow::Continue(());
                }
                last = meeting;
                let flow = visit(graph::hit(self, line, meeting));
                stopped = flow.is_break();
                flow
            });
            if stopped || leave >= end {
                break;
            }
            at = leave;
        }
        if last.is_finite() { Ok(()) } else { Err(GeometryError::Misses) }
    }
}

impl Surface for HeightGrid {
    fn closest_point(&self, query_mm: &Point3<f64>) -> Result<Foot, GeometryError> {
        finite([&query_mm.coords.norm_squared()], "query point")?;
        let foot = graph::foot(self, query_mm)?;
        let at = foot.point_mm.xy();
        if self.beside(self.place(at.x, at.y)) > MARGIN_CELLS {
            return Err(self.outside(at));
        }
        Ok(foot)
    }

    fn curvature(&self, point_mm: &Point3<f64>) -> Result<Curvature, GeometryError> {
        graph::curvature(self, point_mm)
    }

    fn hits(&self, line: &Line) -> Result<Vec<Hit>, GeometryError> {
        graph::hits(self, line)
    }

    fn first_hit(&self, ray: &Line) -> Result<Hit, GeometryError> {
        graph::first_hit(self, ray)
    }
}

/// Coefficients of cubic B-splines through each column of values.
///
/// `(c₋ + 4c + c₊)/6 = z` inside, and the third difference zero at the ends, which repeats quadratics.
/// The equations of the first two places then give `c₀ − c₁ = z₀ − z₁`, and all is tridiagonal.
fn interpolated(values: &DMatrix<f64>) -> DMatrix<f64> {
    let n = values.nrows();
    let mut out = DMatrix::zeros(n + 2, values.ncols());
    for (z, mut c) in values.column_iter().zip(out.column_iter_mut()) {
        let (first, last) = (z[0] - z[1], z[n - 1] - z[n - 2]);
        let mut diagonal = vec![4.0; n - 2];
        let mut right: Vec<f64> = (1..n - 1).map(|i| 6.0 * z[i]).collect();
        diagonal[0] += 1.0;
        right[0] -= first;
        diagonal[n - 3] += 1.0;
        right[n - 3] -= last;
        for i in 1..n - 2 {
            let factor = 1.0 / diagonal[i - 1];
            diagonal[i] -= factor;
            right[i] -= factor * right[i - 1];
        }
        for i in (0..n - 2).rev() {
            let known = if i == n - 3 { 0.0 } else { c[i + 3] };
            c[i + 2] = (right[i] - known) / diagonal[i];
        }
        c[1] = c[2] + first;
        c[n] = c[n - 1] + last;
        c[0] = 3.0 * c[1] - 3.0 * c[2] + c[3];
        c[n + 1] = 3.0 * c[n] - 3.0 * c[n - 1] + c[n - 2];
    }
    out
}

/// The four B-splines over a cell by powers of the place within it: one row per power.
fn power_basis() -> Matrix4<f64> {
    Matrix4::new(
        1.0, 4.0, 1.0, 0.0, //
        -3.0, 0.0, 3.0, 0.0, //
        3.0, -6.0, 3.0, 0.0, //
        -1.0, 3.0, -3.0, 1.0,
    ) / 6.0
}

/// The four B-splines at a place within a cell, with first and second derivatives.
fn basis(t: f64) -> [RowVector4<f64>; 3] {
    let powers = power_basis();
    [
        Vector4::new(1.0, t, t * t, t * t * t),
        Vector4::new(0.0, 1.0, 2.0 * t, 3.0 * t * t),
        Vector4::new(0.0, 0.0, 2.0, 6.0 * t),
    ]
    .map(|of| of.transpose() * powers)
}

#[expect(clippy::cast_precision_loss, reason = "places of a grid are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
