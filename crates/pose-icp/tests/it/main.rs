//! Public behaviour of `pose-icp`.
