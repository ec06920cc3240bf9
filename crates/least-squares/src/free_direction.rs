//! What the data leave free.

use std::fmt;

use nalgebra::DVector;

/// A combination of tangent directions that no residual sees.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeDirection {
    /// Name and share of each tangent direction that takes part, largest share first.
    ///
    /// Shares are of the column-scaled Jacobian, so that units do not matter; the largest is 1.
    pub components: Vec<(String, f64)>,
    /// The direction as a tangent step, in the units of the parameters.
    pub step: DVector<f64>,
}

impl fmt::Display for FreeDirection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (name, share)) in self.components.iter().enumerate() {
            let sign = match (i, *share < 0.0) {
                (0, false) => "",
                (0, true) => "−",
                (_, false) => " + ",
                (_, true) => " − ",
            };
            write!(f, "{sign}{:.2}·{name}", share.abs())?;
        }
        Ok(())
    }
}
