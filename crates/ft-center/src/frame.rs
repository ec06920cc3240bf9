//! Planar frame between machine and sensor: (1.12) to (1.14) of \[A\].

use geometry::PlanarMap;
use least_squares::{Options, Problem, covariance};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix2x3, Matrix3, Point2, Rotation2, Vector2};

use crate::FtCenterError;
use crate::frame_point::{FramePoint, check_points, whitening};

/// How many times better one handedness must fit, in mean square, to count as measured.
const DECIDED_RATIO: f64 = 10.0;

/// Steps of the angle under this are round-off.
const SETTLED_RAD: f64 = 1e-14;

/// Steps that polish the angle; two are enough, the others are there for covariances of very different size.
const MAX_POLISHING: usize = 8;

/// Halvings that exhaust the digits of a number.
const MAX_HALVINGS: usize = 1100;

/// Standard uncertainty of the angle beyond which the frame is not determined: past it the
/// covariance, which is first order, says nothing.
pub(crate) const MAX_ANGLE_STD_RAD: f64 = 0.3;

/// Whether the sensor's z points the way the machine's does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Handedness {
    /// z axes agree: the planar map is a rotation.
    Same,
    /// z axes oppose each other: the planar map is a reflection.
    Opposed,
}

/// How the handedness of a frame is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum HandednessSource {
    /// The points fit one and miss the other.
    Measured,
    /// Given by the caller.
    Given,
    /// The points, two or on one line, fit both alike: z axes are taken to agree.
    Assumed,
}

/// Rigid planar frame of the sensor in the machine.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorFrame {
    /// Angle θ of `sensor = Rot(θ) · Mirror · machine + translation`; Mirror is diag(1, −1)
    /// where the z axes oppose each other.
    pub angle_rad: f64,
    /// Translation of the same map: the machine's origin in the sensor frame.
    pub translation_mm: Vector2<f64>,
    /// Whether the map reflects.
    pub handedness: Handedness,
    /// How that is known.
    pub handedness_source: HandednessSource,
    /// Root mean square miss of the best frame of the other handedness.
    pub other_handedness_rms_mm: f64,
    /// Covariance of `[angle_rad, pivot x, pivot y]` for the given point covariances; rad², mm.
    ///
    /// The pivot is the image of `pivot_mm`; about it the angle moves nothing, so that far away
    /// origins do no harm.
    pub covariance: Matrix3<f64>,
    /// Weighted centroid of the machine positions.
    pub pivot_mm: Point2<f64>,
    /// Sensor position found − position predicted, sensor frame, in input order.
    pub residuals_mm: Vec<Vector2<f64>>,
    /// `2 n − 3`.
    pub degrees_of_freedom: usize,
    /// Weighted sum of squares over `degrees_of_freedom`; near 1 when the covariances are honest.
    pub variance_factor: f64,
}

impl Handedness {
    /// diag(1, 1) or diag(1, −1), applied to machine coordinates.
    pub(crate) fn mirror(self) -> Matrix2<f64> {
        let y = if self == Self::Opposed { -1.0 } else { 1.0 };
        Matrix2::from_diagonal(&Vector2::new(1.0, y))
    }
}

impl SensorFrame {
    /// The map from machine to sensor coordinates, the direction of \[A\].
    #[must_use]
    pub fn sensor_from_machine(&self) -> PlanarMap {
        PlanarMap::rigid(
            self.angle_rad,
            self.handedness == Handedness::Opposed,
            self.translation_mm,
        )
    }

    /// The map from sensor to machine coordinates.
    #[must_use]
    pub fn machine_from_sensor(&self) -> PlanarMap {
        let there = self.sensor_from_machine();
        let linear = there.linear.transpose();
        PlanarMap { linear, translation_mm: -(linear * there.translation_mm) }
    }

    /// Derivative of a machine position's image by the parameters of `covariance`.
    pub(crate) fn position_jacobian(&self, machine_mm: &Point2<f64>) -> Matrix2x3<f64> {
        let arm = self.sensor_from_machine().linear * (machine_mm - self.pivot_mm);
        Matrix2x3::new(-arm.y, 1.0, 0.0, arm.x, 0.0, 1.0)
    }
}

