//! How each thing that may be wrong changes the force of one sample, per unit.

use nalgebra::{Point3, Vector3};

use crate::cofactor::least_squares;
use crate::{ForceFormula, Head, HeadPose, LogSample};

/// Central differences over 10 µm: the force bends by some 1e-4 per mm², and loses 1e-13/1e-2.
const STEP_MM: f64 = 1e-2;

/// Derivatives of normal force (N) and consistency (mm).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sensitivity {
    /// By what each cell reads.
    pub(crate) per_cell: [f64; 4],
    /// The same times what it reads.
    pub(crate) of_cell_n: [f64; 4],
    /// By what each length reads, N/mm.
    pub(crate) per_length: [f64; 4],
    /// Consistency by what each length reads.
    pub(crate) consistency_per_length: [f64; 4],
    /// By weight missing in the declared one, at the place of that.
    pub(crate) per_weight: f64,
    /// By weight missing at the joint, and by its moment about the joint, per N·mm.
    pub(crate) per_weight_at_joint: f64,
    pub(crate) per_moment: f64,
    /// Friction force.
    pub(crate) tangential_n: f64,
    /// −u·n, how much of an axial force is normal.
    pub(crate) axial_share: f64,
    /// Where the friction of the published formula comes in: `−t·u` with t the direction of
    /// friction.
    pub(crate) rub_share: f64,
}

impl Sensitivity {
    /// At the pose of a sample.
    pub(crate) fn of(
        head: &Head,
        tip_mm: &Vector3<f64>,
        sample: &LogSample,
        formula: ForceFormula,
    ) -> Self {
        let normal = &sample.normal;
        let pose = HeadPose::of(head, tip_mm);
        let balance = head.balance(&pose);
        let axial_share = -pose.axis.dot(normal);
        let force_n = balance.force_n(&sample.cells_n);
        let rub = force_n - normal.as_ref() * force_n.dot(normal);
        let rub_share = -rub.try_normalize(1e-9).map_or(0.0, |t| t.dot(&pose.axis));
        let geometry = head.geometry();
        let per_cell = match formula {
            ForceFormula::FullBalance => balance.normal_weights(normal),
            ForceFormula::Published => {
                let cosine = |i: usize| pose.legs_axis[i].dot(&pose.axis) / axial_share;
                [cosine(0), cosine(1), cosine(2), 1.0 / axial_share]
            }
        };
        let (per_weight_at_joint, per_moment) = match formula {
            ForceFormula::FullBalance => {
                let axial_mm = pose.lengths_mm[3];
                let per_reach = (axial_mm + geometry.tip_to_plane_mm).recip();
                let g = geometry.gravity_direction;
                let along = pose.axis * pose.axis.dot(&g);
                // The legs then read a force that the declared balance takes for contact.
                let per_moment = -normal.dot(&(along - g)) * per_reach;
                let joint_mm = axial_mm - geometry.plane_to_joint_mm;
                (normal.dot(&along) + per_moment * joint_mm, per_moment)
            }
            ForceFormula::Published => {
                (-pose.axis.dot(&geometry.gravity_direction) / axial_share, 0.0)
            }
        };
        let per_weight = per_weight_at_joint + per_moment * geometry.center_of_gravity_mm;
        let mut out = Self {
            per_cell,
            of_cell_n: std::array::from_fn(|i| per_cell[i] * sample.cells_n[i]),
            per_weight,
            per_weight_at_joint,
            per_moment,
            tangential_n: rub.norm(),
            axial_share,
            rub_share,
            ..Self::default()
        };
        out.lengths(head, &pose, sample, formula);
        out
    }

    /// Derivatives by lengths, through the motion of the tip that they are taken for.
    fn lengths(&mut self, head: &Head, pose: &HeadPose, sample: &LogSample, formula: ForceFormula) {
        let force_at = |step_mm: Vector3<f64>| {
            let moved: Point3<f64> = pose.tip_mm + step_mm;
            let pose = HeadPose::of(head, &moved.coords);
            let balance = head.balance(&pose);
            match formula {
                ForceFormula::FullBalance => {
                    balance.contact(&sample.cells_n, &sample.normal).normal_n
                }
                ForceFormula::Published => {
                    -balance.published_axial_n(&sample.cells_n) / pose.axis.dot(&sample.normal)
                }
            }
        };
        let slope = |axis: usize| {
            let step_mm = Vector3::ith(axis, STEP_MM);
            (force_at(step_mm) - force_at(-step_mm)) / (2.0 * STEP_MM)
        };
        let per_tip = Vector3::new(slope(0), slope(1), slope(2));
        let rows = pose.length_gradients(head);
        let direction = crate::cofactor::orthogonal(&rows);
        for i in 0..4 {
            let mut one = [0.0; 4];
            one[i] = 1.0;
            self.per_length[i] = per_tip.dot(&least_squares(&rows, &one));
            self.consistency_per_length[i] = direction[i];
        }
    }

    /// Adds a share of another one.
    pub(crate) fn add(&mut self, other: &Self, share: f64) {
        let add = |to: &mut [f64; 4], from: &[f64; 4]| {
            to.iter_mut().zip(from).for_each(|(t, f)| *t += share * f);
        };
        add(&mut self.per_cell, &other.per_cell);
        add(&mut self.of_cell_n, &other.of_cell_n);
        add(&mut self.per_length, &other.per_length);
        add(&mut self.consistency_per_length, &other.consistency_per_length);
        self.per_weight += share * other.per_weight;
        self.per_weight_at_joint += share * other.per_weight_at_joint;
        self.per_moment += share * other.per_moment;
        self.tangential_n += share * other.tangential_n;
        self.axial_share += share * other.axial_share;
        self.rub_share += share * other.rub_share;
    }
}
