//! G-code programs, corrected.

use truing::geometry::nalgebra::{Affine3, Isometry3, Matrix4, Vector3, convert};
use truing::pose_icp::{ProgramOptions, correct_program_for_machine};

/// The first byte says how fine arcs become and how many decimals are written.
pub(super) fn read(bytes: &[u8]) {
    let Some((first, program)) = bytes.split_first() else { return };
    let options = ProgramOptions {
        chord_mm: [1e-3, 0.1, 1e-9, 10.0][usize::from(first % 4)],
        decimals: usize::from(first / 4 % 10),
    };
    let program = String::from_utf8_lossy(program);
    let tilt = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.01, -0.02, 0.3));
    let mut skew = Matrix4::identity();
    (skew[(0, 0)], skew[(0, 1)]) = (1.0 + 1e-4, 1e-5);
    let corrections: [Affine3<f64>; 3] =
        [Affine3::identity(), convert(tilt), Affine3::from_matrix_unchecked(skew)];
    for correction in &corrections {
        if let Ok(corrected) = correct_program_for_machine(&program, correction, &options) {
            let again = correct_program_for_machine(&corrected, &Affine3::identity(), &options);
            assert!(again.is_ok(), "{again:?} of what was corrected:\n{corrected}");
        }
    }
}
