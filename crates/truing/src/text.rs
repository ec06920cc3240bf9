//! Answers as text for people.

use std::fmt;

use truing_report::{shortened, with_size};

use crate::carry::CarriedEffect;
use crate::closed::{Carried, JudgedRms, LoopStep};
use crate::estimated::LoopParameter;
use crate::estimates;
use crate::layout::written;
use crate::monte_carlo::MonteCarlo;
use crate::residual::Residual;
use crate::text_table::{Cell, EXPANDED, TextTable, number, plain, with_uncertainty};
use crate::{Checked, Closed, Detail, Estimates, Layout, LimitDecision, ObservableEffect, Solved};

impl fmt::Display for Solved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl Solved {
    /// The answer for people.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        let Residual { rms, unit, .. } = self.residual;
        if layout.detail == Detail::Headline {
            return writeln!(f, "{}: residual {} {unit} rms", self.kind, number(rms));
        }
        writeln!(f, "{}\n", self.kind)?;
        tables(f, &*self.estimates, layout)?;
        let columns = ["", "rms", "max", "unit", "n", "dof", "chi2/dof", "99.9 % within"];
        let mut table = TextTable::new("residual", &columns);
        table.push(residual_row("fitted", &self.residual));
        if let Some(check) = &self.check {
            table.push(residual_row("only judged", check));
        }
        table.write(f, layout)?;
        if let Some(drawn) = &self.monte_carlo {
            writeln!(f)?;
            drawn_table(drawn).write(f, layout)?;
        }
        if !self.conformity.is_empty() {
            writeln!(f)?;
            write_conformity(f, &self.conformity, layout)?;
        }
        self.lack_of_fit.as_ref().map_or(Ok(()), |test| writeln!(f, "\n{}", test.line()))
    }
}

fn drawn_table(drawn: &MonteCarlo) -> TextTable {
    let columns = ["parameter", "value", EXPANDED, "by draws", "95 % from", "95 % to", "unit"];
    let title = format!("data simulated {} times", drawn.draws - drawn.failed);
    let mut table = TextTable::of_quantities(title, &columns);
    for parameter in &drawn.parameters {
        let [low, high] = parameter.interval_95;
        let known = |value| Cell::Known(value, Some(parameter.std));
        table.push(vec![
            parameter.name.as_str().into(),
            known(parameter.value),
            Cell::Expanded(Some(parameter.linear_std)),
            Cell::Expanded(Some(parameter.std)),
            known(low),
            known(high),
            parameter.unit.as_str().into(),
        ]);
    }
    table
}

fn write_conformity(
    f: &mut dyn fmt::Write,
    decisions: &[LimitDecision],
    layout: Layout,
) -> fmt::Result {
    let Some(first) = decisions.first() else { return Ok(()) };
    let title = format!("conformity, probability of at least {} (JCGM 106)", first.required);
    let columns = ["result", "value", "limit", "guard band", "unit", "within", "decision"];
    let mut table = TextTable::new(title, &columns);
    for d in decisions {
        let share = d.probability.map(|p| format!("{:.1} %", 100.0 * p));
        table.push(vec![
            d.parameter.as_str().into(),
            d.value.map_or_else(|| Cell::from(None), |value| Cell::Known(value, d.std)),
            d.limit.into(),
            d.guard_band.into(),
            d.unit.as_str().into(),
            share.unwrap_or_else(|| "–".to_owned()).into(),
            d.decision.into(),
        ]);
    }
    table.write(f, layout)
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

fn tables(f: &mut dyn fmt::Write, estimates: &dyn Estimates, layout: Layout) -> fmt::Result {
    for table in estimates::tables(estimates) {
        table.write(f, layout)?;
        writeln!(f)?;
    }
    estimates.conditions().iter().try_for_each(|condition| writeln!(f, "note: {condition}"))?;
    if estimates.conditions().is_empty() { Ok(()) } else { writeln!(f) }
}

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl Closed {
    /// The answer for people, the verdict first.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        write_headline(f, self)?;
        if layout.detail == Detail::Headline {
            return Ok(());
        }
        writeln!(f)?;
        if let Some(carried) = &self.carried {
            write_carried(f, carried)?;
        }
        let is_full = layout.detail == Detail::Full;
        if is_full || self.carried.is_some() {
            self.write_errors(f, layout)?;
        }
        if is_full {
            if self.steps.is_empty() {
                writeln!(f, "added: nothing\n")?;
            }
            for (n, step) in self.steps.iter().enumerate() {
                write_step(f, n + 1, step)?;
            }
        }
        self.write_left(f, is_full)?;
        tables(f, &*self.estimates, layout)?;
        if let Some(drawn) = &self.monte_carlo {
            drawn_table(drawn).write(f, layout)?;
            if !self.conformity.is_empty() {
                writeln!(f)?;
            }
        }
        write_conformity(f, &self.conformity, layout)
    }

    fn write_errors(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
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
        let mut table = TextTable::new("error", &columns);
        if let Some(carried) = &self.carried {
            table.push(error_row("without the carried", &carried.without));
        }
        table.push(error_row("before", &self.before));
        table.push(error_row("after", &self.after));
        table.write(f, layout)?;
        writeln!(f)
    }

    /// What the names do not say.
    fn write_left(&self, f: &mut dyn fmt::Write, is_full: bool) -> fmt::Result {
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
        if is_full {
            for unseen in &self.not_observable {
                let by = absorbed_by(&unseen.aliased_with);
                let advice = advice(unseen.separate_by.as_deref());
                writeln!(f, "not observable: {}{by}{advice}", unseen.effect)?;
            }
        } else if !self.not_observable.is_empty() {
            let names: Vec<String> =
                self.not_observable.iter().map(|unseen| unseen.effect.clone()).collect();
            writeln!(f, "not observable in these data (-v says why): {}", shortened(&names))?;
        }
        let is_nothing = self.remaining.is_empty()
            && self.not_observable.is_empty()
            && self.lack_of_fit.is_none();
        if is_nothing { Ok(()) } else { writeln!(f) }
    }
}

