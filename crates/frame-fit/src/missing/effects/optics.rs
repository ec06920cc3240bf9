//! What a camera or another planar imager does to a frame.

use std::ops::RangeInclusive;

use model_discrepancy::Role;

use super::{AXES, Entry, entry, parameter};
use crate::MeasuredPoint;
use crate::missing::term::{Term, exponents};
use crate::spread::Spread;

/// Points per parameter below which a field of many terms is not offered.
const POINTS_PER_PARAMETER: usize = 3;

/// Distortions of a planar image about the centroid of the points; none in space.
pub(super) fn distortions<const D: usize>(
    points: &[MeasuredPoint<D>],
    spread: &Spread<D>,
) -> Vec<Entry<D>> {
    if D != 2 {
        return Vec::new();
    }
    let centre_mm = spread.centroid_mm.coords;
    let mut entries = vec![
        entry(
            "lens-distortion",
            "the image is distorted radially and by decentred lenses, about its centroid",
            // 1/mm² is a million 1/m², 1/mm a thousand 1/m.
            std::iter::once(parameter("k1", "1/m²", 1e6))
                .chain((1..=D).map(|k| parameter(format!("p{k}"), "1/m", 1e3)))
                .collect(),
            Term::LensDistortion { centre_mm },
        ),
        entry(
            "perspective",
            "the image plane is tilted against the object: scale changes across the image",
            AXES[..D].iter().map(|axis| parameter(*axis, "1/m", 1e3)).collect(),
            Term::Perspective { centre_mm },
        ),
    ];
    let fitted = points.iter().filter(|p| p.role == Role::Fit).count();
    let fields = [2..=3, 4..=5].map(|degrees| polynomial_distortion(degrees, spread));
    let enough = |e: &Entry<D>| fitted >= POINTS_PER_PARAMETER * e.effect.parameters.len();
    entries.extend(fields.into_iter().filter(enough));
    entries
}

fn polynomial_distortion<const D: usize>(
    degrees: RangeInclusive<i32>,
    spread: &Spread<D>,
) -> Entry<D> {
    let name = |component: &str, (i, j): (i32, i32)| {
        let powers = [("x", i), ("y", j)].into_iter().filter(|(_, power)| *power > 0);
        let monomial: Vec<String> = powers
            .map(
                |(axis, power)| {
                    if power == 1 { axis.to_owned() } else { format!("{axis}^{power}") }
                },
            )
            .collect();
        format!("{component} {}", monomial.join(" "))
    };
    let parameters = (AXES[..2].iter())
        .flat_map(|component| exponents(&degrees).map(|d| name(component, d)).collect::<Vec<_>>())
        .map(|name| parameter(name, "mm", 1.0))
        .collect();
    let text = format!(
        "the image is distorted by a smooth field: all terms of degree {} and {}, at the rms \
         distance from the centroid",
        degrees.start(),
        degrees.end()
    );
    let subject = format!("degree {}", degrees.end());
    let term = Term::PolynomialDistortion {
        degrees,
        centre_mm: spread.centroid_mm.coords,
        reach_mm: spread.rms_mm.norm(),
    };
    let mut entry = entry("polynomial-distortion", &text, parameters, term);
    entry.effect.subject = Some(subject);
    entry
}
