//! What ties the stations to the machine: the directions in which they may move.
#![expect(
    clippy::inline_always,
    reason = "vector instructions are chosen per caller: what is not inlined goes without them"
)]

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Point3, Rotation3, Vector3};

use crate::{Gauge, Options, TrackerError};

/// Positions of the stations as `nominal + basis · parameters`.
#[derive(Clone, Debug)]
pub(crate) struct StationChart {
    gauge: Gauge,
    nominal_mm: DVector<f64>,
    /// Orthonormal, `3 stations × parameters`.
    basis: DMatrix<f64>,
    /// Coordinate that each parameter moves most.
    coordinates: Vec<usize>,
    /// Parameters that move each station, and which way.
    moves: Vec<Vec<(usize, Vector3<f64>)>>,
    /// Standard uncertainty of each coordinate's nominal value, where it counts as data.
    pub(crate) prior_mm: Option<f64>,
}

/// Stations whose places are worked out once for all rows of a block.
const FEW: usize = 16;

/// Places of all stations at one set of parameters.
pub(crate) struct Places<'a> {
    chart: &'a StationChart,
    shared: &'a [f64],
    known: [Vector3<f64>; FEW],
    /// Not where they are more than fit, or asked for once only.
    pub(crate) are_known: bool,
}

impl Places<'_> {
    #[inline(always)]
    pub(crate) fn at_mm(&self, station: usize) -> Vector3<f64> {
        if self.are_known {
            self.known[station]
        } else {
            self.chart.position_mm(station, self.shared)
        }
    }
}

/// Share of a motion's length below which the stations do not feel it: they are collinear.
const SMALLEST_SHARE: f64 = 1e-6;
/// Entries of a unit vector below this are rounding.
const NO_SHARE: f64 = 1e-14;

impl StationChart {
    pub(crate) fn new(nominal_mm: &[Point3<f64>], options: &Options) -> Result<Self, TrackerError> {
        let n = 3 * nominal_mm.len();
        let flat = DVector::from_iterator(n, nominal_mm.iter().flat_map(|p| p.iter().copied()));
        let has_prior = matches!(options.gauge, Gauge::Stations | Gauge::Shape);
        let prior_mm = options.noise.station_mm.filter(|_| has_prior);
        let constraints = match (options.gauge, prior_mm) {
            (Gauge::Stations, Some(_)) => DMatrix::zeros(n, 0),
            (Gauge::Stations, None) | (Gauge::Inner | Gauge::Shape, _) => rigid_motions(nominal_mm),
            (Gauge::Minimal, _) => three_stations(nominal_mm)?,
        };
        let (basis, coordinates) = complement(&constraints)?;
        let moves = (0..nominal_mm.len()).map(|station| moves(&basis, station)).collect();
        let gauge = options.gauge;
        Ok(Self { gauge, nominal_mm: flat, basis, coordinates, moves, prior_mm })
    }

    /// Number of parameters.
    pub(crate) fn dim(&self) -> usize {
        self.basis.ncols()
    }

    /// Position of one station at the parameters given first in `shared`.
    #[inline(always)]
    pub(crate) fn position_mm(&self, station: usize, shared: &[f64]) -> Vector3<f64> {
        let nominal = self.nominal_mm.fixed_rows::<3>(3 * station).into_owned();
        self.moves[station].iter().fold(nominal, |at, (p, way)| at + way * shared[*p])
    }

    /// Places of all stations, for many rows.
    #[inline(always)]
    pub(crate) fn places<'a>(&'a self, shared: &'a [f64]) -> Places<'a> {
        let mut places = self.place(shared);
        places.are_known = self.moves.len() <= FEW;
        for (station, place) in places.known.iter_mut().enumerate().take(self.moves.len()) {
            *place = self.position_mm(station, shared);
        }
        places
    }

