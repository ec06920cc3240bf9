//! Several data sets of one machine, with amplitudes in common.

use nalgebra::{DMatrix, DVector, Vector3};

use super::{
    Cells, Declared, Effect, Group, Inside, Layout, Model, Parameter, Projected, Proposal,
    Remaining, Row, Scope, State, whole_tangent,
};

/// One data set.
pub struct JointPart<'m> {
    /// Name as the user knows it; it stands before the names of groups, parameters and effects.
    pub name: String,
    /// Its model.
    pub model: &'m dyn Model,
    /// Factor on its sigmas: 1 where they were declared, else the noise that was found.
    pub noise_ratio: f64,
}

/// An effect of the machine, which several parts show.
#[derive(Clone, Debug)]
pub struct CommonEffect {
    /// What it is called; its amplitudes are those of the machine.
    pub effect: Effect,
    /// Its amplitudes in the parts.
    pub shown: Vec<ShownAmplitude>,
}

/// An amplitude of an effect of a part that is one of the machine's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownAmplitude {
    /// Index into the parts.
    pub part: usize,
    /// Index into the catalogue of the part.
    pub effect: usize,
    /// Index into the amplitudes of that effect.
    pub parameter: usize,
    /// Index into the amplitudes of the common effect.
    pub of: usize,
    /// Amplitude of the part over that of the machine, internal units.
    pub factor: f64,
}

/// Several models in one: base parameters of each, the common effects, and the catalogue of each.
///
/// An effect of a part that is shown by a common one stands in the catalogue on its own as well: what
/// only one part shows is not of the machine. Groups are left out as in the parts. All report one unit.
/// It proposes no measurement; the parts do.
pub struct Joint<'m> {
    parts: Vec<JointPart<'m>>,
    common: Vec<CommonEffect>,
    declared: Declared,
    /// Where each part begins.
    begins: Vec<Begin>,
}

/// Indices of the first row, observation, group, base parameter and effect of a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Begin {
    row: usize,
    observation: usize,
    group: usize,
    base: usize,
    effect: usize,
    record: usize,
}

impl<'m> Joint<'m> {
    /// Of parts whose residuals have one unit; `None` of others, and of none.
    #[must_use]
    pub fn new(parts: Vec<JointPart<'m>>, common: Vec<CommonEffect>) -> Option<Self> {
        let unit = parts.first()?.model.declared().layout.unit.clone();
        if parts.iter().any(|part| part.model.declared().layout.unit != unit) {
            return None;
        }
        let mut at = Begin { effect: common.len(), ..Begin::default() };
        let begins: Vec<Begin> = (parts.iter())
            .map(|part| {
                let begin = at;
                at = begin.after(part.model.declared());
                begin
            })
            .collect();
        let declared = joined(&parts, &common, &begins, unit);
        Some(Self { parts, common, declared, begins })
    }

    /// The model of a part.
    #[must_use]
    pub fn part(&self, part: usize) -> &dyn Model {
        self.parts[part].model
    }

    /// Rows of a part in the layout.
    #[must_use]
    pub fn rows(&self, part: usize) -> std::ops::Range<usize> {
        let first = self.begins[part].row;
        first..first + self.parts[part].model.declared().layout.rows.len()
    }

    /// The state of a part in a state of all.
    #[must_use]
    pub fn of_part(&self, part: usize, at: &State) -> State {
        let (begin, declared) = (self.begins[part], self.parts[part].model.declared());
        let base = at.base.rows(begin.base, declared.base.len()).into_owned();
        let effects = begin.effect..begin.effect + declared.effects.len();
        let mut amplitudes = at.amplitudes[effects].to_vec();
        for (common, machine) in self.common.iter().zip(&at.amplitudes) {
            for shown in common.shown.iter().filter(|shown| shown.part == part) {
                amplitudes[shown.effect][shown.parameter] += shown.factor * machine[shown.of];
            }
        }
        State { base, amplitudes }
    }

