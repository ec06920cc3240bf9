//! Errors of an axis in the frame asked for.

use nalgebra::Matrix6;

use crate::{AxisError, ErrorOrder, RotaryAxis};

/// Errors given in the fixed frame, in the frame asked for.
pub(crate) fn in_order(axis: &RotaryAxis, order: ErrorOrder, error: AxisError) -> AxisError {
    if order == ErrorOrder::Fixed {
        return error;
    }
    let rotation = axis.rotation(error.angle_rad).to_rotation_matrix().into_inner();
    let mut back = Matrix6::zeros();
    back.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation.transpose());
    back.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation.transpose());
    AxisError {
        error: back * error.error,
        covariance: back * error.covariance * back.transpose(),
        ..error
    }
}
