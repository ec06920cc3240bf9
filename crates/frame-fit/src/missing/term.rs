//! What the effects do to a point, and how the prediction changes with their amplitudes.

use std::ops::RangeInclusive;

use geometry::so3;
use nalgebra::{DMatrix, DVector, SMatrix, SVector, Vector3};

use crate::missing::finite_motion::turn;
use crate::motion::{self, axis_pairs};

/// What one effect does.
#[derive(Clone, Debug)]
pub(crate) enum Term<const D: usize> {
    Shift,
    Rotation {
        pivot_mm: SVector<f64, D>,
    },
    /// Along one direction; an amplitude of one mirrors.
    Reflection {
        fixed_mm: SVector<f64, D>,
        normal: SVector<f64, D>,
    },
    Scale {
        fixed_mm: SVector<f64, D>,
    },
    AnisotropicScale {
        fixed_mm: SVector<f64, D>,
    },
    Shear {
        fixed_mm: SVector<f64, D>,
    },
    BadPoint {
        observation: usize,
    },
    /// Time or count since the first point, one per observation.
    Drift {
        elapsed: Vec<f64>,
    },
    /// One at the points of a session, nought elsewhere.
    SessionShift {
        inside: Vec<f64>,
    },
    Sag {
        centroid_mm: SVector<f64, D>,
        level: bool,
    },
    /// Radial and decentring distortion of a planar image, after Brown.
    LensDistortion {
        centre_mm: SVector<f64, D>,
    },
    /// The image plane is tilted.
    Perspective {
        centre_mm: SVector<f64, D>,
    },
    /// All terms of these degrees of each component, positions in units of `reach_mm`.
    PolynomialDistortion {
        degrees: RangeInclusive<i32>,
        centre_mm: SVector<f64, D>,
        reach_mm: f64,
    },
    /// A small rigid motion, in source axes, of every body but the one that the frame goes with.
    BodyMotion(BodyMotion<D>),
    /// Temperature above the reference, one per observation; `constant_mm` is taken out.
    Expansion {
        excess_k: Vec<f64>,
        constant_mm: SVector<f64, D>,
        /// Mean of the excess, where the place that stays as the rest grows is asked for too.
        about_any: Option<f64>,
    },
}

/// Which point moves with which body.
#[derive(Clone, Debug)]
pub(crate) struct BodyMotion<const D: usize> {
    /// Of each observation; `None` where it moves with the frame.
    pub(crate) body: Vec<Option<usize>>,
    /// Centroid of each body that moves.
    pub(crate) pivots_mm: Vec<SVector<f64, D>>,
    /// Name of the body that the frame goes with.
    pub(crate) still: String,
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// It deforms the source frame, before the transform; linear in its amplitudes.
    Source,
    /// It rotates the target frame, after the transform.
    Rotation,
    /// It adds to the target, last of all; linear in its amplitudes.
    Target,
}

impl<const D: usize> Term<D> {
    pub(crate) fn place(&self) -> Place {
        match self {
            Self::Rotation { .. } => Place::Rotation,
            Self::Shift
            | Self::BadPoint { .. }
            | Self::Drift { .. }
            | Self::SessionShift { .. } => Place::Target,
            _ => Place::Source,
        }
    }

    /// Whether the effect can move this observation at all.
    pub(crate) fn touches(&self, observation: usize) -> bool {
        match self {
            Self::BadPoint { observation: bad } => *bad == observation,
            Self::BodyMotion(motion) => motion.body[observation].is_some(),
            _ => true,
        }
    }

    /// [`Term::columns`] at a point that was not measured, of what is affine in the point: at 20 °C
    /// of an expansion. `None` where the effect is no such map, or a rotation.
    pub(crate) fn affine(&self, point_mm: &SVector<f64, D>) -> Option<DMatrix<f64>> {
        match self {
            Self::Shift
            | Self::Reflection { .. }
            | Self::Scale { .. }
            | Self::AnisotropicScale { .. }
            | Self::Shear { .. } => Some(self.columns(0, point_mm)),
            Self::Expansion { constant_mm, about_any, .. } => {
                Some(growing(&-constant_mm, about_any.map(|mean_k| -mean_k)))
            }
            _ => None,
        }
    }

    /// Whether the effect bends the source frame by the place of a point, and is not affine.
    pub(crate) fn distorts(&self) -> bool {
        matches!(
            self,
            Self::LensDistortion { .. }
                | Self::Perspective { .. }
                | Self::PolynomialDistortion { .. }
        )
    }

