//! A probing check on a calibrated sphere, by the quantities of ISO 10360-5.

use probe_comp::{BallTouch, ProbeTerms, Reference, qualify};
use serde::Serialize;
use truing_report::{Fact, Form, FormResult};

/// Touches that ISO 10360-5 asks for.
const TOUCHES_ASKED: usize = 25;

/// The sphere through the compensated touches of a calibrated one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ProbingCheckEstimate {
    /// Touches of the sphere.
    pub touches: usize,
    /// `P_Form.Sph`: range of the radial distances from the least-squares centre.
    pub form_mm: f64,
    /// `P_Size.Sph`: diameter found with the declared radius of the ball, less the calibrated one.
    pub size_mm: f64,
    /// Standard uncertainty of the size from the scatter of the touches; `None` without redundancy.
    pub std_size_mm: Option<f64>,
}

/// Place of the sphere, then the radius, in the covariance.
const RADIUS: usize = 3;

impl ProbingCheckEstimate {
    /// Of a sphere with nothing but its place and size fitted; `None` of a ring, and where too few
    /// touches give no sphere.
    pub(super) fn of(
        balls: &[BallTouch],
        reference: &Reference,
        terms: &ProbeTerms,
        tip_radius_mm: f64,
    ) -> Option<Self> {
        if !matches!(reference, Reference::Sphere { .. }) {
            return None;
        }
        let plain = ProbeTerms { lobes: Vec::new(), bending: false, ..terms.clone() };
        let found = qualify(balls, reference, &plain).ok()?;
        let residuals = || found.residuals_mm.iter().copied();
        let range_mm = residuals().fold(f64::NEG_INFINITY, f64::max)
            - residuals().fold(f64::INFINITY, f64::min);
        let variance_mm2 = found.covariance_mm2[(RADIUS, RADIUS)].max(0.0);
        Some(Self {
            touches: balls.len(),
            form_mm: range_mm,
            size_mm: -2.0 * found.pretravel_mm(tip_radius_mm),
            std_size_mm: found.variance_factor.map(|_| 2.0 * variance_mm2.sqrt()),
        })
    }

    pub(super) fn form(&self) -> Form {
        let result = |symbol: &str, name: &str, value_mm: f64, std_mm: Option<f64>| FormResult {
            symbol: symbol.to_owned(),
            name: name.to_owned(),
            unit: "µm".to_owned(),
            value: Some(1e3 * value_mm),
            std: std_mm.map(|std| 1e3 * std),
            limit: None,
        };
        let mut notes = vec![
            "With the declared radius of the ball and nothing but the sphere's place and size fitted. The \
             uncertainty of the size is that of the scatter alone; the form of the sphere and its \
             certificate (ISO/TS 23165) are in neither."
                .to_owned(),
        ];
        if self.touches != TOUCHES_ASKED {
            notes.push(format!(
                "ISO 10360-5 asks for {TOUCHES_ASKED} touches in its pattern; these are {}.",
                self.touches
            ));
        }
        Form {
            title: "Probing check on a sphere (quantities of ISO 10360-5)".to_owned(),
            conditions: vec![Fact {
                name: "touches of the sphere".to_owned(),
                value: self.touches.to_string(),
            }],
            results: vec![
                result("P_Form.Sph", "probing form error", self.form_mm, None),
                result("P_Size.Sph", "probing size error", self.size_mm, self.std_size_mm),
            ],
            notes,
            ..Form::default()
        }
    }
}
