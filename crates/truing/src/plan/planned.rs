use std::collections::BTreeMap;

use serde::Serialize;
use truing_report::shortened;

use crate::Header;

/// Answer of `truing plan`; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Planned {
    /// Kind of the case.
    pub kind: &'static str,
    /// Version of this crate.
    pub version: &'static str,
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// What the plan is for: `rivals`, `unobservable`, `all`, or names of effects and quantities.
    pub aim: String,
    /// What one measurement is called.
    pub noun: &'static str,
    /// Measurements there are.
    pub measured: usize,
    /// Measurements planned.
    pub planned: usize,
    /// What they take, where `[plan] minutes_per_measurement` says it.
    pub minutes: Option<f64>,
    /// Whether the plan reaches its aim.
    pub reached: bool,
    /// What would reach it, where the plan does not.
    pub would: Option<String>,
    /// Effects of the aim with the names that hold them as a part of themselves: no measurement tells
    /// these apart, and the plan is made to tell all of them together from the others.
    pub classes: Vec<PlanClass>,
    /// The figure that the plan changes least, or the only one.
    pub predicted: Option<Prediction>,
    /// What is known without and with the plan.
    pub figures: Vec<PlanFigure>,
    /// What to measure, in this order.
    pub plan: Vec<PlannedMeasurement>,
    /// The rows to be added to the table of the case, by column; what is to be measured is empty.
    pub measurements: Vec<BTreeMap<String, String>>,
    /// The program that was written for a machine; `None` where none was.
    pub program: Option<String>,
    /// Notes the user should read.
    pub warnings: Vec<String>,
    /// Files to work by: name and content.
    #[serde(skip)]
    pub files: Vec<(String, String)>,
}

/// Names that are one answer, however much is measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanClass {
    /// The effect that was asked for.
    pub effect: String,
    /// Effects that hold it as a part of themselves.
    pub with: Vec<String>,
}

impl PlanClass {
    pub(super) fn words(&self, noun: &str) -> String {
        let Self { effect, with } = self;
        let [verb, itself] =
            if with.len() == 1 { ["holds", "itself"] } else { ["hold", "themselves"] };
        let with = shortened(with);
        format!(
            "no {noun} tells {effect} from {with}, which {verb} it as a part of {itself}: the plan is \
             for the class of them, and tells it from all other effects"
        )
    }
}

/// What a plan is worth in one figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Of what.
    pub of: String,
    /// As in [`PlanFigure`].
    pub measure: &'static str,
    /// With what is measured; `None` where it is not observable.
    pub before: Option<f64>,
    /// With the plan too.
    pub after: Option<f64>,
    /// Unit of both.
    pub unit: String,
}

impl Prediction {
    /// Of probabilities the lowest with the plan, of sizes and uncertainties the one that falls
    /// least.
    pub(super) fn of(figures: &[PlanFigure]) -> Option<Self> {
        let kept = |f: &&PlanFigure| match (f.measure, f.before, f.after) {
            (_, _, None) => f64::INFINITY,
            ("probability", _, Some(after)) => -after,
            (_, Some(before), Some(after)) => after / before,
            (_, None, Some(_)) => 0.0,
        };
        let worst = figures.iter().max_by(|a, b| kept(a).total_cmp(&kept(b)))?;
        let PlanFigure { of, measure, before, after, unit } = worst.clone();
        Some(Self { of, measure, before, after, unit })
    }
}

/// One thing that is asked, before and after.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanFigure {
    /// Of what.
    pub of: String,
    /// `probability` of telling apart, `detectable` size found nine times in ten, or expanded
    /// `uncertainty` (k = 2).
    pub measure: &'static str,
    /// With what is measured; `None` where it is not observable.
    pub before: Option<f64>,
    /// With the plan too.
    pub after: Option<f64>,
    /// Unit of both.
    pub unit: String,
}

/// One measurement to make.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedMeasurement {
    /// Name of its row.
    pub name: String,
    /// Cells that are planned, by column; of readings, what the declared model expects.
    pub cells: BTreeMap<&'static str, f64>,
    /// The touch that it is, where it is one.
    pub touch: Option<PlannedTouchPlace>,
}

/// Where and how a part is to be touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlannedTouchPlace {
    /// Nominal contact, in coordinates of the part.
    pub contact_mm: [f64; 3],
    /// Unit normal there, towards the ball.
    pub normal: [f64; 3],
    /// Centre of the ball, in coordinates of the machine.
    pub ball_mm: [f64; 3],
    /// From the ball towards the part, in coordinates of the machine.
    pub approach: [f64; 3],
    /// Feed of the touch.
    pub feed_mm_per_min: f64,
}
