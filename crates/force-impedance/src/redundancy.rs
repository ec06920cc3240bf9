//! What four cells say of each other.
//!
//! Friction bounds how far a contact force leans from the normal, and the preload of the legs is
//! what it was before: three conditions on four readings. One reading that is wrong breaks them in
//! a direction of its own, two that are exchanged in another.

use nalgebra::{Vector3, Vector4};

use crate::balance::Balance;
use crate::cofactor::orthogonal;
use crate::scalar::across;
use crate::{Cells, ContactForce, ControllerSettings};

/// Memory of how the cells agreed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Redundancy {
    disagreeing_cycles: u32,
    /// Readings of the last cycle in which they agreed.
    agreed_n: Option<[f64; 4]>,
}

impl Redundancy {
    pub(crate) const NEW: Self = Self { disagreeing_cycles: 0, agreed_n: None };

    /// The cells that are to be suspected, once the readings have disagreed for long enough.
    #[inline]
    pub(crate) fn judge(
        &mut self,
        settings: &ControllerSettings,
        balance: &Balance,
        contact: &ContactForce,
        cells_n: &[f64; 4],
        normal: &Vector3<f64>,
    ) -> Option<Cells> {
        let held_n = settings.max_friction_ratio * contact.normal_n.max(0.0);
        if contact.tangential_n <= held_n + settings.max_disagreement_n {
            self.disagreeing_cycles = 0;
            self.agreed_n = Some(*cells_n);
            return None;
        }
        self.disagreeing_cycles = self.disagreeing_cycles.saturating_add(1);
        if self.disagreeing_cycles < settings.suspect_cycles {
            return None;
        }
        Some(suspects(balance, cells_n, self.agreed_n.as_ref(), normal))
    }
}

/// The one cell, or the two exchanged ones, that explain the readings best: what is left is
/// smallest of the force across the normal and of the change of the legs' preload.
#[cold]
fn suspects(
    balance: &Balance,
    cells_n: &[f64; 4],
    agreed_n: Option<&[f64; 4]>,
    normal: &Vector3<f64>,
) -> Cells {
    let columns = balance.columns();
    let preload = orthogonal(columns);
    let before_n = Vector4::from(agreed_n.copied().unwrap_or(*cells_n));
    let left = |cells_n: [f64; 4]| {
        let preload_n = preload.dot(&(Vector4::from(cells_n) - before_n));
        (across(&balance.force_n(&cells_n), normal), preload_n)
    };
    let (across_n, preload_n) = left(*cells_n);
    let whole = across_n.dot(&across_n) + preload_n * preload_n;
    let mut best = (f64::INFINITY, Cells::default());
    let [c1, c2, c3, c4] = [Cells::one(0), Cells::one(1), Cells::one(2), Cells::one(3)];
    let shares: [f64; 4] = preload.into();
    for ((column, share), cell) in columns.iter().zip(shares).zip([c1, c2, c3, c4]) {
        // One reading is free: the least square over it.
        let side = across(column, normal);
        let size = side.dot(&side) + share * share;
        let along = side.dot(&across_n) + share * preload_n;
        let rest = whole - along * along / size;
        if rest < best.0 {
            best = (rest, cell);
        }
    }
    let [f1, f2, f3, f4] = *cells_n;
    let exchanged = [
        ([f2, f1, f3, f4], c1.and(c2)),
        ([f3, f2, f1, f4], c1.and(c3)),
        ([f4, f2, f3, f1], c1.and(c4)),
        ([f1, f3, f2, f4], c2.and(c3)),
        ([f1, f4, f3, f2], c2.and(c4)),
        ([f1, f2, f4, f3], c3.and(c4)),
    ];
    for (cells_n, pair) in exchanged {
        let (across_n, preload_n) = left(cells_n);
        let rest = across_n.dot(&across_n) + preload_n * preload_n;
        if rest < best.0 {
            best = (rest, pair);
        }
    }
    best.1
}
