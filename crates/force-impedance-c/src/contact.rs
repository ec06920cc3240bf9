use force_impedance::{Balance, ContactForce};
use nalgebra::Vector3;

use crate::FiError;
use crate::head::{FiHead, head_in};
use crate::pointer::{Output, code, read};

/// Squared length of a normal with six good digits.
const UNIT_TOL: f64 = 1e-5;

/// Contact force split along the outward normal of the surface.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiContact {
    /// Force of the workpiece on the tool, frame Y.
    pub force_n: [f64; 3],
    /// Along the outward normal: positive presses.
    pub normal_n: f64,
    /// Across the normal: friction.
    pub tangential_n: f64,
    /// Friction over normal force; NaN while nothing presses.
    pub friction_ratio: f64,
}

impl From<&ContactForce> for FiContact {
    fn from(contact: &ContactForce) -> Self {
        Self {
            force_n: contact.force_n.into(),
            normal_n: contact.normal_n,
            tangential_n: contact.tangential_n,
            friction_ratio: contact.friction_ratio.unwrap_or(f64::NAN),
        }
    }
}

/// Readings of one instant, checked.
struct Readings {
    balance: Balance,
    cells_n: [f64; 4],
    normal: Vector3<f64>,
}

impl Readings {
    /// # Safety
    ///
    /// Pointers are null or point at live objects of their type and count.
    unsafe fn of(
        head: *const FiHead,
        lengths_mm: *const f64,
        cells_n: *const f64,
        normal: *const f64,
    ) -> Result<Self, FiError> {
        // SAFETY: the caller's promise.
        let (head, lengths_mm, cells_n, normal) = unsafe {
            (
                head_in(head)?,
                read(lengths_mm.cast::<[f64; 4]>())?,
                read(cells_n.cast::<[f64; 4]>())?,
                read(normal.cast::<[f64; 3]>())?,
            )
        };
        let normal = Vector3::from(normal);
        if !cells_n.iter().chain(normal.iter()).all(|v| v.is_finite()) {
            return Err(FiError::NotFinite);
        }
        if (normal.dot(&normal) - 1.0).abs() > UNIT_TOL {
            return Err(FiError::NotAUnitVector);
        }
        let pose = head.pose_of_lengths(&lengths_mm)?.pose;
        Ok(Self { balance: head.balance(&pose), cells_n, normal })
    }
}

/// Contact force from `lengths_mm` (4), `cells_n` (4, compression positive) and the outward unit
/// normal of the surface (3), friction and weight included.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type and count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_contact(
    head: *const FiHead,
    lengths_mm: *const f64,
    cells_n: *const f64,
    normal: *const f64,
    contact: *mut FiContact,
) -> FiError {
    let weigh = || {
        // SAFETY: the caller's promise.
        let (readings, contact) =
            unsafe { (Readings::of(head, lengths_mm, cells_n, normal)?, Output::at(contact)?) };
        contact.put((&readings.balance.contact(&readings.cells_n, &readings.normal)).into());
        Ok(())
    };
    code(weigh())
}

/// Normal force by the published formula `(Σ F_i cos γ_i + F4)/cos θ`, exact without friction and
/// weight only; arguments as `fi_head_contact`.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type and count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_published_normal(
    head: *const FiHead,
    lengths_mm: *const f64,
    cells_n: *const f64,
    normal: *const f64,
    normal_n: *mut f64,
) -> FiError {
    let weigh = || {
        // SAFETY: the caller's promise.
        let (readings, normal_n) =
            unsafe { (Readings::of(head, lengths_mm, cells_n, normal)?, Output::at(normal_n)?) };
        let force_n = readings.balance.published_normal_n(&readings.cells_n, &readings.normal)?;
        normal_n.put(force_n);
        Ok(())
    };
    code(weigh())
}