fn write_carried(f: &mut dyn fmt::Write, carried: &Carried) -> fmt::Result {
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
    /// Id and subject.
    pub(crate) fn label(&self) -> String {
        labelled(&self.effect, self.subject.as_deref())
    }

    /// Name, what was found, and its sizes.
    pub(crate) fn in_one_line(&self) -> String {
        let coverage = if self.parameters.is_empty() { "" } else { " (k = 2)" };
        format!(
            "{} — {}{}{coverage}",
            self.label(),
            self.in_words(),
            several_sizes(&self.parameters)
        )
    }

    /// What was found, by its sign and with its size.
    pub(crate) fn in_words(&self) -> String {
        let amplitudes: Vec<(f64, f64, &str)> =
            self.parameters.iter().map(|p| (p.value, p.std, p.unit.as_str())).collect();
        plain(&with_size(&self.description, &amplitudes))
    }
}

/// Verdict, names with their sizes and rivals, and the error before and after.
fn write_headline(f: &mut dyn fmt::Write, closed: &Closed) -> fmt::Result {
    writeln!(f, "{}: {}", closed.kind, closed.verdict)?;
    for step in &closed.steps {
        writeln!(f, "  {}", step.in_one_line())?;
        write_rivals(f, step)?;
    }
    let error = |e: &JudgedRms| with_uncertainty(e.held_out_rms, e.held_out_std, &e.unit);
    let (before, after) = (error(&closed.before), error(&closed.after));
    writeln!(f, "error on data the fit never saw: {before} before, {after} after (k = 2)")
}

/// Sizes of an effect with more than one, which its words do not hold.
fn several_sizes(parameters: &[LoopParameter]) -> String {
    if parameters.len() < 2 { String::new() } else { format!(": {}", sizes(parameters)) }
}

/// Amplitudes by their names.
pub(crate) fn sizes(parameters: &[LoopParameter]) -> String {
    let size =
        |p: &LoopParameter| format!("{} {}", p.name, with_uncertainty(p.value, p.std, &p.unit));
    let sizes: Vec<String> = parameters.iter().map(size).collect();
    shortened(&sizes)
}

/// Names that the data cannot tell from that of a step.
fn write_rivals(f: &mut dyn fmt::Write, step: &LoopStep) -> fmt::Result {
    if step.indistinguishable_from.is_empty() {
        return Ok(());
    }
    let rivals = step.indistinguishable_from.join(", ");
    writeln!(f, "  cannot be told apart from: {rivals}{}", advice(step.separate_by.as_deref()))
}

fn write_step(f: &mut dyn fmt::Write, n: usize, step: &LoopStep) -> fmt::Result {
    let name = step.label();
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

pub(crate) fn advice(separate_by: Option<&str>) -> String {
    separate_by.map_or_else(String::new, |text| format!("; to tell: {text}"))
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl Checked {
    /// The answer for people.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
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
        if layout.detail == Detail::Headline {
            return Ok(());
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
            table.write(f, layout)?;
            writeln!(f)?;
        }
        self.write_effects(f, layout)
    }

    fn write_effects(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
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
            table.write(f, layout)?;
            writeln!(f)?;
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

pub(crate) fn labelled(effect: &str, subject: Option<&str>) -> String {
    subject.map_or_else(|| effect.to_owned(), |subject| format!("{effect} [{subject}]"))
}
