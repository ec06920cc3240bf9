use force_impedance::{Head, HeadGeometry, HeadLimits, HeadPose};
use nalgebra::{Point3, Vector3};

use crate::FiError;
use crate::pointer::{Output, Slot, code, read, storage};

/// Says that a head is in the storage, and which layout it has.
const MARK: u64 = 0x4649_2d48_4541_4401;

/// Storage of a head; `fi_head_init` fills it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct FiHead {
    mark: u64,
    /// More than there is to hold; the compiler says when they are too few.
    words: [u64; 48],
}

/// Dimensions of the head, frame Y: origin in the joint, the straight tool along −y.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiHeadGeometry {
    /// L1, from the tool's contact point to the plane of the legs.
    pub tip_to_plane_mm: f64,
    /// L2, from the plane of the legs to the joint, head straight.
    pub plane_to_joint_mm: f64,
    /// Radius of the legs' joints on the head.
    pub head_radius_mm: f64,
    /// Radius of the legs' joints on the bracket.
    pub bracket_radius_mm: f64,
    /// Directions of the legs in the xz plane, from x towards z.
    pub leg_angles_rad: [f64; 3],
    /// Weight of everything between load cells and tip.
    pub weight_n: f64,
    /// Centre of gravity on the tool's axis, from the joint, head straight.
    pub center_of_gravity_mm: f64,
    /// Unit vector along which things fall.
    pub gravity_direction: [f64; 3],
}

/// Limits of the legs' travel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiHeadLimits {
    /// Shortest and longest of the three legs.
    pub leg_mm: [f64; 2],
    /// Shortest and longest of the axial unit.
    pub axial_mm: [f64; 2],
    /// Largest tilt of the tool from −y.
    pub tilt_rad: f64,
}

/// Where the head is, frame Y.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiPose {
    /// Contact point of the tool.
    pub tip_mm: [f64; 3],
    /// Unit vector from the joint to the tip.
    pub axis: [f64; 3],
    /// l1, l2, l3 and the axial l4.
    pub lengths_mm: [f64; 4],
}

impl From<&FiHeadGeometry> for HeadGeometry {
    fn from(g: &FiHeadGeometry) -> Self {
        Self {
            tip_to_plane_mm: g.tip_to_plane_mm,
            plane_to_joint_mm: g.plane_to_joint_mm,
            head_radius_mm: g.head_radius_mm,
            bracket_radius_mm: g.bracket_radius_mm,
            leg_angles_rad: g.leg_angles_rad,
            weight_n: g.weight_n,
            center_of_gravity_mm: g.center_of_gravity_mm,
            gravity_direction: Vector3::from(g.gravity_direction),
        }
    }
}

impl From<&FiHeadLimits> for HeadLimits {
    fn from(l: &FiHeadLimits) -> Self {
        Self { leg_mm: l.leg_mm, axial_mm: l.axial_mm, tilt_rad: l.tilt_rad }
    }
}

impl From<&HeadPose> for FiPose {
    fn from(pose: &HeadPose) -> Self {
        Self {
            tip_mm: pose.tip_mm.coords.into(),
            axis: pose.axis.into(),
            lengths_mm: pose.lengths_mm,
        }
    }
}

/// A copy of the head in a storage.
///
/// # Safety
///
/// As [`read`].
pub(crate) unsafe fn head_in(head: *const FiHead) -> Result<Head, FiError> {
    // SAFETY: the caller's promise.
    let slot = unsafe { read(head) }?;
    if slot.mark != MARK {
        return Err(FiError::NotInitialised);
    }
    // SAFETY: only `fi_head_init` sets the mark, after it has put a head there.
    Ok(*unsafe { Slot::get(&slot.words) })
}

/// The head that dimensions and limits make; null limits are wide ones.
///
/// # Safety
///
/// As [`read`].
pub(crate) unsafe fn head_of(
    geometry: *const FiHeadGeometry,
    limits: *const FiHeadLimits,
) -> Result<Result<Head, force_impedance::ForceImpedanceError>, FiError> {
    // SAFETY: the caller's promise.
    let geometry: HeadGeometry = (&unsafe { read(geometry) }?).into();
    let limits = if limits.is_null() {
        HeadLimits::wide(&geometry)
    } else {
        // SAFETY: the caller's promise.
        (&unsafe { read(limits) }?).into()
    };
    Ok(Head::new(geometry, limits))
}

