use geometry::AsphereShape;
use nalgebra::Point2;
use pose_icp::Part;
use serde::Deserialize;
use toml::Spanned;

use crate::Error;
use crate::case::{Document, Finite, Folder, Positive, Problem};

/// `[surface]`; which keys are needed depends on the shape.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceSettings {
    shape: Spanned<ShapeName>,
    radius_mm: Option<Finite>,
    conic: Option<Finite>,
    coefficients: Option<Vec<Finite>>,
    diameter_mm: Option<Positive>,
    aperture_center_mm: Option<[Finite; 2]>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Asphere,
}

/// The part, and how to speak of it.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) part: Part,
    pub(super) words: String,
    /// Whether a rotation about z may show.
    pub(super) shows_gamma: bool,
}

impl SurfaceSettings {
    pub(super) fn read(
        &self,
        _folder: &Folder,
        document: &Document,
        _warnings: &mut Vec<String>,
    ) -> Result<Surface, Error> {
        match self.shape.get_ref() {
            ShapeName::Asphere => self.asphere(document),
        }
    }

    fn asphere(&self, document: &Document) -> Result<Surface, Error> {
        let missing = |key: &str, purpose| {
            let key = format!("[surface] {key}");
            let at = document.at(&self.shape.span());
            Error::case(at, Problem::MissingKey { key, purpose })
        };
        let Finite(radius_mm) = self.radius_mm.ok_or_else(|| {
            missing("radius_mm", "the vertex radius of curvature, positive for a bowl")
        })?;
        let Positive(diameter_mm) =
            self.diameter_mm.ok_or_else(|| missing("diameter_mm", "the part's diameter"))?;
        let Finite(conic) = self.conic.unwrap_or(Finite(0.0));
        let coefficients: Vec<f64> =
            self.coefficients.iter().flatten().map(|Finite(a)| *a).collect();
        let [Finite(x), Finite(y)] = self.aperture_center_mm.unwrap_or([Finite(0.0), Finite(0.0)]);
        let words = format!(
            "asphere, R = {radius_mm} mm, k = {conic}, diameter {diameter_mm} mm{}",
            if coefficients.is_empty() { "" } else { ", with even terms" }
        );
        let shape = AsphereShape {
            radius_mm,
            conic,
            coefficients,
            diameter_mm,
            aperture_center_mm: Point2::new(x, y),
        };
        let part = Part::asphere(shape).map_err(|source| {
            let message = format!("[surface]: {source}");
            let at = document.at(&self.shape.span());
            Error::case(at, Problem::WrongValue { message })
        })?;
        Ok(Surface { part, words, shows_gamma: false })
    }
}