/// Fits the rigid frame to two or more points; more than two, off one line, tell a reflection.
///
/// Two points determine it with one degree of freedom left, their distance. `handedness` holds
/// it where it is known; `None` lets the points decide.
///
/// # Errors
///
/// [`FtCenterError::TooFewFramePoints`], [`FtCenterError::CoincidentPoints`],
/// [`FtCenterError::AngleFree`], [`FtCenterError::NotFinite`], [`FtCenterError::InvalidCovariance`],
/// [`FtCenterError::OutOfRange`].
pub fn fit_sensor_frame(
    points: &[FramePoint],
    handedness: Option<Handedness>,
) -> Result<SensorFrame, FtCenterError> {
    let spread_mm = check_points(points, 2)?;
    let same = Start::closed_form(points, Handedness::Same);
    let opposed = Start::closed_form(points, Handedness::Opposed);
    let degrees_of_freedom = 2 * points.len() - 3;
    let (start, other, source) = match handedness {
        Some(Handedness::Same) => (same, opposed, HandednessSource::Given),
        Some(Handedness::Opposed) => (opposed, same, HandednessSource::Given),
        None => decide(same, opposed),
    };
    let problem = FrameProblem::new(points, start)?;
    let (point, residuals) = problem.minimise()?;
    let covariance = covariance(&problem, &point, &Options::default()).map_err(Box::new)?.matrix;
    let [angle_rad, x_mm, y_mm] = [point[0], point[1], point[2]];
    let covariance = covariance.fixed_view::<3, 3>(0, 0).into_owned();
    let std_angle_rad = covariance[(0, 0)].sqrt();
    if std_angle_rad > MAX_ANGLE_STD_RAD {
        return Err(FtCenterError::AngleFree { std_angle_rad, spread_mm });
    }
    let rotated =
        PlanarMap::rigid(angle_rad, start.handedness == Handedness::Opposed, Vector2::zeros());
    let translation_mm = Vector2::new(x_mm, y_mm) - rotated.linear * start.pivot_mm.coords;
    let mut frame = SensorFrame {
        angle_rad: wrapped(angle_rad),
        translation_mm,
        handedness: start.handedness,
        handedness_source: source,
        other_handedness_rms_mm: other.rms_mm,
        covariance,
        pivot_mm: start.pivot_mm,
        residuals_mm: Vec::new(),
        degrees_of_freedom,
        variance_factor: residuals.norm_squared() / crate::count(degrees_of_freedom),
    };
    let there = frame.sensor_from_machine();
    let numbers = there.linear.iter().chain(there.translation_mm.iter());
    if !numbers.chain([&frame.variance_factor]).all(|v| v.is_finite()) {
        return Err(FtCenterError::OutOfRange);
    }
    frame.residuals_mm = points.iter().map(|p| p.sensor_mm - there.apply(&p.machine_mm)).collect();
    Ok(frame)
}

/// Which handedness fits, and whether the points really tell.
fn decide(same: Start, opposed: Start) -> (Start, Start, HandednessSource) {
    let (better, worse) =
        if opposed.rms_mm < same.rms_mm { (opposed, same) } else { (same, opposed) };
    // Two points, or points on one line, are their own mirror image up to round-off.
    let told = worse.rms_mm.powi(2) > DECIDED_RATIO * better.rms_mm.powi(2)
        && worse.rms_mm > MIN_MIRROR_RATIO * better.size_mm;
    if told {
        (better, worse, HandednessSource::Measured)
    } else {
        (same, opposed, HandednessSource::Assumed)
    }
}

/// Miss of the worse handedness, as a share of the points' spread, that is no round-off.
const MIN_MIRROR_RATIO: f64 = 1e-6;

/// Angle from −π to π.
fn wrapped(angle_rad: f64) -> f64 {
    let (sin, cos) = angle_rad.sin_cos();
    sin.atan2(cos)
}

