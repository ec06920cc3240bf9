//! Heights where none was measured, so that a spline through the others stays as smooth as they are.

use nalgebra::{Matrix3, Vector3};

/// Places on either side from which a missing height is continued.
const WINDOW: usize = 2;
/// Layers beside the measured places that go on along their slope; a spline forgets what lies three
/// places away to one in fifty, and a slope carried farther says nothing.
const SLOPING_LAYERS: usize = 3;
/// Share of the window's extent below which places lie on a line and have no plane.
const ON_A_LINE: f64 = 1e-9;

/// Fills the missing heights of a grid of `columns` places a row, layer by layer from the measured
/// ones outwards: by the plane through those near, and farther out by the mean of the neighbours.
///
/// At least one height has to be there.
pub(crate) fn continued_heights(columns: usize, heights_mm: &[Option<f64>]) -> Vec<f64> {
    let mut heights = heights_mm.to_vec();
    let mut layer = 0;
    loop {
        let next = next_layer(columns, &heights);
        if next.is_empty() {
            // Nothing is missing, or nothing is there.
            return heights.into_iter().map(|height| height.unwrap_or(0.0)).collect();
        }
        let found: Vec<f64> = next
            .iter()
            .map(|&place| {
                let near = near(columns, &heights, place);
                let plane = if layer < SLOPING_LAYERS { plane_at(&near) } else { None };
                plane.unwrap_or_else(|| mean(&near))
            })
            .collect();
        for (place, height) in next.into_iter().zip(found) {
            heights[place] = Some(height);
        }
        layer += 1;
    }
}

/// Places without a height that have a neighbour with one.
fn next_layer(columns: usize, heights: &[Option<f64>]) -> Vec<usize> {
    let rows = heights.len() / columns;
    let has_neighbour = |place: usize| {
        let (i, j) = (place % columns, place / columns);
        around(i, 1, columns)
            .any(|i| around(j, 1, rows).any(|j| heights[j * columns + i].is_some()))
    };
    (0..heights.len()).filter(|&place| heights[place].is_none() && has_neighbour(place)).collect()
}

/// Known heights around a place: steps to them, and the height.
fn near(columns: usize, heights: &[Option<f64>], place: usize) -> Vec<[f64; 3]> {
    let rows = heights.len() / columns;
    let (i, j) = (place % columns, place / columns);
    let step = |to: usize, from: usize| as_f64(to) - as_f64(from);
    let of_row = |l: usize| {
        around(i, WINDOW, columns).filter_map(move |k| {
            heights[l * columns + k].map(|height| [step(k, i), step(l, j), height])
        })
    };
    around(j, WINDOW, rows).flat_map(of_row).collect()
}

/// Indices at most `by` away.
fn around(index: usize, by: usize, count: usize) -> std::ops::Range<usize> {
    index.saturating_sub(by)..(index + by + 1).min(count)
}

/// Height of the least-squares plane at the place itself; `None` where the places lie on a line.
fn plane_at(near: &[[f64; 3]]) -> Option<f64> {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [x, y, height] in near {
        let row = Vector3::new(1.0, *x, *y);
        normal += row * row.transpose();
        right += row * *height;
    }
    let factor = normal.cholesky()?;
    let diagonal = factor.l().diagonal();
    (diagonal.min() > ON_A_LINE * diagonal.max()).then(|| factor.solve(&right).x)
}

fn mean(near: &[[f64; 3]]) -> f64 {
    near.iter().map(|[_, _, height]| height).sum::<f64>() / as_f64(near.len())
}

#[expect(clippy::cast_precision_loss, reason = "places of a grid are far below 2^53")]
fn as_f64(count: usize) -> f64 {
    count as f64
}