/// Limits for reading logs rather than for driving: a tenth to twice the length of each leg of the
/// straight head, half to twice of the axial unit, 45°.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_limits_wide(
    geometry: *const FiHeadGeometry,
    limits: *mut FiHeadLimits,
) -> FiError {
    let wide = || {
        // SAFETY: the caller's promise.
        let (geometry, limits) = unsafe { (read(geometry)?, Output::at(limits)?) };
        let HeadLimits { leg_mm, axial_mm, tilt_rad } = HeadLimits::wide(&(&geometry).into());
        limits.put(FiHeadLimits { leg_mm, axial_mm, tilt_rad });
        Ok(())
    };
    code(wide())
}

/// Checks dimensions and limits (null: wide ones) and fills the storage, which holds no head after
/// a refusal; a bad pointer changes nothing.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_init(
    head: *mut FiHead,
    geometry: *const FiHeadGeometry,
    limits: *const FiHeadLimits,
) -> FiError {
    let init = || {
        // SAFETY: the caller's promise; inputs are copied here.
        let made = unsafe { head_of(geometry, limits) }?;
        // SAFETY: the caller's promise.
        let slot = unsafe { storage(head) }?;
        slot.mark = 0;
        let made = made?;
        Slot::put(&mut slot.words, made);
        slot.mark = MARK;
        Ok(())
    };
    code(init())
}

/// The straight head, its tip at (0, −L1 − L2, 0).
///
/// # Safety
///
/// Pointers are null or point at live objects of their type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_start(head: *const FiHead, pose: *mut FiPose) -> FiError {
    let start = || {
        // SAFETY: the caller's promise.
        let (head, pose) = unsafe { (head_in(head)?, Output::at(pose)?) };
        pose.put((&head.pose_at(&head.start_tip_mm())?).into());
        Ok(())
    };
    code(start())
}

/// Inverse kinematics: the pose that brings the tip to `tip_mm` (3 numbers).
///
/// # Safety
///
/// Pointers are null or point at live objects of their type and count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_inverse(
    head: *const FiHead,
    tip_mm: *const f64,
    pose: *mut FiPose,
) -> FiError {
    let inverse = || {
        // SAFETY: the caller's promise.
        let (head, tip_mm, pose) =
            unsafe { (head_in(head)?, read(tip_mm.cast::<[f64; 3]>())?, Output::at(pose)?) };
        pose.put((&head.pose_at(&Point3::from(tip_mm))?).into());
        Ok(())
    };
    code(inverse())
}

/// Forward kinematics: the pose nearest to `lengths_mm` (4 numbers), and in `consistency_mm` how
/// far the four disagree along the direction that no motion makes; it may be null.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type and count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_forward(
    head: *const FiHead,
    lengths_mm: *const f64,
    pose: *mut FiPose,
    consistency_mm: *mut f64,
) -> FiError {
    let forward = || {
        // SAFETY: the caller's promise.
        let (head, lengths_mm, pose) =
            unsafe { (head_in(head)?, read(lengths_mm.cast::<[f64; 4]>())?, Output::at(pose)?) };
        let found = head.pose_of_lengths(&lengths_mm)?;
        if !consistency_mm.is_null() {
            // SAFETY: the caller's promise.
            unsafe { Output::at(consistency_mm) }?.put(found.consistency_mm);
        }
        pose.put((&found.pose).into());
        Ok(())
    };
    code(forward())
}

/// Leg Jacobian ∂(l1, l2, l3, l4)/∂tip at `tip_mm` (3 numbers): 12 numbers, row by row.
///
/// # Safety
///
/// Pointers are null or point at live objects of their type and count.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fi_head_jacobian(
    head: *const FiHead,
    tip_mm: *const f64,
    jacobian: *mut f64,
) -> FiError {
    let fill = || {
        // SAFETY: the caller's promise.
        let (head, tip_mm, rows) = unsafe {
            let rows = Output::at(jacobian.cast::<[f64; 12]>())?;
            (head_in(head)?, read(tip_mm.cast::<[f64; 3]>())?, rows)
        };
        let pose = head.pose_at(&Point3::from(tip_mm))?;
        let by_row = head.leg_jacobian(&pose).transpose();
        let mut numbers = [0.0; 12];
        for (to, from) in numbers.iter_mut().zip(by_row.iter()) {
            *to = *from;
        }
        rows.put(numbers);
        Ok(())
    };
    code(fill())
}
