//! Errors of form: by how much the real surface is higher than the nominal one.

use geometry::AsphereShape;
use nalgebra::Point3;

/// A family of surface errors, with one amplitude per column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Form {
    /// Vertex radius longer than declared, mm per mm.
    VertexRadius,
    /// Conic constant larger than declared, mm per unit.
    Conic,
    /// `ρ²`, mm at the rim: what a vertex radius is to a part that has none.
    Focus,
    /// `ρ² cos 2θ, ρ² sin 2θ`, mm at the rim.
    Astigmatism,
    /// `ρ² sin 2(θ + γ)`, mm at the rim: a saddle along the machine's diagonals.
    Diagonal {
        /// The part's rotation, γ.
        gamma_rad: f64,
    },
    /// `(3ρ³ − 2ρ) cos θ, (3ρ³ − 2ρ) sin θ`, mm at the rim.
    Coma,
    /// `ρ³ cos 3θ, ρ³ sin 3θ`, mm at the rim.
    Trefoil,
}

impl Form {
    /// What a unit of each amplitude adds to the height at a point of the surface.
    ///
    /// `radius_mm` is where ρ = 1; the first two need the asphere.
    pub(crate) fn heights(
        self,
        shape: Option<&AsphereShape>,
        radius_mm: f64,
        point_mm: &Point3<f64>,
    ) -> Vec<f64> {
        let (x, y) = (point_mm.x / radius_mm, point_mm.y / radius_mm);
        let square = x * x + y * y;
        match self {
            Self::VertexRadius => shape.map_or_else(Vec::new, |s| vec![by_radius(s, point_mm)]),
            Self::Conic => shape.map_or_else(Vec::new, |s| vec![by_conic(s, point_mm)]),
            Self::Focus => vec![square],
            Self::Astigmatism => vec![x * x - y * y, 2.0 * x * y],
            Self::Diagonal { gamma_rad } => {
                let (sin, cos) = (2.0 * gamma_rad).sin_cos();
                vec![(x * x - y * y) * sin + 2.0 * x * y * cos]
            }
            Self::Coma => vec![(3.0 * square - 2.0) * x, (3.0 * square - 2.0) * y],
            Self::Trefoil => vec![x * (x * x - 3.0 * y * y), y * (3.0 * x * x - y * y)],
        }
    }
}

/// `∂z/∂R`: with c = 1/R and w = √(1 − (1+k) c² s), `∂z/∂c = s/(w (1 + w))`.
fn by_radius(shape: &AsphereShape, point_mm: &Point3<f64>) -> f64 {
    let (s, w, c) = conic(shape, point_mm);
    -c * c * s / (w * (1.0 + w))
}

/// `∂z/∂k = c³ s² / (2 w (1 + w)²)`.
fn by_conic(shape: &AsphereShape, point_mm: &Point3<f64>) -> f64 {
    let (s, w, c) = conic(shape, point_mm);
    c.powi(3) * s * s / (2.0 * w * (1.0 + w).powi(2))
}

fn conic(shape: &AsphereShape, point_mm: &Point3<f64>) -> (f64, f64, f64) {
    let c = shape.radius_mm.recip();
    let s = point_mm.x * point_mm.x + point_mm.y * point_mm.y;
    (s, (1.0 - (1.0 + shape.conic) * c * c * s).max(f64::EPSILON).sqrt(), c)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of powers of numbers near one.
    const EXACT: f64 = 1e-14;

    /// Each is a function of `ρ = r/R` and θ alone, 1 or so at the rim.
    #[test]
    fn heights_are_those_of_the_polynomials() {
        let radius_mm = 40.0;
        for (share, angle) in [(1.0, 0.3), (0.5, 2.1), (0.8, -1.2)] {
            let (rho, angle): (f64, f64) = (share, angle);
            let place = Point3::new(angle.cos(), angle.sin(), 0.0) * (rho * radius_mm);
            let coma = 3.0 * rho.powi(3) - 2.0 * rho;
            let wave = |n: f64, size: f64| vec![size * (n * angle).cos(), size * (n * angle).sin()];
            for (form, expected) in [
                (Form::Focus, vec![rho * rho]),
                (Form::Astigmatism, wave(2.0, rho * rho)),
                (Form::Coma, wave(1.0, coma)),
                (Form::Trefoil, wave(3.0, rho.powi(3))),
                (Form::Diagonal { gamma_rad: 0.4 }, vec![rho * rho * (2.0 * angle + 0.8).sin()]),
            ] {
                let heights = form.heights(None, radius_mm, &place);
                assert_eq!(heights.len(), expected.len());
                for (height, expected) in heights.iter().zip(&expected) {
                    assert!((height - expected).abs() < EXACT, "{form:?}: {height} {expected}");
                }
            }
        }
    }
}
