//! Statics of a head on three radial legs and one axial unit, for simulated logs: written as
//! six equations of equilibrium, apart from the crate under test.

use crate::generators::vector::{add, cross, norm, rotate, scale};

/// Dimensions, mm, and weight, N; frame Y: origin in the joint, the straight tool along −y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HeadModel {
    /// Contact point to the plane of the legs.
    pub tip_to_plane_mm: f64,
    /// Plane of the legs to the joint.
    pub plane_to_joint_mm: f64,
    /// Joints of the legs on the head.
    pub head_radius_mm: f64,
    /// Joints of the legs on the bracket.
    pub bracket_radius_mm: f64,
    /// Weight beyond the load cells.
    pub weight_n: f64,
    /// Its place on the axis of the straight tool, from the joint.
    pub center_of_gravity_mm: f64,
}

/// Directions of the legs, degrees from x towards z.
pub(crate) const LEGS_DEG: [f64; 3] = [90.0, 210.0, 330.0];
/// Things fall along −z.
const DOWN: [f64; 3] = [0.0, 0.0, -1.0];
const STRAIGHT: [f64; 3] = [0.0, -1.0, 0.0];

impl HeadModel {
    pub(crate) const USUAL: Self = Self {
        tip_to_plane_mm: 120.0,
        plane_to_joint_mm: 180.0,
        head_radius_mm: 40.0,
        bracket_radius_mm: 110.0,
        weight_n: 85.0,
        center_of_gravity_mm: 140.0,
    };

    /// Tip of the straight head.
    pub(crate) fn start_tip_mm(&self) -> [f64; 3] {
        [0.0, -self.tip_to_plane_mm - self.plane_to_joint_mm, 0.0]
    }

    /// The head with its tip at a point.
    pub(crate) fn at(&self, tip_mm: [f64; 3]) -> Placed {
        let reach_mm = norm(&tip_mm);
        let axis = scale(1.0 / reach_mm, tip_mm);
        let across = cross(STRAIGHT, axis);
        let sine = norm(&across);
        let angle = sine.atan2(-axis[1]);
        let about = if sine > 0.0 { scale(1.0 / sine, across) } else { [1.0, 0.0, 0.0] };
        let slide_mm = reach_mm - self.tip_to_plane_mm - self.plane_to_joint_mm;
        let moved =
            |straight_mm: [f64; 3]| add(rotate(about, angle, straight_mm), scale(slide_mm, axis));
        let ring = |radius_mm: f64, angle_deg: f64| {
            let (sin, cos) = angle_deg.to_radians().sin_cos();
            [radius_mm * cos, -self.plane_to_joint_mm, radius_mm * sin]
        };
        let joints_mm = LEGS_DEG.map(|a| moved(ring(self.head_radius_mm, a)));
        let legs_mm: [[f64; 3]; 3] = std::array::from_fn(|i| {
            let bracket_mm = ring(self.bracket_radius_mm, LEGS_DEG[i]);
            add(joints_mm[i], scale(-1.0, bracket_mm))
        });
        Placed {
            tip_mm,
            axis,
            joints_mm,
            lengths_mm: [
                norm(&legs_mm[0]),
                norm(&legs_mm[1]),
                norm(&legs_mm[2]),
                self.plane_to_joint_mm + slide_mm,
            ],
            pushes: legs_mm.map(|leg| scale(1.0 / norm(&leg), leg)),
            weight_n: scale(self.weight_n, DOWN),
            center_mm: moved([0.0, -self.center_of_gravity_mm, 0.0]),
        }
    }
}

/// A head somewhere.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    tip_mm: [f64; 3],
    /// Joint to tip.
    pub axis: [f64; 3],
    joints_mm: [[f64; 3]; 3],
    /// Three legs and the axial unit.
    pub lengths_mm: [f64; 4],
    /// Unit vectors, bracket to head.
    pushes: [[f64; 3]; 3],
    weight_n: [f64; 3],
    center_mm: [f64; 3],
}

