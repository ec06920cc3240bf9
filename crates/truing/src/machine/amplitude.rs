//! Which amplitudes of a case's effects are those of the machine.

use model_discrepancy::{CommonEffect, Effect, Model, Parameter, Scope, ShownAmplitude};

use super::read::Axis;

/// Ending of the ids of effects that go with the course of one session.
const DRIFT: &str = "drift";
/// What makes an effect the machine's in the catalogue of all cases.
pub(super) const MACHINE: &str = "machine";

/// An amplitude of the machine, as one of a case's effect shows it.
struct OfMachine<'e> {
    id: &'e str,
    subject: Option<&'e str>,
    description: &'e str,
    parameter: Parameter,
    /// Internal amplitude of the case over that of the machine.
    factor: f64,
}

/// A case's catalogue, and how the case was measured.
pub(super) struct Catalogue<'m> {
    pub(super) kind: &'static str,
    pub(super) axis: Option<Axis>,
    pub(super) model: &'m dyn Model,
}

/// Effects that two catalogues or more have, by their ids in the machine's words.
pub(super) fn common(catalogues: &[Catalogue<'_>]) -> Vec<CommonEffect> {
    let mut all: Vec<CommonEffect> = Vec::new();
    for (part, catalogue) in catalogues.iter().enumerate() {
        for (effect, own) in catalogue.model.declared().effects.iter().enumerate() {
            for parameter in 0..own.parameters.len() {
                let Some(of) = catalogue.of_machine(own, parameter) else { continue };
                let known = all.iter().position(|common| of.is_of(&common.effect));
                let at = known.unwrap_or_else(|| {
                    all.push(CommonEffect { effect: of.effect(own), shown: Vec::new() });
                    all.len() - 1
                });
                let common = &mut all[at];
                let factor = of.factor;
                let of = of.index(&mut common.effect);
                common.shown.push(ShownAmplitude { part, effect, parameter, of, factor });
            }
        }
    }
    all.retain(|common| common.shown.iter().any(|shown| shown.part != common.shown[0].part));
    all
}

impl Catalogue<'_> {
    /// What an amplitude of an effect says of the machine: that of its axes as the touches of a part
    /// show them, a reading as `(1 + E)` times the truth, in other words where another kind has them.
    fn of_machine<'e>(&self, effect: &'e Effect, parameter: usize) -> Option<OfMachine<'e>> {
        if matches!(effect.scope, Scope::Observation(_)) || effect.searched > 1 {
            return None;
        }
        if effect.id.ends_with(DRIFT) {
            return None;
        }
        let own = &effect.parameters[parameter];
        let scale = |axis: &'static str, factor| OfMachine {
            id: "axis-scale",
            subject: Some(axis),
            description: reads_long(axis),
            parameter: Parameter::new(axis, "ppm", 1e6),
            factor,
        };
        let axis = |name: &str| ["x", "y", "z"].into_iter().find(|axis| *axis == name);
        match (self.kind, effect.id.as_str(), effect.subject.as_deref()) {
            // The machine is the first frame: what it reads long, the fit makes shorter.
            ("frame-fit", "anisotropic-scale", None) => Some(scale(axis(&own.name)?, -1.0)),
            ("frame-fit", "shear", None) => Some(OfMachine {
                id: "squareness",
                subject: None,
                description: "the machine's axes are not square to each other",
                parameter: own.clone(),
                factor: -1.0,
            }),
            // An axis that reads long moves less far than it says.
            ("positioning", "pitch-error", None) => Some(scale(self.axis?.name(), -1.0)),
            ("frame-fit" | "positioning", ..) => None,
            (_, id, subject) => Some(OfMachine {
                id,
                subject,
                description: &effect.description,
                parameter: own.clone(),
                factor: 1.0,
            }),
        }
    }
}

fn reads_long(axis: &str) -> &'static str {
    match axis {
        "x" => "the machine's x axis reads long",
        "y" => "the machine's y axis reads long",
        _ => "the machine's z axis reads long",
    }
}

impl OfMachine<'_> {
    /// What it is called among the effects of all cases.
    fn subject(&self) -> String {
        self.subject.map_or_else(|| MACHINE.to_owned(), |s| format!("{MACHINE}, {s}"))
    }

    fn is_of(&self, common: &Effect) -> bool {
        common.id == self.id
            && common.subject.as_deref() == Some(&self.subject())
            && common.description == self.description
    }

    fn effect(&self, own: &Effect) -> Effect {
        let mut effect = Effect::new(self.id, self.description, Vec::new());
        effect.subject = Some(self.subject());
        effect.scope = Scope::SomeDesigns;
        effect.maximum = own.maximum;
        effect
    }

    /// Where the common effect has it, added where it had not.
    fn index(self, common: &mut Effect) -> usize {
        let known = common.parameters.iter().position(|p| *p == self.parameter);
        known.unwrap_or_else(|| {
            common.parameters.push(self.parameter);
            common.parameters.len() - 1
        })
    }
}