/// The unit vector `u` of least `|matrix u − aim|`; `None` where all are alike.
///
/// In the axes of the matrix the condition is one equation in the multiplier of `|u| = 1`, monotonous above the
/// smaller singular value squared, where the least of all minima lies.
fn closest_direction(matrix: &Matrix2<f64>, aim: &Vector2<f64>) -> Option<Vector2<f64>> {
    let svd = matrix.svd(true, true);
    let (left, right) = (svd.u?, svd.v_t?);
    let [large, small] = [svd.singular_values[0], svd.singular_values[1]];
    let toward = (left.transpose() * aim).component_mul(&svd.singular_values);
    let beyond = (large - small) * (large + small);
    let too_long =
        |multiplier: f64| (toward.x / (beyond + multiplier)).hypot(toward.y / multiplier) > 1.0;
    let (mut low, mut high) = (toward.y.abs(), toward.norm());
    for _ in 0..MAX_HALVINGS {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            break;
        }
        *(if too_long(middle) { &mut low } else { &mut high }) = middle;
    }
    let along = (toward.x / (beyond + high)).clamp(-1.0, 1.0);
    let across = (1.0 - along * along).sqrt().copysign(toward.y);
    let found = right.transpose() * Vector2::new(along, across);
    found.iter().all(|v| v.is_finite()).then_some(found)
}

/// Closed-form frame with one weight per point, where the search starts.
#[derive(Clone, Copy, Debug)]
struct Start {
    handedness: Handedness,
    pivot_mm: Point2<f64>,
    /// Angle, image of the pivot.
    point: [f64; 3],
    rms_mm: f64,
    /// Root mean square distance from the pivot.
    size_mm: f64,
}

impl Start {
    fn closed_form(points: &[FramePoint], handedness: Handedness) -> Self {
        let weight = |p: &FramePoint| 1.0 / p.covariance_mm2.trace();
        let total: f64 = points.iter().map(weight).sum();
        let mean = |of: fn(&FramePoint) -> Vector2<f64>| {
            points.iter().map(|p| of(p) * weight(p)).sum::<Vector2<f64>>() / total
        };
        let (machine, sensor) = (mean(|p| p.machine_mm.coords), mean(|p| p.sensor_mm.coords));
        let mirror = handedness.mirror();
        let (mut along, mut across, mut size) = (0.0, 0.0, 0.0);
        for p in points {
            let from = mirror * (p.machine_mm.coords - machine);
            let to = p.sensor_mm.coords - sensor;
            along += weight(p) * from.dot(&to);
            across += weight(p) * from.perp(&to);
            size += from.norm_squared();
        }
        let angle_rad = across.atan2(along);
        let turn = Rotation2::new(angle_rad).into_inner() * mirror;
        let miss = |p: &FramePoint| {
            (p.sensor_mm.coords - sensor - turn * (p.machine_mm.coords - machine)).norm_squared()
        };
        let n = crate::count(points.len());
        Self {
            handedness,
            pivot_mm: Point2::from(machine),
            point: [angle_rad, sensor.x, sensor.y],
            rms_mm: (points.iter().map(miss).sum::<f64>() / n).sqrt(),
            size_mm: (size / n).sqrt(),
        }
    }
}

/// Whitened misses over angle and image of the pivot.
struct FrameProblem<'a> {
    points: &'a [FramePoint],
    whitening: Vec<Matrix2<f64>>,
    start: Start,
}

impl<'a> FrameProblem<'a> {
    fn new(points: &'a [FramePoint], start: Start) -> Result<Self, FtCenterError> {
        Ok(Self { points, whitening: whitening(points)?, start })
    }

    /// The best angle of all, and the image of the pivot that belongs to it.
    ///
    /// The misses are linear in `(cos θ, sin θ)` and in the image, so that the best angle is the point of a
    /// circle that is closest to a linear system: found whatever the covariances are, and however far the
    /// points miss. Steps of Newton from there give back the digits that the circle cost.
    fn minimise(&self) -> Result<(DVector<f64>, DVector<f64>), FtCenterError> {
        let rows = self.residual_count();
        let (mut residuals, mut jacobian) = (DVector::zeros(rows), DMatrix::zeros(rows, 3));
        let mut point = DVector::from_column_slice(&self.start.point);
        point[0] = self.best_angle_rad();
        let mut before_rad = f64::INFINITY;
        for _ in 0..MAX_POLISHING {
            self.residuals(&point, &mut residuals);
            self.jacobian(&point, &mut jacobian);
            let qr = jacobian.clone().qr();
            let downhill = qr.q().transpose() * &residuals;
            let r = qr.r();
            let mut step = r.solve_upper_triangular(&-downhill).ok_or(FtCenterError::OutOfRange)?;
            self.curve(&point, &residuals, &r, &mut step);
            if !step.iter().all(|s| s.is_finite()) {
                return Err(FtCenterError::OutOfRange);
            }
            let step_rad = step[0].abs();
            point += step;
            if step_rad <= SETTLED_RAD || step_rad >= before_rad {
                break;
            }
            before_rad = step_rad;
        }
        self.residuals(&point, &mut residuals);
        Ok((point, residuals))
    }

