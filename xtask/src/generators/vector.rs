//! The little vector algebra that the generators need, apart from the crates under test.

/// Scalar product.
pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(&b).map(|(a, b)| a * b).sum()
}

/// Cross product.
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Rotates `v` about the unit vector `axis` by `angle_rad` (Rodrigues).
pub(crate) fn rotate(axis: [f64; 3], angle_rad: f64, v: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = angle_rad.sin_cos();
    let along = (0..3).map(|i| axis[i] * v[i]).sum::<f64>() * (1.0 - cos);
    let across = cross(axis, v);
    std::array::from_fn(|i| cos * v[i] + sin * across[i] + along * axis[i])
}

/// Sum.
pub(crate) fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// Product with a number.
pub(crate) fn scale(factor: f64, a: [f64; 3]) -> [f64; 3] {
    a.map(|v| factor * v)
}

/// Euclidean length.
pub(crate) fn norm(a: &[f64]) -> f64 {
    a.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Removes from `column` what lies in the span of `others`.
pub(crate) fn orthogonalise(column: &mut [f64], others: &[Vec<f64>]) {
    for direction in orthonormal(others) {
        remove(&direction, column);
    }
}

/// An orthonormal basis of the span of `columns` (Gram-Schmidt, each twice against round-off).
pub(crate) fn orthonormal(columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let mut column = column.clone();
        let before = norm(&column);
        for _ in 0..2 {
            for direction in &basis {
                remove(direction, &mut column);
            }
        }
        let length = norm(&column);
        // What is left of a dependent column is round-off.
        if length > 1e-12 * before {
            basis.push(column.iter().map(|v| v / length).collect());
        }
    }
    basis
}

/// Removes the part along a unit column.
fn remove(direction: &[f64], column: &mut [f64]) {
    let along: f64 = direction.iter().zip(column.iter()).map(|(d, v)| d * v).sum();
    column.iter_mut().zip(direction).for_each(|(v, d)| *v -= along * d);
}
