//! What the rows say about the six components, in lengths only.

use nalgebra::{DMatrix, DVector, Matrix6, SymmetricEigen, Vector6};

/// Singular values below this share of the largest are rounding: normal equations hold squares,
/// to sixteen digits.
pub(crate) const FREE_RATIO: f64 = 1e-6;

/// Eigenvectors of the normal equations of the free components.
///
/// Rotations count as the way of a point at `arm_mm` from the pivot, so that all are lengths.
pub(crate) struct Information {
    scale: Vector6<f64>,
    free: Vec<usize>,
    /// Singular values of the scaled rows, the largest first.
    pub(crate) singular_values: Vec<f64>,
    /// One column for each.
    vectors: DMatrix<f64>,
}

impl Information {
    pub(crate) fn new(hessian: &Matrix6<f64>, free: &[usize], arm_mm: f64) -> Self {
        let per_rad = 1.0 / arm_mm;
        let scale = Vector6::new(1.0, 1.0, 1.0, per_rad, per_rad, per_rad);
        let n = free.len();
        if n == 0 {
            let vectors = DMatrix::zeros(0, 0);
            return Self { scale, free: Vec::new(), singular_values: Vec::new(), vectors };
        }
        let scaled = DMatrix::from_fn(n, n, |i, j| {
            hessian[(free[i], free[j])] * scale[free[i]] * scale[free[j]]
        });
        let eigen = SymmetricEigen::new(scaled);
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
        Self {
            scale,
            free: free.to_vec(),
            singular_values: order.iter().map(|&k| eigen.eigenvalues[k].max(0.0).sqrt()).collect(),
            vectors: DMatrix::from_fn(n, n, |i, j| eigen.eigenvectors[(i, order[j])]),
        }
    }

    fn is_determined(&self, k: usize) -> bool {
        self.singular_values[k] > FREE_RATIO * self.singular_values[0]
    }

    /// Places of the singular values that are zero but for rounding.
    pub(crate) fn undetermined(&self) -> Vec<usize> {
        (0..self.free.len()).filter(|&k| !self.is_determined(k)).collect()
    }

    /// The Gauss-Newton step, with nothing along what is not determined.
    pub(crate) fn step(&self, gradient: &Vector6<f64>) -> Vector6<f64> {
        let scaled = DVector::from_fn(self.free.len(), |i, _| {
            gradient[self.free[i]] * self.scale[self.free[i]]
        });
        let mut step = Vector6::zeros();
        for k in (0..self.free.len()).filter(|&k| self.is_determined(k)) {
            let along = self.vectors.column(k).dot(&scaled) / self.singular_values[k].powi(2);
            step -= self.direction(k) * along;
        }
        step
    }

    /// Unit vector of a singular value, as a step of the components in mm and rad.
    pub(crate) fn direction(&self, k: usize) -> Vector6<f64> {
        let mut direction = Vector6::zeros();
        for (i, &component) in self.free.iter().enumerate() {
            direction[component] = self.vectors[(i, k)] * self.scale[component];
        }
        direction
    }

    /// Covariance of the components for rows of unit variance; zero for those that are held.
    pub(crate) fn covariance(&self) -> Matrix6<f64> {
        let mut covariance = Matrix6::zeros();
        for k in (0..self.free.len()).filter(|&k| self.is_determined(k)) {
            let direction = self.direction(k) / self.singular_values[k];
            covariance += direction * direction.transpose();
        }
        covariance
    }
}