impl Placed {
    /// Readings of the cells that hold a force of the workpiece on the tool, the three legs adding
    /// up to `bracing_n`.
    pub(crate) fn cells_n(&self, force_n: [f64; 3], bracing_n: f64) -> [f64; 4] {
        let mut rows = self.equations(force_n);
        rows.push(vec![1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, bracing_n]);
        let x = solve(rows);
        [x[0], x[1], x[2], x[3]]
    }

    /// Force of the workpiece on the tool that readings of the cells stand for.
    pub(crate) fn force_n(&self, cells_n: [f64; 4]) -> [f64; 3] {
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for equation in self.equations([0.0; 3]) {
            let known: f64 = (0..4).map(|i| equation[i] * cells_n[i]).sum();
            rows.push(vec![
                0.0,
                0.0,
                0.0,
                equation[4],
                equation[5],
                equation[6],
                equation[7] - known,
            ]);
        }
        for (axis, unit) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].iter().enumerate() {
            let moment = cross(self.tip_mm, *unit);
            for (row, entry) in rows.iter_mut().zip(unit.iter().chain(&moment)) {
                row[axis] = *entry;
            }
        }
        let x = solve(rows);
        [x[0], x[1], x[2]]
    }

    /// Balance of forces and of moments about the joint; unknown are four cells, two forces of the
    /// joint across the axis and its moment along it; the last entry is the right-hand side.
    fn equations(&self, force_n: [f64; 3]) -> Vec<Vec<f64>> {
        let side = cross(self.axis, [0.0, 0.0, 1.0]);
        let side = scale(1.0 / norm(&side), side);
        let other = cross(self.axis, side);
        let forces = [self.pushes[0], self.pushes[1], self.pushes[2], self.axis, side, other];
        let moment =
            |i: usize| if i < 3 { cross(self.joints_mm[i], self.pushes[i]) } else { [0.0; 3] };
        let given = add(force_n, self.weight_n);
        let turned = add(cross(self.tip_mm, force_n), cross(self.center_mm, self.weight_n));
        let along = |axis: usize| {
            let mut row: Vec<f64> = forces.iter().map(|f| f[axis]).collect();
            row.extend([0.0, -given[axis]]);
            row
        };
        let about = |axis: usize| {
            let mut row: Vec<f64> = (0..6).map(|i| moment(i)[axis]).collect();
            row.extend([self.axis[axis], -turned[axis]]);
            row
        };
        (0..3).map(along).chain((0..3).map(about)).collect()
    }
}

/// Gaussian elimination with row pivoting; the last entry of a row is its right-hand side.
pub(crate) fn solve(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for column in 0..n {
        let largest =
            |a: &usize, b: &usize| rows[*a][column].abs().total_cmp(&rows[*b][column].abs());
        let pivot = (column..n).max_by(largest).expect("rows are left");
        rows.swap(column, pivot);
        let above = rows[column].clone();
        for row in &mut rows[column + 1..] {
            let factor = row[column] / above[column];
            row.iter_mut().zip(&above).for_each(|(v, a)| *v -= factor * a);
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| rows[i][j] * x[j]).sum();
        x[i] = (rows[i][n] - known) / rows[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Forces of some 10² N, moments of some 10⁴ N·mm in one system: 10⁴ · 2⁻⁵² · 50 operations.
    const TOL_N: f64 = 1e-10;

    #[test]
    fn cells_and_force_undo_each_other() {
        let placed = HeadModel::USUAL.at([6.0, -302.0, -9.0]);
        let force_n = [7.0, 55.0, -4.0];
        let found = placed.force_n(placed.cells_n(force_n, 300.0));
        for i in 0..3 {
            assert!((found[i] - force_n[i]).abs() < TOL_N, "{found:?}");
        }
    }

    /// A straight head on its own: the axial cell reads the push, the legs a third of the bracing
    /// each where nothing weighs.
    #[test]
    fn a_straight_head_is_as_it_looks() {
        let light = HeadModel { weight_n: 0.0, ..HeadModel::USUAL };
        let cells_n = light.at(light.start_tip_mm()).cells_n([0.0, 40.0, 0.0], 300.0);
        for (found, expected) in cells_n.into_iter().zip([100.0, 100.0, 100.0, 40.0]) {
            assert!((found - expected).abs() < TOL_N, "{cells_n:?}");
        }
    }
}