    /// Places of stations, for one row.
    #[inline(always)]
    pub(crate) fn place<'a>(&'a self, shared: &'a [f64]) -> Places<'a> {
        Places { chart: self, shared, known: [Vector3::zeros(); FEW], are_known: false }
    }

    /// The rigid motion that takes the given places where the gauge wants them.
    pub(crate) fn alignment(&self, places_mm: &[Vector3<f64>]) -> Option<Isometry3<f64>> {
        let nominal: Vec<Vector3<f64>> = (0..places_mm.len())
            .map(|i| self.nominal_mm.fixed_rows::<3>(3 * i).into_owned())
            .collect();
        if self.gauge == Gauge::Minimal {
            return Some(frame_of(&nominal)? * frame_of(places_mm)?.inverse());
        }
        rigid_fit(places_mm, &nominal)
    }

    /// Parameters that move a station, and the derivative of its position by each.
    pub(crate) fn moves(&self, station: usize) -> &[(usize, Vector3<f64>)] {
        &self.moves[station]
    }

    /// Index of the coordinate, station by station, that a parameter moves most.
    pub(crate) fn coordinate(&self, parameter: usize) -> usize {
        self.coordinates[parameter]
    }

    /// Parameters nearest to the given positions.
    pub(crate) fn parameters(&self, positions_mm: &[Vector3<f64>]) -> DVector<f64> {
        let n = self.nominal_mm.len();
        let flat = DVector::from_iterator(n, positions_mm.iter().flat_map(|p| p.iter().copied()));
        self.basis.tr_mul(&(flat - &self.nominal_mm))
    }

    /// Rows that say how well the nominal positions are known: the parameters are coordinates, or
    /// orthonormal combinations of these.
    pub(crate) fn linearise_prior(
        &self,
        shared: &[f64],
        residuals: &mut [f64],
        jacobian: &mut [f64],
    ) {
        let Some(sigma_mm) = self.prior_mm else { return };
        jacobian.fill(0.0);
        for (row, residual) in residuals.iter_mut().enumerate() {
            *residual = shared[row] / sigma_mm;
            jacobian[row * shared.len() + row] = 1.0 / sigma_mm;
        }
    }

    /// Derivative of all coordinates by the parameters.
    pub(crate) fn basis(&self) -> &DMatrix<f64> {
        &self.basis
    }
}

/// Frame with its origin in the first place, x towards the second, the third in its xy plane.
fn frame_of(places_mm: &[Vector3<f64>]) -> Option<Isometry3<f64>> {
    let x = (places_mm[1] - places_mm[0]).try_normalize(0.0)?;
    let z = x.cross(&(places_mm[2] - places_mm[0])).try_normalize(0.0)?;
    let rotation = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let rotation = Rotation3::from_matrix_unchecked(rotation);
    Some(Isometry3::from_parts(places_mm[0].into(), rotation.into()))
}

