//! Errors of the part's form: by how much the real surface is higher than the nominal one.

use nalgebra::{DMatrix, Point3};

use super::columns::as_f64;
use crate::nominal::NominalFoot;

/// Root mean square height at the touches, for a unit at the rim, from which an amplitude can be
/// told: below it, a hundredth of a millimetre that they show would be more than one of form.
/// Smaller shares of a motion are none.
const SEEN: f64 = 0.01;

/// A family of errors of form, with one amplitude per column, mm at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// `ρ²`: more or less curved all round.
    Power,
    /// `ρ² cos 2θ, ρ² sin 2θ`: bent like a saddle.
    Astigmatism,
    /// `(3ρ³ − 2ρ) cos θ, …`: one side higher.
    Coma,
    /// `ρ³ cos 3θ, ρ³ sin 3θ`: three lobes.
    Trefoil,
    /// Harmonics of degree two about a centre: an ellipsoid.
    Ellipsoid,
    /// Harmonics of degree three about a centre, three lobes among them.
    Lobes,
}

/// Unit in which a place on the part is measured: from a centre, and by what length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FormScale {
    pub(crate) center_mm: Point3<f64>,
    pub(crate) radius_mm: f64,
}

impl Form {
    /// Those of a graph over xy.
    pub(crate) const OVER: [Self; 4] = [Self::Power, Self::Astigmatism, Self::Coma, Self::Trefoil];
    /// Those of a sphere.
    pub(crate) const AROUND: [Self; 2] = [Self::Ellipsoid, Self::Lobes];

    /// Id of the effect, and its subject: what other kinds have too is named as there.
    pub(crate) fn id(self) -> (&'static str, Option<&'static str>) {
        if Self::OVER.contains(&self) { (self.name(), None) } else { ("form", Some(self.name())) }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Power => "focus",
            Self::Astigmatism => "astigmatism",
            Self::Coma => "coma",
            Self::Trefoil => "trefoil",
            Self::Ellipsoid => "ellipsoid",
            Self::Lobes => "lobes",
        }
    }

    pub(crate) fn description(self) -> &'static str {
        match self {
            Self::Power => "the part is more curved all round than drawn; height at the rim",
            Self::Astigmatism => "the part is bent like a saddle; height at the rim",
            Self::Coma => "one side of the part is higher; height at the rim",
            Self::Trefoil => "the part is bent with three lobes; height at the rim",
            Self::Ellipsoid => "the part is an ellipsoid rather than a sphere",
            Self::Lobes => "the part has lobes of the third degree",
        }
    }

    /// Names of the amplitudes.
    pub(crate) fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::Power => &["height"],
            Self::Astigmatism | Self::Coma | Self::Trefoil => &["cos", "sin"],
            Self::Ellipsoid => &["xx − yy", "xy", "xz", "yz", "zz"],
            Self::Lobes => &["3 cos", "3 sin", "2 cos z", "2 sin z", "cos zz", "sin zz", "zzz"],
        }
    }

    /// The amplitudes that touches with these feet tell from another place and size of the part.
    pub(crate) fn seen(self, scale: &FormScale, feet: &[NominalFoot]) -> Vec<usize> {
        let amplitudes = self.parameters().len();
        let rows: Vec<Vec<f64>> =
            feet.iter().map(|foot| self.heights(scale, &foot.point_mm)).collect();
        let heights = DMatrix::from_fn(feet.len(), amplitudes, |i, k| rows[i][k]);
        let placed =
            DMatrix::from_fn(feet.len(), 4, |i, k| if k < 3 { feet[i].normal[k] } else { 1.0 });
        let svd = placed.svd(true, false);
        let mut left = heights;
        for (u, size) in svd.u.iter().flat_map(|u| u.column_iter()).zip(&svd.singular_values) {
            if *size > SEEN * svd.singular_values.max() {
                left -= u * (u.transpose() * &left);
            }
        }
        let least = SEEN * as_f64(feet.len()).sqrt();
        (0..amplitudes).filter(|&k| left.column(k).norm() > least).collect()
    }

    /// What a unit of each amplitude adds to the height at a nominal point, along the normal.
    pub(crate) fn heights(self, scale: &FormScale, point_mm: &Point3<f64>) -> Vec<f64> {
        let arm = (point_mm - scale.center_mm) / scale.radius_mm;
        let [x, y, z] = [arm.x, arm.y, arm.z];
        let square = x * x + y * y;
        match self {
            Self::Power => vec![square],
            Self::Astigmatism => vec![x * x - y * y, 2.0 * x * y],
            Self::Coma => vec![(3.0 * square - 2.0) * x, (3.0 * square - 2.0) * y],
            Self::Trefoil => vec![x * (x * x - 3.0 * y * y), y * (3.0 * x * x - y * y)],
            Self::Ellipsoid => {
                vec![x * x - y * y, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z, 1.5 * z * z - 0.5]
            }
            Self::Lobes => vec![
                x * (x * x - 3.0 * y * y),
                y * (3.0 * x * x - y * y),
                z * (x * x - y * y),
                2.0 * x * y * z,
                x * (5.0 * z * z - 1.0),
                y * (5.0 * z * z - 1.0),
                z * (2.5 * z * z - 1.5),
            ],
        }
    }
}
