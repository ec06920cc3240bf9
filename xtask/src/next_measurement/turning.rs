//! Rotary axes whose survey does not show what is wrong, and how it goes on.

use std::fmt::Write as _;

use anyhow::{Context, Result};
use serde_json::Value;

use super::scene::{Files, Scene};
use crate::kinds::tracker_lm::targets::{self, Survey};
use crate::kinds::tracker_lm::tracer::{self, Run};
use crate::kinds::tracker_lm::tracer_tables;

/// An angle, degrees, and whether it is reached with rising angles.
type Step = (f64, bool);

/// What measures an axis.
#[derive(Debug)]
pub(super) enum Instrument {
    /// A tracer, ranges.
    Ranges(Run),
    /// Trackers, points.
    Points(Survey),
}

/// A survey of a rotary axis that was only turned upwards, and goes on.
#[derive(Debug)]
pub(super) struct Upwards {
    pub(super) instrument: Instrument,
    /// What the plan is made for.
    pub(super) aim: &'static str,
    /// Times that every angle may be turned to again.
    pub(super) cycles: u8,
}

impl Upwards {
    /// Steps of the first survey.
    fn first(&self) -> Vec<Step> {
        match &self.instrument {
            Instrument::Ranges(run) => tracer::simulate(run).steps,
            Instrument::Points(survey) => targets::simulate(survey).steps,
        }
    }

    /// With the way of every step, which is the same for all of the first.
    fn with(&self, further: Vec<Step>) -> Files {
        let mut files = match &self.instrument {
            Instrument::Ranges(run) => {
                let run = Run { further, ..run.clone() };
                let measured = tracer::simulate(&run);
                tracer_tables::tables(&Run { both_ways: true, ..run }, &measured)
            }
            Instrument::Points(survey) => {
                let survey = Survey { further, ..survey.clone() };
                let measured = targets::simulate(&survey);
                targets::tables(&Survey { both_ways: true, ..survey }, &measured)
            }
        };
        let angles: Vec<String> =
            self.first().iter().map(|(angle, _)| format!("{angle}")).collect();
        let (_, case) = &mut files[0];
        let angles = angles.join(", ");
        let _ = write!(case, "\n[plan]\nangles_deg = [{angles}]\ncycles = {}\n", self.cycles);
        files
    }
}

impl Scene for Upwards {
    fn files(&self) -> Files {
        self.with(Vec::new())
    }

    fn aim(&self) -> Option<&'static str> {
        Some(self.aim)
    }

    fn with_plan(&self, plan: &[Value], _: u64) -> Result<Files> {
        let steps = plan.iter().map(|one| {
            let cell = |name: &str| one["cells"][name].as_f64().context("no angle");
            Ok((cell("angle_deg")?, cell("direction")? > 0.0))
        });
        Ok(self.with(steps.collect::<Result<Vec<_>>>()?))
    }

    /// The same angles again, from the same side.
    fn with_even(&self, count: usize, _: u64) -> Files {
        let steps = self.first();
        self.with((0..count).map(|i| steps[i * steps.len() / count % steps.len()]).collect())
    }
}
