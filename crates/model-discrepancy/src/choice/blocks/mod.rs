//! The data, seen once: whether anything could be added to a system without some groups.
//!
//! A choice is repeated without each block of groups. What the F test says of all candidates without
//! a block follows from sums of products over all rows, less those over the rows of the block: no
//! number of rows enters. Where by that test nothing passes, no other test could let it pass, and the
//! repetition has its answer; where something does, the rows are asked.

mod along;
pub(crate) mod passing;
mod rows;
mod single;
mod wide;

use nalgebra::DMatrix;

use crate::Covariate;
use crate::algebra::system::{Estimate, System};
use crate::choice::beside::{Beside, Sums};
use crate::choice::screening::constants;
use crate::choice::selected::Selected;
use crate::choice::shapes::Shapes;
use crate::noise::linear::Linear;

use along::Along;
use passing::Passing;
use rows::Rows;
use single::Single;
use wide::Wide;

/// A system, and all that could be added to it, by sums over blocks of groups.
pub(crate) struct Blocks<'a> {
    system: System<'a>,
    /// Sums over all rows, and over those of each block.
    sums: (Sums, Vec<Sums>),
    /// Of each block, whether it leaves out each group.
    left_out: Vec<Vec<bool>>,
    wide: Wide,
    single: Single,
    along: Along<'a>,
}

impl<'a> Blocks<'a> {
    /// Of `system` as fitted at `at` and linearised in `lin`, with blocks of these groups; `None` where
    /// how the rows are weighed depends on which of them there are.
    pub(crate) fn of(
        (covariates, shapes): (&'a [Covariate], &'a [Shapes]),
        banned: &[usize],
        (system, at): (&System<'a>, &Estimate),
        lin: &Linear<'_>,
        groups: &[Vec<usize>],
    ) -> Option<Self> {
        if system.model.declared().between_variance || !system.places().is_empty() {
            return None;
        }
        let left_out: Vec<Vec<bool>> = groups.iter().map(|some| among(lin, some)).collect();
        let rows: Vec<Rows> = left_out.iter().map(|left_out| Rows::of(lin, left_out)).collect();
        let (directions, constants) = (lin.basis.matrix(), constants(lin));
        let clean = lin.clean_residual();
        let of_block = |rows: &Rows| {
            let some = |all: &DMatrix<f64>| all.select_rows(&rows.some);
            Sums::of(&some(&directions), &some(&constants), &clean.select_rows(&rows.some))
        };
        let sums =
            (Sums::of_all(&directions, &constants, &clean), rows.iter().map(of_block).collect());
        Some(Self {
            system: system.clone(),
            sums,
            left_out,
            wide: Wide::of(banned, (system, at), lin, (&directions, &clean), &rows),
            single: Single::of(banned, (system, at), lin, &clean),
            along: Along::of((covariates, shapes), lin, (&constants, &clean), &rows),
        })
    }
}

/// Of every group whether it is among `some`.
fn among(lin: &Linear<'_>, some: &[usize]) -> Vec<bool> {
    let mut among = vec![false; lin.layout.groups.len()];
    for &group in some {
        among[group] = true;
    }
    among
}

/// The choice without one block of groups.
#[derive(Clone, Copy)]
pub(crate) struct WithoutBlock<'b, 'a> {
    /// Of systems that the choice may come to.
    pub(crate) blocks: &'b [Blocks<'a>],
    pub(crate) block: usize,
}

impl WithoutBlock<'_, '_> {
    /// What of the catalogue may be significant at `alpha` beside a system.
    pub(crate) fn passing(&self, system: &System<'_>, alpha: f64) -> Passing {
        let Some((blocks, beside)) = self.beside(system) else { return Passing::Any };
        let left_out = &blocks.left_out[self.block];
        let wide = blocks.wide.passing(&beside, &blocks.single.ids(left_out), (self.block, alpha));
        // Single readings go after what shows in many groups.
        let single_may = || blocks.single.may_pass(&beside, left_out, alpha);
        if matches!(wide, Passing::Nothing) && single_may() { Passing::Any } else { wide }
    }

    /// Whether a shape along a covariate may be.
    pub(crate) fn shape_may_pass(&self, system: &System<'_>, alpha: f64) -> bool {
        let may_pass = |(blocks, beside): (&Blocks<'_>, Beside)| {
            blocks.along.may_pass(&beside, self.block, alpha)
        };
        self.beside(system).is_none_or(may_pass)
    }

    /// Whether other effects may describe the data better than all that were named.
    pub(crate) fn sets_may_be(&self, chosen: &Selected<'_>) -> bool {
        let effects = &chosen.system.model.declared().effects;
        let mut plain = chosen.system.clone();
        let named: Vec<usize> = plain.active.drain(..).map(|active| active.effect).collect();
        if named.iter().any(|&e| effects[e].subject.is_some()) {
            // It may be one bad reading, which stays.
            return true;
        }
        let Some((blocks, beside)) = self.beside(&plain) else { return true };
        let sets = blocks.wide.sets(&beside, self.block, &named);
        sets.is_some_and(|sets| !sets.better().is_empty())
    }

