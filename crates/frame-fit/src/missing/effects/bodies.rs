//! Points on several bodies that move against each other.

use model_discrepancy::Role;
use nalgebra::SVector;

use super::{AXES, Entry, entry, parameter};
use crate::MeasuredPoint;
use crate::missing::term::{BodyMotion, Term};
use crate::motion::axis_pairs;
use crate::statistics::ratio;

/// A rigid motion of every sub-assembly against the one with most points; `None` for one body.
pub(super) fn sub_assembly<const D: usize>(points: &[MeasuredPoint<D>]) -> Option<Entry<D>> {
    let mut named: Vec<(&str, usize)> = Vec::new();
    for point in points.iter().filter(|p| p.role == Role::Fit) {
        let body = point.body.as_deref()?;
        match named.iter_mut().find(|(name, _)| *name == body) {
            Some((_, count)) => *count += 1,
            None => named.push((body, 1)),
        }
    }
    // The first of those with most points.
    let most = named.iter().map(|(_, count)| *count).max()?;
    let reference = named.iter().position(|(_, count)| *count == most)?;
    let still = named.remove(reference).0;
    if named.is_empty() {
        return None;
    }
    let index = |body: &str| named.iter().position(|(name, _)| *name == body);
    let motion = BodyMotion {
        body: points.iter().map(|p| p.body.as_deref().and_then(index)).collect(),
        pivots_mm: named.iter().map(|(name, _)| centroid(points, name)).collect(),
        still: still.to_owned(),
    };
    let mut parameters = Vec::new();
    for (name, _) in &named {
        parameters
            .extend(AXES[..D].iter().map(|axis| parameter(format!("{name} {axis}"), "mm", 1.0)));
        parameters
            .extend(axis_pairs(D).map(|(a, b)| {
                parameter(format!("{name} {} to {}", AXES[a], AXES[b]), "µrad", 1e6)
            }));
    }
    let text = format!(
        "sub-assemblies have moved against each other: each as a rigid body against {still}"
    );
    Some(entry("sub-assembly", &text, parameters, Term::BodyMotion(motion)))
}

fn centroid<const D: usize>(points: &[MeasuredPoint<D>], body: &str) -> SVector<f64, D> {
    let of_body = |p: &&MeasuredPoint<D>| p.body.as_deref() == Some(body) && p.role == Role::Fit;
    let (count, sum) = points
        .iter()
        .filter(of_body)
        .fold((0, SVector::zeros()), |(n, sum), p| (n + 1, sum + p.pair.source_mm.coords));
    sum / ratio(count)
}