    /// The part that an effect of the catalogue belongs to, and its index there.
    fn owner(&self, effect: usize) -> Option<(usize, usize)> {
        let part = self.begins.iter().rposition(|begin| begin.effect <= effect)?;
        Some((part, effect - self.begins[part].effect))
    }
}

impl std::fmt::Debug for JointPart<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("JointPart").field("name", &self.name).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for Joint<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Joint").field("parts", &self.parts).finish_non_exhaustive()
    }
}

impl Begin {
    fn after(self, part: &Declared) -> Self {
        let Layout { rows, observations, groups, .. } = &part.layout;
        let records = part.records.iter().flatten().max().map_or(1, |last| last + 1);
        Self {
            row: self.row + rows.len(),
            observation: self.observation + observations.len(),
            group: self.group + groups.len(),
            base: self.base + part.base.len(),
            effect: self.effect + part.effects.len(),
            record: self.record + records,
        }
    }
}

impl Model for Joint<'_> {
    fn declared(&self) -> &Declared {
        &self.declared
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        let mut all = DVector::zeros(self.declared.layout.rows.len());
        for (k, part) in self.parts.iter().enumerate() {
            let own = part.model.residuals(&self.of_part(k, at));
            all.rows_mut(self.begins[k].row, own.len()).copy_from(&own);
        }
        all
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(self.declared.layout.rows.len(), self.declared.base.len());
        for (k, part) in self.parts.iter().enumerate() {
            let own = part.model.base_jacobian(&self.of_part(k, at));
            let first = (self.begins[k].row, self.begins[k].base);
            all.view_mut(first, own.shape()).copy_from(&own);
        }
        all
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        let rows = self.declared.layout.rows.len();
        let mut all = DMatrix::zeros(rows, self.declared.effects[effect].parameters.len());
        if let Some(common) = self.common.get(effect) {
            for shown in &common.shown {
                let part = &self.parts[shown.part];
                let own = whole_tangent(part.model, &self.of_part(shown.part, at), shown.effect);
                let mut column = all.column_mut(shown.of);
                let mut column = column.rows_mut(self.begins[shown.part].row, own.nrows());
                column += own.column(shown.parameter) * shown.factor;
            }
            return all;
        }
        let Some((part, own)) = self.owner(effect) else { return all };
        let tangent = self.parts[part].model.tangent(&self.of_part(part, at), own);
        if matches!(self.declared.effects[effect].scope, Scope::Observation(_)) {
            return tangent;
        }
        all.rows_mut(self.begins[part].row, tangent.nrows()).copy_from(&tangent);
        all
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        let each = (self.parts.iter().enumerate())
            .map(|(k, part)| part.model.inside(&self.of_part(k, at)))
            .collect::<Option<Vec<Inside>>>()?;
        let dof: f64 = each.iter().map(|inside| inside.dof).sum();
        let independent: f64 = each.iter().map(|inside| inside.dof * inside.share).sum();
        let chi2 = each.iter().map(|inside| inside.chi2).sum();
        Some(Inside { chi2, dof, share: if dof > 0.0 { independent / dof } else { 1.0 } })
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        Vec::new()
    }
}

