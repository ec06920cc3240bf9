//! Answers as text for people.

use std::fmt;

use truing_report::{MOST_NAMES, shortened, with_size};

use crate::carry::CarriedEffect;
use crate::closed::{Carried, JudgedRms, LoopStep};
use crate::estimated::LoopParameter;
use crate::estimates;
use crate::residual::Residual;
use crate::text_table::{Cell, EXPANDED, TextTable, number, plain, with_uncertainty};
use crate::{Checked, Closed, Estimates, ObservableEffect, Solved};

impl fmt::Display for Solved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.kind)?;
        tables(f, &*self.estimates)?;
        let columns = ["", "rms", "max", "unit", "n", "dof", "chi2/dof", "99.9 % within"];
        let mut table = TextTable::new("residual", &columns);
        table.push(residual_row("fitted", &self.residual));
        if let Some(check) = &self.check {
            table.push(residual_row("only judged", check));
        }
        write!(f, "{table}")?;
        self.lack_of_fit.as_ref().map_or(Ok(()), |test| writeln!(f, "\n{}", test.line()))
    }
}

fn residual_row(name: &str, residual: &Residual) -> Vec<Cell> {
    vec![
        name.into(),
        residual.rms.into(),
        residual.max_abs.into(),
        residual.unit.into(),
        residual.n.to_string().into(),
        residual.dof.to_string().into(),
        residual.chi2_per_dof.into(),
        interval(residual.chi2_interval).into(),
    ]
}

/// Where χ²/dof lies where the noise is as declared.
fn interval(of: Option<[f64; 2]>) -> String {
    of.map_or_else(|| "–".to_owned(), |[low, high]| format!("{low:.2} … {high:.2}"))
}

fn tables(f: &mut fmt::Formatter<'_>, estimates: &dyn Estimates) -> fmt::Result {
    estimates::tables(estimates).iter().try_for_each(|table| writeln!(f, "{table}"))?;
    estimates.conditions().iter().try_for_each(|condition| writeln!(f, "note: {condition}"))?;
    if estimates.conditions().is_empty() { Ok(()) } else { writeln!(f) }
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.kind)?;
        write_headline(f, self)?;
        let columns = [
            "",
            "train rms",
            "held-out rms",
            "std",
            "unit",
            "chi2/dof",
            "99.9 % within",
            "held out",
        ];
        if let Some(carried) = &self.carried {
            write_carried(f, carried)?;
        }
        let mut table = TextTable::new("error", &columns);
        if let Some(carried) = &self.carried {
            table.push(error_row("without the carried", &carried.without));
        }
        table.push(error_row("before", &self.before));
        table.push(error_row("after", &self.after));
        writeln!(f, "{table}")?;
        if self.steps.is_empty() {
            writeln!(f, "added: nothing\n")?;
        }
        for (n, step) in self.steps.iter().enumerate() {
            write_step(f, n + 1, step)?;
        }
        if let Some(test) = &self.lack_of_fit {
            writeln!(f, "{}", test.line())?;
        }
        for left in &self.remaining {
            writeln!(
                f,
                "left in the residual, {}: {} (p = {})",
                left.covariate,
                left.shape,
                p_value(left.p_value)
            )?;
        }
        for unseen in &self.not_observable {
            let by = absorbed_by(&unseen.aliased_with);
            let advice = advice(unseen.separate_by.as_deref());
            writeln!(f, "not observable: {}{by}{advice}", unseen.effect)?;
        }
        if !(self.remaining.is_empty()
            && self.not_observable.is_empty()
            && self.lack_of_fit.is_none())
        {
            writeln!(f)?;
        }
        tables(f, &*self.estimates)
    }
}

fn write_carried(f: &mut fmt::Formatter<'_>, carried: &Carried) -> fmt::Result {
    for line in carried.lines() {
        writeln!(f, "{line}")?;
    }
    writeln!(f)
}

impl Carried {
    /// One line per effect.
    pub(crate) fn lines(&self) -> Vec<String> {
        let line = |effect: &CarriedEffect| {
            let of =
                |p: &LoopParameter| format!("{} = {} {}", p.name, number(Some(p.value)), p.unit);
            let sizes: Vec<String> = effect.parameters.iter().map(of).collect();
            let name = labelled(&effect.effect, effect.subject.as_deref());
            let names = [&[name], &effect.indistinguishable_from[..]].concat().join(" or ");
            format!("carried from {}: {names}, {}", self.from, sizes.join(", "))
        };
        self.effects.iter().map(line).collect()
    }
}

fn error_row(name: &str, error: &JudgedRms) -> Vec<Cell> {
    vec![
        name.into(),
        error.train_rms.into(),
        error.held_out_rms.into(),
        error.held_out_std.into(),
        error.unit.clone().into(),
        error.chi2_per_dof.into(),
        interval(error.chi2_interval).into(),
        error.hold_out.into(),
    ]
}

impl LoopStep {
    /// What was found, by its sign and with its size.
    fn in_words(&self) -> String {
        let amplitudes: Vec<(f64, f64, &str)> =
            self.parameters.iter().map(|p| (p.value, p.std, p.unit.as_str())).collect();
        plain(&with_size(&self.description, &amplitudes))
    }
}

