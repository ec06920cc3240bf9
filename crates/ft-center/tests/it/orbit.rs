//! Orbit centres: exactness, spin, gate and hostile records.
