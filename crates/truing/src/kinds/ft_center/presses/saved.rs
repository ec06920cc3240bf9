//! A frame out of an answer that this program printed before.

use ft_center::{Handedness, SavedFrame};
use nalgebra::{Matrix4, Point2};
use serde::Deserialize;

use crate::Error;
use crate::case::{Document, Folder, Location, Problem, quote};
use crate::kinds::ft_center::settings::{HandednessName, Settings};

/// What `truing solve --json` or `truing loop --json` printed, as far as the frame goes.
#[derive(Deserialize)]
struct Answer {
    kind: String,
    #[serde(default)]
    verdict: Option<String>,
    #[serde(default)]
    steps: Vec<Step>,
    residual: Unit,
    estimates: Estimates,
}

/// What a loop accepted.
#[derive(Deserialize)]
struct Step {
    effect: String,
}

/// Effects that the frame holds whole, and those of one press: a later press needs nothing more.
const IN_THE_FRAME: [&str; 3] = ["frame-scale", "datum-offset", "bad-press"];

#[derive(Deserialize)]
struct Unit {
    unit: String,
}

#[derive(Deserialize)]
struct Estimates {
    frame: Option<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    angle_deg: f64,
    scale: f64,
    reference_mm: [f64; 2],
    image_mm: [f64; 2],
    /// Of `[angle in rad, image x, image y, scale]`.
    covariance: [[f64; 4]; 4],
    seat_mm: f64,
    variance_factor: f64,
    degrees_of_freedom: usize,
    reach_mm: f64,
    z0_mm: f64,
    handedness: HandednessName,
    handedness_source: String,
}

/// Reads the frame that `[frame] from` names; `None` without it.
pub(super) fn saved_frame(
    folder: &Folder,
    document: &Document,
    settings: &Settings,
    warnings: &mut Vec<String>,
) -> Result<Option<SavedFrame>, Error> {
    let Some(from) = &settings.frame.from else { return Ok(None) };
    let name = from.get_ref();
    let bytes = folder.named(name, document.at(&from.span()))?;
    let fail = |message: String| {
        let message = format!("[frame] from: {} {message}", quote(name));
        Err(Error::case(document.at(&from.span()), Problem::WrongValue { message }))
    };
    let answer: Answer = match serde_json::from_slice(&bytes) {
        Ok(answer) => answer,
        Err(e) if e.is_data() => {
            return fail(format!(
                "is no answer with a frame to use again ({e}); give what `truing solve --json` or \
                 `truing loop --json` of this version prints for the presses of a calibration"
            ));
        }
        Err(e) => return fail(format!("is not JSON: {e}")),
    };
    if answer.kind != "ft-center" {
        let kind = quote(&answer.kind);
        return fail(format!("is an answer of kind {kind}; expected one of kind `ft-center`"));
    }
    if answer.residual.unit != "mm" {
        return fail(format!("has residuals in {}; expected mm", quote(&answer.residual.unit)));
    }
    if answer.verdict.as_deref() == Some("input-wrong") {
        return fail("is of a loop that found its input wrong; mend it and solve again".to_owned());
    }
    if let Some(step) = answer.steps.iter().find(|s| !IN_THE_FRAME.contains(&s.effect.as_str())) {
        return fail(format!(
            "is of a loop that found {}, which its frame counts as corrected and the wrench of a \
             later press still has; mend the cause and calibrate anew, or give the answer of \
             `truing solve`, whose uncertainties hold for what is as it is",
            quote(&step.effect)
        ));
    }
    let Some(frame) = answer.estimates.frame else {
        return fail("has no frame: it is of displacements or poses, not of presses".to_owned());
    };
    if let Err(message) = frame.agrees(settings) {
        return fail(message);
    }
    if frame.handedness_source == "assumed" {
        let name = quote(name);
        warnings.push(format!(
            "the presses that {name} is of do not tell whether the sensor's z opposes the \
             machine's: off their line a position is a mirror image if it does"
        ));
    }
    let saved = frame.saved();
    match saved.check() {
        Ok(()) => Ok(Some(saved)),
        Err(source) => fail(format!("has a frame that cannot be used: {source}")),
    }
}

impl Frame {
    /// Whether the case says nothing else.
    fn agrees(&self, settings: &Settings) -> Result<(), String> {
        let z0_mm = settings.contact.z0_mm.map(|z0| z0.0);
        // A number that is printed and read is the same one.
        if let Some(z0_mm) = z0_mm.filter(|z0_mm| z0_mm.to_bits() != self.z0_mm.to_bits()) {
            return Err(format!(
                "was found with z0_mm = {}, and the case says {z0_mm}: a frame holds for the contact \
                 plane on which it was found; give that height, or calibrate on the new one",
                self.z0_mm
            ));
        }
        let (saved, given) = (Handedness::from(self.handedness), settings.model.handedness);
        if let Some(given) = given.map(Handedness::from).filter(|given| *given != saved) {
            let word = |h| if h == Handedness::Same { "same" } else { "opposed" };
            return Err(format!(
                "has handedness `{}`, and the case says `{}`; one of them is wrong",
                word(saved),
                word(given)
            ));
        }
        Ok(())
    }

    fn saved(&self) -> SavedFrame {
        let Self { angle_deg, scale, seat_mm, variance_factor, degrees_of_freedom, .. } = *self;
        SavedFrame {
            angle_rad: angle_deg.to_radians(),
            handedness: self.handedness.into(),
            reference_mm: Point2::from(self.reference_mm),
            image_mm: Point2::from(self.image_mm),
            scale,
            covariance: Matrix4::from_fn(|i, j| self.covariance[i][j]),
            seat_mm,
            variance_factor,
            degrees_of_freedom,
            reach_mm: self.reach_mm,
        }
    }
}

/// What is doubtful about presses located far from where the frame was calibrated.
pub(super) fn far_from(
    saved: &SavedFrame,
    places: impl Iterator<Item = (String, Point2<f64>)>,
) -> Vec<String> {
    let far = |(name, at): (String, Point2<f64>)| {
        let distance_mm = (at - saved.reference_mm).norm();
        (distance_mm > FAR * saved.reach_mm).then(|| {
            format!(
                "press {} is {distance_mm:.1} mm from the middle of the calibration, whose presses \
                 reach {:.1} mm: check its unit and that the frame is of this machine",
                quote(&name),
                saved.reach_mm
            )
        })
    };
    places.filter_map(far).collect()
}

/// Times the reach of a calibration beyond which a press is doubtful: a unit of inches for
/// millimetres and back is a factor of 25.
const FAR: f64 = 5.0;

/// Why the loop has nothing to do in a frame that was found before.
pub(super) fn nothing_fitted(at: Location) -> Error {
    let message = "the frame is taken from a solve before, so nothing is fitted here and the loop \
                   has nothing to judge: `truing solve` locates the presses; what is missing shows \
                   in the presses of the calibration";
    Error::case(at, Problem::WrongValue { message: message.to_owned() })
}
