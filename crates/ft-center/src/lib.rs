//! ft-center
