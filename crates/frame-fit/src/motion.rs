//! The parameters of a transform: small motions about a pivot in the target frame.

use geometry::so3;
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};

use crate::{FrameMap, Transform};

/// One parameter of a transform: what the points do when it grows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Motion {
    Translation(usize),
    Rotation(usize),
    Scale,
    Stretch(usize),
    /// By how much the right angle between two axes closes.
    Shear(usize, usize),
}

const AXIS_PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Pairs of axes, `[xy]` planar and `[xy, xz, yz]` spatial.
pub(crate) fn axis_pairs(dimension: usize) -> impl Iterator<Item = (usize, usize)> {
    AXIS_PAIRS.into_iter().filter(move |&(_, second)| second < dimension)
}

/// Parameters of a family, in the order of every vector and matrix of parameters.
pub(crate) fn motions(transform: Transform, dimension: usize) -> Vec<Motion> {
    let mut all = Vec::with_capacity(transform.parameter_count(dimension));
    if transform.has_translation() {
        all.extend((0..dimension).map(Motion::Translation));
    }
    if transform.has_rotation() {
        let first = if dimension == 2 { 2 } else { 0 };
        all.extend((first..3).map(Motion::Rotation));
    }
    match transform {
        Transform::Similarity => all.push(Motion::Scale),
        Transform::Affine => {
            all.extend((0..dimension).map(Motion::Stretch));
            all.extend(axis_pairs(dimension).map(|(a, b)| Motion::Shear(a, b)));
        }
        _ => {}
    }
    all
}

impl Motion {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Translation(axis) => ["tx", "ty", "tz"][axis],
            Self::Rotation(axis) => ["rx", "ry", "rz"][axis],
            Self::Scale => "scale",
            Self::Stretch(axis) => ["scale_x", "scale_y", "scale_z"][axis],
            Self::Shear(a, b) => match (a, b) {
                (0, 1) => "shear_xy",
                (0, 2) => "shear_xz",
                _ => "shear_yz",
            },
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Translation(_) => "mm",
            Self::Rotation(_) | Self::Shear(..) => "rad",
            Self::Scale | Self::Stretch(_) => "1",
        }
    }

    pub(crate) fn is_translation(self) -> bool {
        matches!(self, Self::Translation(_))
    }

    /// `∂y/∂parameter` of a point at `arm_mm` from the pivot, at parameters zero.
    pub(crate) fn displacement<const D: usize>(self, arm_mm: &SVector<f64, D>) -> SVector<f64, D> {
        let mut moved = SVector::<f64, D>::zeros();
        match self {
            Self::Translation(axis) => moved[axis] = 1.0,
            Self::Rotation(axis) => {
                let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
                // e × arm, of which a planar arm has no z.
                if j < D {
                    moved[i] = -arm_mm[j];
                }
                if i < D && j < D {
                    moved[j] = arm_mm[i];
                }
            }
            Self::Scale => moved.copy_from(arm_mm),
            Self::Stretch(axis) => moved[axis] = arm_mm[axis],
            Self::Shear(a, b) => {
                moved[a] = 0.5 * arm_mm[b];
                moved[b] = 0.5 * arm_mm[a];
            }
        }
        moved
    }

    /// The matrix that takes the arm to the displacement; zero for a translation.
    pub(crate) fn strain<const D: usize>(self) -> SMatrix<f64, D, D> {
        let mut strain = SMatrix::<f64, D, D>::zeros();
        if !self.is_translation() {
            for k in 0..D {
                let mut unit = SVector::zeros();
                unit[k] = 1.0;
                strain.set_column(k, &self.displacement::<D>(&unit));
            }
        }
        strain
    }
}

/// `∂y/∂parameters` at zero, `D × parameters`.
pub(crate) fn jacobian<const D: usize>(
    motions: &[Motion],
    arm_mm: &SVector<f64, D>,
) -> DMatrix<f64> {
    let mut jacobian = DMatrix::zeros(D, motions.len());
    for (column, motion) in motions.iter().enumerate() {
        jacobian.fixed_view_mut::<D, 1>(0, column).copy_from(&motion.displacement(arm_mm));
    }
    jacobian
}

/// Rotation vector among the parameters; along z when planar.
pub(crate) fn rotation_vector(motions: &[Motion], parameters: &DVector<f64>) -> Vector3<f64> {
    let mut vector = Vector3::zeros();
    for (motion, value) in motions.iter().zip(parameters.iter()) {
        if let Motion::Rotation(axis) = motion {
            vector[*axis] = *value;
        }
    }
    vector
}

/// A finite motion `y ↦ y + shift + strain (y − pivot)`.
///
/// Kept as its difference from standing still, so that a motion of micrometres moves points by
/// micrometres good to all digits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved<const D: usize> {
    pub(crate) strain: SMatrix<f64, D, D>,
    pub(crate) shift_mm: SVector<f64, D>,
}

impl<const D: usize> Moved<D> {
    pub(crate) fn still() -> Self {
        Self { strain: SMatrix::zeros(), shift_mm: SVector::zeros() }
    }

    /// By how much a point at `arm_mm` from the pivot moves.
    pub(crate) fn displacement(&self, arm_mm: &SVector<f64, D>) -> SVector<f64, D> {
        self.shift_mm + self.strain * arm_mm
    }

    /// `self` after `first`, about the same pivot.
    pub(crate) fn after(&self, first: &Self) -> Self {
        Self {
            strain: self.strain + first.strain + self.strain * first.strain,
            shift_mm: self.displacement(&first.shift_mm) + first.shift_mm,
        }
    }

    /// The motion as a map, about `pivot_mm`.
    pub(crate) fn map(&self, pivot_mm: &SVector<f64, D>) -> FrameMap<D> {
        FrameMap {
            linear: SMatrix::identity() + self.strain,
            translation_mm: self.shift_mm - self.strain * pivot_mm,
        }
    }
}

/// `exp(r) − I = [r]× J_l(r)`, without the cancellation; the upper left block when planar.
pub(crate) fn rotation_strain<const D: usize>(rotation_rad: &Vector3<f64>) -> SMatrix<f64, D, D> {
    let strain = rotation_rad.cross_matrix() * so3::left_jacobian(rotation_rad);
    SMatrix::from_fn(|row, column| strain[(row, column)])
}

/// The motion of finite `parameters`.
///
/// `I + strain` is `eˢ exp(r)` for a similarity, `I + [r]× + S` for an affine map; both have the
/// tangent given by [`Motion::displacement`] at zero.
pub(crate) fn finite<const D: usize>(
    transform: Transform,
    motions: &[Motion],
    parameters: &DVector<f64>,
) -> Moved<D> {
    let mut moved = Moved::still();
    let affine = transform == Transform::Affine;
    if transform.has_rotation() && !affine {
        moved.strain = rotation_strain(&rotation_vector(motions, parameters));
    }
    for (motion, &value) in motions.iter().zip(parameters.iter()) {
        match motion {
            Motion::Translation(axis) => moved.shift_mm[*axis] = value,
            Motion::Scale => {
                moved.strain *= value.exp();
                moved.strain += SMatrix::<f64, D, D>::identity() * value.exp_m1();
            }
            Motion::Rotation(_) if !affine => {}
            _ => moved.strain += motion.strain() * value,
        }
    }
    moved
}
