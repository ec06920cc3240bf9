use serde::Serialize;

use super::hypothesis::Hypothesis;
use super::misfit::Misfit;
use super::search::Found;
use crate::count::count;
use crate::text_table::number;

/// Rivals of one sort told in the description; all of them are in `indistinguishable_from`.
const MOST_TOLD: usize = 3;
/// Share of a misfit below which it is less.
const CLOSER: f64 = 0.8;

/// A mistake in the input that the data bear out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Suspect {
    /// Id, `input:…`.
    pub effect: String,
    /// File and column.
    pub subject: String,
    /// What to change.
    pub description: String,
    /// Misfit of the case as it stands; `None` where it cannot be fitted.
    pub rms_before: Option<f64>,
    /// Misfit with the change; `None` where the data do not tell what they should have been.
    pub rms_after: Option<f64>,
    /// Unit of both.
    pub unit: &'static str,
    /// Chance of such a gain with no mistake.
    pub p_value: f64,
    /// Other mistakes that would explain the data as well, and the effect that does the same.
    pub indistinguishable_from: Vec<String>,
}

impl Suspect {
    /// Whether the rows that it leaves out were chosen by how badly they fit.
    pub(crate) fn leaves_out_what_misfits(&self) -> bool {
        self.effect == "input:misplaced"
    }

    pub(super) fn of(found: &Found, before: Option<&Misfit>) -> Self {
        let Found { named, after, rivals, .. } = found;
        let mut description = named.description.clone();
        // Changes of several files may read alike: they are told once.
        let (mut others, mut names) = (Vec::<&Hypothesis>::new(), Vec::new());
        for rival in rivals {
            let is_told = |other: &&Hypothesis| other.description == rival.description;
            let is_new = rival.description != description;
            if is_new && !others.iter().any(is_told) {
                others.push(rival);
            }
            let label = rival.label();
            if (is_new || label != named.label()) && !names.contains(&label) {
                names.push(label);
            }
        }
        names.extend(named.physics.map(str::to_owned));
        if !others.is_empty() {
            let told = told(named, &others);
            description = format!("{description}; or as likely: {}", told.join("; or: "));
            if others.len() > told.len() {
                description = format!("{description}; and {} more", others.len() - told.len());
            }
        }
        // What the data show, or the noise, needs no less misfit.
        let p_value = (before.zip(after.as_ref()))
            .map(|(before, after)| (after.share / before.share, count(after.dof)))
            .filter(|(ratio, _)| *ratio < CLOSER)
            .map_or(0.0, |(ratio, dof)| ratio.powf(dof));
        Self {
            effect: named.effect.to_owned(),
            subject: named.subject.clone(),
            description,
            rms_before: before.map(|m| m.rms),
            rms_after: after.map(|m| m.rms),
            unit: before.or(after.as_ref()).map_or("", |m| m.unit),
            p_value,
            indistinguishable_from: names,
        }
    }

    /// What to change, as a warning.
    pub(crate) fn warning(&self) -> String {
        let gain = match (self.rms_before, self.rms_after) {
            (Some(before), Some(after)) if after > 0.0 && after < CLOSER * before => format!(
                " (misfit {} {unit}, with that change {} {unit}: {:.0} times less)",
                number(Some(before)),
                number(Some(after)),
                before / after,
                unit = self.unit
            ),
            _ => String::new(),
        };
        format!("the input looks wrong: {}{gain}", self.description)
    }
}

/// The first rival of every other sort, and where there is none, the first ones.
fn told<'r>(named: &Hypothesis, rivals: &[&'r Hypothesis]) -> Vec<&'r str> {
    let is_first = |i: usize| {
        let effect = rivals[i].effect;
        effect != named.effect && rivals[..i].iter().all(|r| r.effect != effect)
    };
    let mut told: Vec<&Hypothesis> =
        (0..rivals.len()).filter(|&i| is_first(i)).map(|i| rivals[i]).collect();
    if told.is_empty() {
        told.extend(rivals.iter().take(MOST_TOLD).copied());
    }
    told.iter().map(|r| r.description.as_str()).collect()
}