    /// The angle whose `(cos θ, sin θ)` misses least once the image of the pivot is free.
    fn best_angle_rad(&self) -> f64 {
        let mut system = DMatrix::zeros(self.residual_count(), 5);
        for (i, p) in self.points.iter().enumerate() {
            let (arm, whitening) = (self.arm(i), &self.whitening[i]);
            let to = p.sensor_mm.coords - Vector2::new(self.start.point[1], self.start.point[2]);
            let mut row = system.fixed_view_mut::<2, 5>(2 * i, 0);
            row.fixed_columns_mut::<2>(0).copy_from(whitening);
            row.set_column(2, &(whitening * arm));
            row.set_column(3, &(whitening * Vector2::new(-arm.y, arm.x)));
            row.set_column(4, &(whitening * to));
        }
        let r = system.qr().r();
        let (matrix, aim) = (r.fixed_view::<2, 2>(2, 2), r.fixed_view::<2, 1>(2, 4));
        let direction = closest_direction(&matrix.into_owned(), &aim.into_owned());
        direction.map_or(self.start.point[0], |u| u.y.atan2(u.x))
    }

    /// Turns a step of Gauss and Newton, whose normal matrix has the factor `r`, into one of Newton: where
    /// points miss by a good part of their distances, the first goes on for ever.
    fn curve(
        &self,
        at: &DVector<f64>,
        residuals: &DVector<f64>,
        r: &DMatrix<f64>,
        step: &mut DVector<f64>,
    ) {
        let turn = Rotation2::new(at[0]);
        let bent = |i: usize| {
            let miss = residuals.fixed_rows::<2>(2 * i);
            miss.dot(&(self.whitening[i] * (turn * self.arm(i))))
        };
        let curvature: f64 = (0..self.points.len()).map(bent).sum();
        let of_angle = DVector::from_vec(vec![1.0, 0.0, 0.0]);
        let column = (r.tr_solve_upper_triangular(&of_angle))
            .and_then(|half| r.solve_upper_triangular(&half));
        let Some(column) = column else { return };
        let ratio = 1.0 + curvature * column[0];
        // At the best angle the cost is a bowl; by round-off alone it is none.
        if ratio > 0.0 {
            *step -= column * (curvature * step[0] / ratio);
        } else {
            step.fill(0.0);
        }
    }

    fn arm(&self, i: usize) -> Vector2<f64> {
        self.start.handedness.mirror() * (self.points[i].machine_mm - self.start.pivot_mm)
    }
}

impl Problem for FrameProblem<'_> {
    type Point = DVector<f64>;

    fn residual_count(&self) -> usize {
        2 * self.points.len()
    }

    fn tangent_dim(&self) -> usize {
        3
    }

    fn residuals(&self, at: &DVector<f64>, out: &mut DVector<f64>) {
        let turn = Rotation2::new(at[0]);
        for (i, p) in self.points.iter().enumerate() {
            let predicted = turn * self.arm(i) + Vector2::new(at[1], at[2]);
            let miss = self.whitening[i] * (p.sensor_mm.coords - predicted);
            out.fixed_rows_mut::<2>(2 * i).copy_from(&miss);
        }
    }

    fn jacobian(&self, at: &DVector<f64>, out: &mut DMatrix<f64>) {
        let turn = Rotation2::new(at[0] + std::f64::consts::FRAC_PI_2);
        for i in 0..self.points.len() {
            let mut row = out.fixed_view_mut::<2, 3>(2 * i, 0);
            row.set_column(0, &(-self.whitening[i] * (turn * self.arm(i))));
            row.fixed_columns_mut::<2>(1).copy_from(&-self.whitening[i]);
        }
    }

    fn retract(&self, at: &DVector<f64>, step: &DVector<f64>) -> DVector<f64> {
        at + step
    }

    fn parameter_name(&self, index: usize) -> String {
        ["frame angle (rad)", "frame translation x (mm)", "frame translation y (mm)"][index].into()
    }
}