    /// What a map without the effect leaves out, or when it holds; `None` where it leaves nothing.
    pub(crate) fn condition(&self, subject: &str, driver: Option<&str>) -> Option<String> {
        let left_out = |what: &str| {
            format!("the matrix is that without the {what}, which is in the corrections")
        };
        Some(match self {
            Self::Shift
            | Self::Rotation { .. }
            | Self::Reflection { .. }
            | Self::Scale { .. }
            | Self::AnisotropicScale { .. }
            | Self::Shear { .. } => return None,
            Self::BadPoint { .. } => format!(
                "the matrix is that of the other points; the correction of {subject} is its own error"
            ),
            Self::SessionShift { .. } => {
                format!(
                    "the matrix is that of the others; the shift of {subject} is in the corrections"
                )
            }
            Self::Expansion { .. } if driver.is_none() => {
                format!(
                    "the matrix is that of the others; the growth ({subject}) is in the corrections"
                )
            }
            Self::Drift { .. } => {
                "the matrix holds at the first reading; the drift from then on is \
                                   in the corrections"
                    .to_owned()
            }
            Self::Sag { .. } => left_out("sag"),
            Self::LensDistortion { .. } => left_out("lens distortion"),
            Self::Perspective { .. } => left_out("perspective"),
            Self::PolynomialDistortion { .. } => left_out("polynomial distortion"),
            Self::BodyMotion(motion) => format!(
                "the matrix holds for {}; what has moved against it is in the corrections",
                motion.still
            ),
            Self::Expansion { .. } => format!(
                "the matrix holds at {} = 20 °C; the expansion beyond is in the corrections",
                driver.unwrap_or("a temperature")
            ),
        })
    }

    /// `D × parameters`: what a unit of each amplitude adds to a point.
    ///
    /// A rotation is not linear in its amplitudes and has no columns here.
    pub(crate) fn columns(&self, observation: usize, point_mm: &SVector<f64, D>) -> DMatrix<f64> {
        match self {
            Self::Rotation { .. } => DMatrix::zeros(D, 0),
            Self::Shift => DMatrix::identity(D, D),
            Self::Drift { elapsed: size } | Self::SessionShift { inside: size } => {
                DMatrix::identity(D, D) * size[observation]
            }
            Self::BadPoint { observation: bad } => {
                DMatrix::identity(D, D) * f64::from(u8::from(observation == *bad))
            }
            Self::Reflection { fixed_mm, normal } => {
                column(&(normal * (-2.0 * (point_mm - fixed_mm).dot(normal))))
            }
            Self::Scale { fixed_mm } => column(&(point_mm - fixed_mm)),
            Self::AnisotropicScale { fixed_mm } => {
                let arm_mm = point_mm - fixed_mm;
                DMatrix::from_fn(D, D, |i, j| if i == j { arm_mm[i] } else { 0.0 })
            }
            Self::Shear { fixed_mm } => shear(&(point_mm - fixed_mm)),
            Self::Sag { centroid_mm, level } => sag(&(point_mm - centroid_mm), *level),
            Self::LensDistortion { centre_mm } => lens(&(point_mm - centre_mm)),
            Self::Perspective { centre_mm } => {
                let arm_mm = point_mm - centre_mm;
                DMatrix::from_fn(D, D, |row, k| arm_mm[row] * arm_mm[k])
            }
            Self::PolynomialDistortion { degrees, centre_mm, reach_mm } => {
                polynomial(degrees, &((point_mm - centre_mm) / *reach_mm))
            }
            Self::BodyMotion(motion) => motion.columns(observation, point_mm),
            Self::Expansion { excess_k, constant_mm, about_any } => {
                let excess_k = excess_k[observation];
                let growth_mm = point_mm * excess_k - constant_mm;
                growing(&growth_mm, about_any.map(|mean_k| excess_k - mean_k))
            }
        }
    }
}

fn column<const D: usize>(vector: &SVector<f64, D>) -> DMatrix<f64> {
    DMatrix::from_column_slice(D, 1, vector.as_slice())
}

/// What a growth does, and where asked for a shift along every axis.
fn growing<const D: usize>(growth_mm: &SVector<f64, D>, shift: Option<f64>) -> DMatrix<f64> {
    let shifts = shift.map(|shift| DMatrix::identity(D, D) * shift);
    let width = shifts.as_ref().map_or(0, DMatrix::ncols);
    let mut columns = column(growth_mm).resize_horizontally(1 + width, 0.0);
    if let Some(shifts) = shifts {
        columns.columns_mut(1, width).copy_from(&shifts);
    }
    columns
}

