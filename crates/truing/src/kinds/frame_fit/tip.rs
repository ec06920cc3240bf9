//! What poses of a flange are solved for.

use serde::Serialize;

use crate::estimated::Estimated;
use crate::estimates::Estimates;
use crate::implausible::{ImplausibleResult, too_long};
use crate::text_table::TextTable;

/// What poses of a flange are solved for.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TipEstimates {
    /// Tip in the flange's frame.
    pub tip_mm: [f64; 3],
    /// Standard uncertainty of it.
    pub std_tip_mm: [f64; 3],
    /// One per place, in the order first touched.
    pub places: Vec<PlaceEstimate>,
    /// One per known distance.
    pub distances: Vec<DistanceResidual>,
    /// One per pose.
    pub poses: Vec<PoseResidual>,
}

/// A place that the tip was held at, base frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "coordinates with their standard uncertainties, as named")]
pub struct PlaceEstimate {
    pub place: String,
    pub x_mm: f64,
    pub y_mm: f64,
    pub z_mm: f64,
    pub std_x_mm: f64,
    pub std_y_mm: f64,
    pub std_z_mm: f64,
}

/// A known distance beside the one found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DistanceResidual {
    /// One place.
    pub from: String,
    /// The other.
    pub to: String,
    /// As known.
    pub known_mm: f64,
    /// As found.
    pub found_mm: f64,
}

/// Residual `p + R·t − c` of one pose, base frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "components, as named")]
pub struct PoseResidual {
    pub pose: String,
    pub place: String,
    pub dx_mm: f64,
    pub dy_mm: f64,
    pub dz_mm: f64,
}

impl Estimates for TipEstimates {
    fn parameters(&self) -> Vec<Estimated> {
        let tip = ["x", "y", "z"].into_iter().zip(self.tip_mm).zip(self.std_tip_mm);
        let mut all: Vec<Estimated> = tip
            .map(|((axis, value), std)| {
                Estimated::new(&format!("tip {axis}"), "mm", value, Some(std))
            })
            .collect();
        all.extend(self.distances.iter().map(|d| {
            Estimated::new(&format!("distance {} to {}", d.from, d.to), "mm", d.found_mm, None)
        }));
        all
    }

    fn tables(&self) -> Vec<TextTable> {
        let columns = ["place", "x mm", "y mm", "z mm", "std x mm", "std y mm", "std z mm"];
        let mut table = TextTable::new("places, base frame", &columns);
        for p in &self.places {
            let numbers = [p.x_mm, p.y_mm, p.z_mm, p.std_x_mm, p.std_y_mm, p.std_z_mm];
            let name = p.place.clone().into();
            table.push([name].into_iter().chain(numbers.map(Into::into)).collect());
        }
        vec![table]
    }

    fn implausible(&self, _: Option<f64>) -> Option<ImplausibleResult> {
        too_long("the tip", "the flange", self.tip_mm)
    }
}