/// The proper rigid motion nearest to taking `from` to `to` (Kabsch 1976, Umeyama 1991).
pub(crate) fn rigid_fit(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Option<Isometry3<f64>> {
    #[expect(clippy::cast_precision_loss, reason = "a handful of stations")]
    let mean = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (from_mean, to_mean) = (mean(from), mean(to));
    let pairs = from.iter().zip(to);
    let scatter: Matrix3<f64> =
        pairs.map(|(f, t)| (t - to_mean) * (f - from_mean).transpose()).sum();
    let svd = scatter.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let sign = if (u * v_t).determinant() < 0.0 { -1.0 } else { 1.0 };
    let mut turn = Matrix3::identity();
    turn[(2, 2)] = sign;
    let rotation = Rotation3::from_matrix_unchecked(u * turn * v_t);
    let translation = to_mean - rotation * from_mean;
    Some(Isometry3::from_parts(translation.into(), rotation.into()))
}

/// The six rigid motions of the stations about their centroid, `3n × 6`.
fn rigid_motions(points_mm: &[Point3<f64>]) -> DMatrix<f64> {
    let mut motions = DMatrix::zeros(3 * points_mm.len(), 6);
    #[expect(clippy::cast_precision_loss, reason = "a handful of stations")]
    let n = points_mm.len() as f64;
    let centroid = points_mm.iter().map(|p| p.coords).sum::<Vector3<f64>>() / n;
    for (i, point) in points_mm.iter().enumerate() {
        for axis in 0..3 {
            let unit = Vector3::ith(axis, 1.0);
            motions[(3 * i + axis, axis)] = 1.0;
            let turned = unit.cross(&(point.coords - centroid));
            motions.fixed_view_mut::<3, 1>(3 * i, 3 + axis).copy_from(&turned);
        }
    }
    motions
}

/// Coordinates held by the minimal gauge: all of the first station, the second across the line
/// from the first, the third off the plane of the three.
fn three_stations(points_mm: &[Point3<f64>]) -> Result<DMatrix<f64>, TrackerError> {
    let along = points_mm[1] - points_mm[0];
    let normal = along.cross(&(points_mm[2] - points_mm[0]));
    let reach = along.norm() * (points_mm[2] - points_mm[0]).norm();
    if normal.norm() <= SMALLEST_SHARE * reach || reach == 0.0 {
        return Err(TrackerError::CollinearStations);
    }
    let (along, normal) = (along.normalize(), normal.normalize());
    let mut held = DMatrix::zeros(3 * points_mm.len(), 6);
    for axis in 0..3 {
        held[(axis, axis)] = 1.0;
    }
    held.fixed_view_mut::<3, 1>(3, 3).copy_from(&normal);
    held.fixed_view_mut::<3, 1>(3, 4).copy_from(&normal.cross(&along));
    held.fixed_view_mut::<3, 1>(6, 5).copy_from(&normal);
    Ok(held)
}

/// Parameters with a share in the position of a station.
fn moves(basis: &DMatrix<f64>, station: usize) -> Vec<(usize, Vector3<f64>)> {
    let way = |p: usize| basis.fixed_view::<3, 1>(3 * station, p).into_owned();
    (0..basis.ncols()).map(|p| (p, way(p))).filter(|(_, w)| w.norm() > NO_SHARE).collect()
}

/// Orthonormal basis of what is orthogonal to the columns, by Gram-Schmidt on the unit vectors,
/// those that keep most of their length first; and which unit vector each began as.
fn complement(constraints: &DMatrix<f64>) -> Result<(DMatrix<f64>, Vec<usize>), TrackerError> {
    let n = constraints.nrows();
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for column in constraints.column_iter() {
        let left = reject(&basis, &column.normalize());
        let share = left.norm();
        if share.is_nan() || share <= SMALLEST_SHARE {
            return Err(TrackerError::CollinearStations);
        }
        basis.push(left.normalize());
    }
    let held = basis.len();
    let mut units: Vec<usize> = (0..n).collect();
    let mut coordinates = Vec::new();
    while basis.len() < n {
        let unit = |i: usize| DVector::from_fn(n, |row, _| f64::from(u8::from(row == i)));
        let lefts: Vec<_> = units.iter().map(|&i| reject(&basis, &unit(i))).collect();
        let best = (0..units.len())
            .reduce(|a, b| if lefts[b].norm() > lefts[a].norm() + NO_SHARE { b } else { a })
            .expect("fewer vectors than dimensions leave a unit vector");
        basis.push(lefts[best].normalize());
        coordinates.push(units.remove(best));
    }
    let free = &basis[held..];
    let basis = if free.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(free) };
    Ok((basis, coordinates))
}

fn reject(basis: &[DVector<f64>], x: &DVector<f64>) -> DVector<f64> {
    let mut rest = x.clone();
    for _ in 0..2 {
        for b in basis {
            let share = b.dot(&rest);
            rest.axpy(-share, b, 1.0);
        }
    }
    rest
}