/// `x += γ_xy y + γ_xz z, y += γ_yz z`: the first axis is the reference of squareness, and a
/// positive angle closes the right angle.
fn shear<const D: usize>(arm_mm: &SVector<f64, D>) -> DMatrix<f64> {
    let pairs: Vec<_> = axis_pairs(D).collect();
    DMatrix::from_fn(D, pairs.len(), |row, k| {
        let (first, second) = pairs[k];
        if row == first { arm_mm[second] } else { 0.0 }
    })
}

/// Downwards, which is −z (planar: −y), by x², xy and y² (planar: x²), by x and y, and by a
/// constant.
fn sag<const D: usize>(arm_mm: &SVector<f64, D>, level: bool) -> DMatrix<f64> {
    let x = arm_mm[0];
    let mut depths =
        if D == 2 { vec![x * x] } else { vec![x * x, x * arm_mm[1], arm_mm[1] * arm_mm[1]] };
    depths.extend(arm_mm.iter().take(D - 1));
    if level {
        depths.push(1.0);
    }
    DMatrix::from_fn(D, depths.len(), |row, k| if row == D - 1 { -depths[k] } else { 0.0 })
}

/// Brown's radial term of third order, `u·|u|²`, and his decentring terms
/// `(r² + 2x², 2xy)` and `(2xy, r² + 2y²)`.
fn lens<const D: usize>(arm_mm: &SVector<f64, D>) -> DMatrix<f64> {
    let square = arm_mm.norm_squared();
    DMatrix::from_fn(D, 1 + D, |row, k| match k {
        0 => arm_mm[row] * square,
        k => {
            let own = if row == k - 1 { square } else { 0.0 };
            own + 2.0 * arm_mm[row] * arm_mm[k - 1]
        }
    })
}

/// Monomials in the first two coordinates, for each of the two components.
fn polynomial<const D: usize>(degrees: &RangeInclusive<i32>, at: &SVector<f64, D>) -> DMatrix<f64> {
    let values: Vec<f64> = exponents(degrees).map(|(i, j)| at[0].powi(i) * at[1].powi(j)).collect();
    let n = values.len();
    DMatrix::from_fn(D, 2 * n, |row, k| if k / n == row { values[k % n] } else { 0.0 })
}

/// Exponents of x and y in the polynomial distortion, in the order of its columns.
pub(crate) fn exponents(degrees: &RangeInclusive<i32>) -> impl Iterator<Item = (i32, i32)> {
    degrees.clone().flat_map(|degree| (0..=degree).map(move |j| (degree - j, j)))
}

impl<const D: usize> BodyMotion<D> {
    /// Translation and small rotation of each body that moves, one after the other.
    fn columns(&self, observation: usize, point_mm: &SVector<f64, D>) -> DMatrix<f64> {
        let turns: Vec<_> = axis_pairs(D).collect();
        let each = D + turns.len();
        let mut columns = DMatrix::zeros(D, each * self.pivots_mm.len());
        let Some(body) = self.body[observation] else { return columns };
        let arm_mm = point_mm - self.pivots_mm[body];
        for axis in 0..D {
            columns[(axis, each * body + axis)] = 1.0;
        }
        // A turn from the first axis of a pair towards the second.
        for (k, (first, second)) in turns.into_iter().enumerate() {
            columns[(first, each * body + D + k)] = -arm_mm[second];
            columns[(second, each * body + D + k)] = arm_mm[first];
        }
        columns
    }
}

/// Rotation of the effect at `amplitude`, a rotation vector (planar: one angle).
pub(crate) fn rotation_vector<const D: usize>(amplitude: &DVector<f64>) -> Vector3<f64> {
    if D == 2 {
        Vector3::new(0.0, 0.0, amplitude[0])
    } else {
        Vector3::new(amplitude[0], amplitude[1], amplitude[2])
    }
}

/// That rotation less identity.
pub(crate) fn rotation_strain<const D: usize>(amplitude: &DVector<f64>) -> SMatrix<f64, D, D> {
    motion::rotation_strain(&rotation_vector::<D>(amplitude))
}

/// `D × parameters` derivative of the rotated arm.
pub(crate) fn rotation_columns<const D: usize>(
    amplitude: &DVector<f64>,
    rotated_mm: &SVector<f64, D>,
) -> DMatrix<f64> {
    let left_jacobian = so3::left_jacobian(&rotation_vector::<D>(amplitude));
    let first = if D == 2 { 2 } else { 0 };
    let mut columns = DMatrix::zeros(D, 3 - first);
    for (axis, mut column) in (first..3).zip(columns.column_iter_mut()) {
        column.copy_from(&(turn::<D>(&left_jacobian, axis) * rotated_mm));
    }
    columns
}