    /// A system without the block; `None` where sums say nothing of it.
    fn beside(&self, system: &System<'_>) -> Option<(&Blocks<'_>, Beside)> {
        let blocks = self.blocks.iter().find(|blocks| blocks.system.is_same(system))?;
        let (all, each) = &blocks.sums;
        Some((blocks, Beside::of(&all.less(&each[self.block]))?))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DVector;

    use super::*;
    use crate::algebra::system::rows_of;
    use crate::choice::context::Context;
    use crate::choice::one_observation::{LocalEstimability, local_effects};
    use crate::choice::score::{Scoring, score_catalogue};
    use crate::choice::score_shapes::strongest_shapes;
    use crate::choice::screening::Screening;
    use crate::choice::selected::{What, what};
    use crate::count::count;
    use crate::model::covariate::with_order;
    use crate::tests::significance::Reach;
    use crate::{
        Declared, Effect, Group, Layout, LinearModel, Options, Parameter, Quantity, Role, Row,
        Scope,
    };

    /// Round-off of sums over some hundred rows, relative.
    const ROUND_OFF: f64 = 1e-8;

    const GROUPS: usize = 16;
    const IN_GROUP: usize = 4;
    const POINTS: usize = GROUPS * IN_GROUP;

    fn wave(i: usize, j: usize) -> f64 {
        (1.3 * count(i) + 0.7 * count(j * j) + 0.9 * count(i * j)).sin()
    }

    /// Points of two components, of which the second is missing at every third, in groups of four and
    /// a group that is a prior; effects with amplitudes that are seen and not seen, twins, one about a
    /// few points, and one for every point.
    fn model() -> LinearModel {
        let components = |point: usize| if point.is_multiple_of(3) { 0..1 } else { 0..2 };
        let mut rows: Vec<Row> = (0..POINTS)
            .flat_map(|observation| {
                let sigma = 0.5 + 0.1 * count(observation % 4);
                components(observation).map(move |component| Row {
                    observation,
                    component,
                    sigma,
                    reported: true,
                })
            })
            .collect();
        rows.push(Row { observation: POINTS, component: 0, sigma: 2.0, reported: false });
        let n = rows.len();
        let groups = (0..=GROUPS).map(|g| Group {
            name: g.to_string(),
            role: if g < GROUPS { Role::Fit } else { Role::Prior },
        });
        let layout = Layout {
            observations: (0..=POINTS).map(|point| point / IN_GROUP).collect(),
            groups: groups.collect(),
            unit: "mm".to_owned(),
            sigma_declared: true,
            rows,
        };
        let parameters = |m: usize| (0..m).map(|_| Parameter::new("a", "mm", 1.0)).collect();
        let mut effects: Vec<Effect> =
            (0..5).map(|e| Effect::new(&format!("wide {e}"), "", parameters(1 + e % 3))).collect();
        let base = DMatrix::from_fn(n, 3, wave);
        let columns = |e: usize| DMatrix::from_fn(n, 1 + e % 3, |i, j| wave(i, 5 + 4 * e + j));
        let mut tangents: Vec<DMatrix<f64>> = (0..5).map(columns).collect();
        // One amplitude that the base holds; a twin.
        tangents[1].set_column(0, &(base.column(0) + 2.0 * base.column(2)));
        tangents[3] = &tangents[0] * 3.0;
        for (e, group) in [(5, 2), (6, 3), (7, 9)] {
            effects.push(Effect::new("of a group", "", parameters(1)).about(&format!("{group}")));
            let of = |i: usize| {
                let point = layout.rows[i].observation;
                // The first moves a second group, too.
                point / IN_GROUP == group || e == 5 && point / IN_GROUP == 7
            };
            let column = |i, _| if of(i) { wave(i, 40) } else { 0.0 };
            tangents.push(DMatrix::from_fn(n, 1, column));
        }
        for point in 0..POINTS {
            let m = components(point).len();
            let effect = Effect::new("bad-point", "", parameters(m)).about(&point.to_string());
            effects.push(effect.within(Scope::Observation(point)));
            tangents.push(DMatrix::identity(m, m));
        }
        let residual = DVector::from_fn(n, |i, _| wave(i, 90) + wave(3 * i, 91));
        LinearModel {
            declared: Declared::new(layout, parameters(3), effects),
            residual,
            base,
            tangents,
            extended: Vec::new(),
        }
    }

    fn is_same(a: f64, b: f64) -> bool {
        (a - b).abs() <= ROUND_OFF * a.abs().max(1e-3)
    }

    /// Without every block, sums say of all candidates what the rows say.
    #[test]
    fn without_a_block_sums_say_what_the_rows_say() {
        let model = model();
        let values = |of: fn(usize) -> f64| (0..=POINTS).map(of).collect::<Vec<_>>();
        let covariates = [
            Covariate::recorded("time_s", Quantity::Time, values(|i| 7.0 * count(i) + wave(i, 3))),
            Covariate::recorded("table_deg", Quantity::Angle, values(|i| 30.0 * count(i % 12))),
            Covariate::recorded("air_c", Quantity::Temperature, values(|i| 20.0 + wave(i, 1))),
        ];
        let covariates = with_order(&model.declared.layout, &covariates);
        let shapes = Shapes::of_all(&model.declared.layout, &covariates);
        let options = Options::default();
        let mut context = Context::open(&model, (&covariates, &shapes), &options, &[]);
        context.thorough = false;
        let keep = vec![true; GROUPS + 1];
        let fitted = |system: &System<'_>, keep: &[bool]| {
            let rows = rows_of(&model.declared.layout, keep);
            system.fit_first(&rows).unwrap()
        };
        // The declared model, and with a wide effect.
        let with = System::declared(&model)
            .with_effect(crate::algebra::system::Active { effect: 2, parameters: vec![0, 2] });
        let groups: Vec<Vec<usize>> = (0..8).map(|b| vec![b, b + 8]).collect();
        let mut told = 0;
        for system in [System::declared(&model), with] {
            let at = fitted(&system, &keep);
            let lin = Linear::of(&system, &at, &keep, &[]);
            let blocks =
                [Blocks::of((&covariates, &shapes), &[], (&system, &at), &lin, &groups).unwrap()];
            for (block, left_out) in groups.iter().enumerate() {
                let rest = (0..=GROUPS).map(|g| !left_out.contains(&g)).collect::<Vec<_>>();
                let at = fitted(&system, &rest);
                let lin = Linear::of(&system, &at, &rest, &[]);
                let scoring = Scoring::new(&context, &system, &at, &lin, 1e-9);
                let (all, each) = &blocks[0].sums;
                let beside = Beside::of(&all.less(&each[block])).unwrap();

                let seen = local_effects(&system, &at, &lin).filter_map(|(_, one)| match one {
                    LocalEstimability::Estimable(local) => Some(local.test.p_value),
                    LocalEstimability::NotEstimable(_) => None,
                });
                let seen: Vec<f64> = seen.collect();
                let single = blocks[0].single.p_values(&beside, &blocks[0].left_out[block]);
                let are_same = single.iter().zip(&seen).all(|(a, b)| is_same(*a, *b));
                assert!(single.len() == seen.len() && are_same, "{single:?} {seen:?}");

                let pass = score_catalogue(&system, &at, &scoring);
                let wide = pass.judged.iter().filter(|j| j.candidate.id != "bad-point");
                assert!(wide.clone().any(|j| j.candidate.reach == Reach::One));
                let wide: Vec<f64> = wide.map(|j| j.adjusted).collect();
                let sums = blocks[0].wide.adjusted(&beside, &["bad-point"], block);
                assert_eq!(sums.len(), wide.len());
                let are_same = sums.iter().zip(&wide).all(|(a, b)| is_same(*a, *b));
                assert!(are_same, "{sums:?} {wide:?}");

                let screening = Screening::new(&lin, &scoring.clean);
                let along = context.along().flat_map(|(covariate, shapes)| {
                    strongest_shapes(&screening, covariate, shapes)
                        .into_iter()
                        .map(|(shape, test)| (shape.tried, test))
                        .collect::<Vec<_>>()
                });
                let along: Vec<_> = along.collect();
                let sums = blocks[0].along.strongest(&beside, block);
                assert_eq!(sums.len(), along.len());
                for ((tried, sums), (of_rows, rows)) in sums.iter().zip(&along) {
                    assert!(is_same(*tried, *of_rows));
                    let p_value = |test: &Option<_>| {
                        test.map_or(1.0, |t: crate::tests::f_test::Significance| t.p_value)
                    };
                    assert!(is_same(p_value(sums), p_value(rows)), "{sums:?} {rows:?}");
                }

                let known = WithoutBlock { blocks: &blocks, block };
                assert!(
                    known.shape_may_pass(&system, 1.0) && !known.shape_may_pass(&system, 1e-12)
                );
                if let Passing::These(these) = known.passing(&system, 0.9) {
                    let wide = pass.judged.iter().filter(|j| j.candidate.id != "bad-point");
                    let of_rows = wide.filter(|j| j.adjusted <= 0.9);
                    let of_rows = of_rows.map(|j| (what(&j.candidate), j.class));
                    let these = these.iter().map(|one| (What::Effect(one.effect), one.class));
                    assert_eq!(these.collect::<Vec<_>>(), of_rows.collect::<Vec<_>>());
                    told += 1;
                }
                assert!(matches!(known.passing(&system, 1e-12), Passing::Nothing));
            }
        }
        assert!(told > 0);
    }

    /// What is not known from sums is left to the rows.
    #[test]
    fn another_system_is_left_to_the_rows() {
        let model = model();
        let system = System::declared(&model);
        let known = WithoutBlock { blocks: &[], block: 0 };
        assert!(matches!(known.passing(&system, 0.0), Passing::Any));
        assert!(known.shape_may_pass(&system, 0.0));
    }
}