/// Verdict, names with their sizes, and the error before and after, in one line each.
fn write_headline(f: &mut fmt::Formatter<'_>, closed: &Closed) -> fmt::Result {
    writeln!(f, "verdict: {}", closed.verdict)?;
    for step in &closed.steps {
        let name = labelled(&step.effect, step.subject.as_deref());
        let size =
            |p: &LoopParameter| format!("{} {}", p.name, with_uncertainty(p.value, p.std, &p.unit));
        let sizes: Vec<String> = step.parameters.iter().take(MOST_NAMES).map(size).collect();
        writeln!(f, "  {name}: {} (k = 2)", sizes.join(", "))?;
    }
    let error = |e: &JudgedRms| with_uncertainty(e.held_out_rms, e.held_out_std, &e.unit);
    let (before, after) = (error(&closed.before), error(&closed.after));
    writeln!(f, "error on data the fit never saw: {before} before, {after} after (k = 2)\n")
}

fn write_step(f: &mut fmt::Formatter<'_>, n: usize, step: &LoopStep) -> fmt::Result {
    let name = labelled(&step.effect, step.subject.as_deref());
    let what = if step.effect.starts_with("input:") { "wrong input" } else { "added" };
    writeln!(f, "{what} {n}: {name} — {}", step.in_words())?;
    for p in &step.parameters {
        writeln!(f, "  {} = {} (k = 2)", p.name, with_uncertainty(p.value, p.std, &p.unit))?;
    }
    writeln!(
        f,
        "  p = {}, held-out rms then {}",
        p_value(step.p_value),
        number(Some(step.held_out_rms))
    )?;
    if !step.indistinguishable_from.is_empty() {
        let rivals = step.indistinguishable_from.join(", ");
        writeln!(
            f,
            "  cannot be told apart from: {rivals}{}",
            advice(step.separate_by.as_deref())
        )?;
    }
    writeln!(f)
}

fn p_value(p: f64) -> String {
    format!("{p:.2e}")
}

fn absorbed_by(parameters: &[String]) -> String {
    if parameters.is_empty() {
        "; it leaves no trace in these data".to_owned()
    } else {
        format!("; absorbed by {}", shortened(parameters))
    }
}

fn advice(separate_by: Option<&str>) -> String {
    separate_by.map_or_else(String::new, |text| format!("; to tell: {text}"))
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let c = &self.counts;
        writeln!(f, "{}\n", self.kind)?;
        writeln!(
            f,
            "{} observations; {} groups fitted, {} only judged",
            c.observations, c.fit_groups, c.check_groups
        )?;
        writeln!(
            f,
            "{} equations for {} parameters: {} degrees of freedom",
            c.equations, c.parameters, c.dof
        )?;
        writeln!(f, "noise: {}", if self.noise_declared { "declared" } else { "estimated" })?;
        for suspect in &self.suspects {
            writeln!(
                f,
                "\nsuspect: {} [{}] — {}",
                suspect.effect, suspect.subject, suspect.description
            )?;
        }
        if !self.covariates.is_empty() {
            writeln!(f, "searched for structure along: {}", self.covariates.join(", "))?;
        }
        if let Some(chi2) = self.residual.chi2_per_dof {
            let within = interval(self.residual.chi2_interval);
            writeln!(f, "chi2/dof: {}, 99.9 % within {within}", number(Some(chi2)))?;
        }
        if let Some(test) = &self.lack_of_fit {
            writeln!(f, "{}", test.line())?;
        }
        writeln!(f)?;
        if !self.parameters.is_empty() {
            let columns = ["parameter", "value", EXPANDED, "unit"];
            let mut table = TextTable::of_quantities("determined", &columns);
            for p in &self.parameters {
                table.push(vec![
                    p.name.clone().into(),
                    Cell::Known(p.value, p.std),
                    Cell::Expanded(p.std),
                    p.unit.into(),
                ]);
            }
            writeln!(f, "{table}")?;
        }
        self.write_effects(f)
    }
}

impl Checked {
    fn write_effects(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.observable.is_empty() {
            let columns = ["effect", "parameter", "smallest size", "unit", "absorbed", "same as"];
            let title = "would be named, 9 times in 10, from this size";
            let mut table = TextTable::of_quantities(title, &columns);
            for (effect, things) in families(&self.observable) {
                let name = if things > 1 {
                    format!("{} (hardest of {things})", effect.effect)
                } else {
                    labelled(&effect.effect, effect.subject.as_deref())
                };
                for size in &effect.detectable {
                    table.push(vec![
                        name.clone().into(),
                        size.name.clone().into(),
                        size.value.into(),
                        size.unit.clone().into(),
                        format!("{:.0} %", 100.0 * effect.absorbed).into(),
                        effect.same_as.join(", ").into(),
                    ]);
                }
            }
            writeln!(f, "{table}")?;
        }
        for effect in &self.not_observable {
            let by = absorbed_by(&effect.aliased_with);
            let advice = advice(effect.separate_by.as_deref());
            let name = labelled(&effect.effect, effect.subject.as_deref());
            writeln!(f, "would not be found: {name}{by}{advice}")?;
        }
        Ok(())
    }
}

/// One entry per effect: of candidates about one thing each, the hardest to see.
fn families(effects: &[ObservableEffect]) -> Vec<(&ObservableEffect, usize)> {
    let mut families: Vec<(&ObservableEffect, usize)> = Vec::new();
    for effect in effects {
        match families.iter_mut().find(|(known, _)| known.effect == effect.effect) {
            Some((hardest, things)) => {
                *things += 1;
                if effect.detectable_rms > hardest.detectable_rms {
                    *hardest = effect;
                }
            }
            None => families.push((effect, 1)),
        }
    }
    families
}

fn labelled(effect: &str, subject: Option<&str>) -> String {
    subject.map_or_else(|| effect.to_owned(), |subject| format!("{effect} [{subject}]"))
}