fn joined(
    parts: &[JointPart<'_>],
    common: &[CommonEffect],
    begins: &[Begin],
    unit: String,
) -> Declared {
    let mut all = Declared {
        layout: Layout { unit, sigma_declared: true, ..Layout::default() },
        effects: common.iter().map(|common| common.effect.clone()).collect(),
        resolution: f64::INFINITY,
        ..Declared::default()
    };
    let rows: usize = parts.iter().map(|part| part.model.declared().layout.rows.len()).sum();
    let any = |has: fn(&Declared) -> bool| parts.iter().any(|part| has(part.model.declared()));
    let (in_records, at_places) = (any(|d| d.records.is_some()), any(|d| d.places.is_some()));
    let is_one_way = parts.iter().all(|part| part.model.declared().directions.is_some());
    let (mut records, mut places) = (Vec::new(), Vec::new());
    let mut directions: Vec<Vector3<f64>> = Vec::new();
    let mut start = Vec::new();
    for (part, begin) in parts.iter().zip(begins) {
        let own = part.model.declared();
        let named = |name: &str| format!("{}: {name}", part.name);
        let n = own.layout.observations.len();
        all.layout.rows.extend(own.layout.rows.iter().map(|row| Row {
            observation: begin.observation + row.observation,
            sigma: row.sigma * part.noise_ratio,
            ..*row
        }));
        all.layout.observations.extend(own.layout.observations.iter().map(|g| begin.group + g));
        let groups = own.layout.groups.iter();
        all.layout.groups.extend(groups.map(|g| Group { name: named(&g.name), role: g.role }));
        all.layout.sigma_declared &= own.layout.sigma_declared;
        let base = own.base.iter();
        all.base.extend(base.map(|p| Parameter { name: named(&p.name), ..p.clone() }));
        start.extend_from_slice(own.start.as_slice());
        all.effects.extend(own.effects.iter().map(|effect| of_part(effect, part, begin, rows)));
        all.findings.extend(
            own.findings.iter().map(|f| Remaining { covariate: named(&f.covariate), ..f.clone() }),
        );
        all.between_variance |= own.between_variance;
        let record = |i: usize| own.records.as_ref().map_or(0, |records| records[i]);
        records.extend((0..n).map(|i| begin.record + record(i)));
        // Without places of its own every observation of a part stands alone.
        let place = |i: usize| own.places.as_ref().map_or(i, |places| places[i]);
        places.extend((0..n).map(|i| begin.observation + place(i)));
        directions.extend(own.directions.iter().flatten());
        all.projected.extend(own.projected.iter().map(|projected| {
            Projected {
                first_row: begin.row + projected.first_row,
                readings: (projected.readings.iter())
                    .map(|(o, component)| (begin.observation + o, *component))
                    .collect(),
                combination: projected.combination.clone(),
            }
        }));
        all.resolution = all.resolution.min(own.resolution);
    }
    all.cells = cells(parts, begins, all.layout.observations.len());
    all.start = DVector::from_vec(start);
    all.records = in_records.then_some(records);
    all.places = at_places.then_some(places);
    all.directions = is_one_way.then_some(directions);
    all
}

/// The cells of every part; of what is not of it each observation stands alone.
fn cells(parts: &[JointPart<'_>], begins: &[Begin], n: usize) -> Vec<Cells> {
    let of_part = |(part, begin): (&JointPart<'_>, &Begin)| {
        let own = &part.model.declared().cells;
        let of_all = |cells: &Cells| {
            let mut of_observation: Vec<usize> = (n..2 * n).collect();
            for (i, cell) in cells.of_observation.iter().enumerate() {
                of_observation[begin.observation + i] = *cell;
            }
            Cells { what: format!("{}: {}", part.name, cells.what), of_observation }
        };
        own.iter().map(of_all).collect::<Vec<_>>()
    };
    parts.iter().zip(begins).flat_map(of_part).collect()
}

/// An effect of a part among those of all.
fn of_part(effect: &Effect, part: &JointPart<'_>, begin: &Begin, rows: usize) -> Effect {
    let subject = effect.subject.as_ref();
    let mut all = effect.clone();
    all.subject =
        Some(subject.map_or_else(|| part.name.clone(), |s| format!("{}, {s}", part.name)));
    all.driver = effect.driver.as_ref().map(|driver| format!("{}: {driver}", part.name));
    if let Scope::Observation(observation) = effect.scope {
        all.scope = Scope::Observation(begin.observation + observation);
    }
    all.by_place = (effect.by_place.iter())
        .map(|own| {
            let mut by_place = DMatrix::zeros(rows, own.ncols());
            by_place.rows_mut(begin.row, own.nrows()).copy_from(own);
            by_place
        })
        .collect();
    all
}
