//! Shapes along covariates, without a block of groups.

use nalgebra::{DMatrix, DVector};

use crate::Covariate;
use crate::choice::beside::Beside;
use crate::choice::blocks::rows::Rows;
use crate::choice::interruption::strongest;
use crate::choice::screening::{
    Course, Followed, Products, products_of, products_of_periods, test,
};
use crate::choice::shape::Shape;
use crate::choice::shapes::Shapes;
use crate::count::count;
use crate::noise::linear::Linear;
use crate::tests::f_test::Significance;

/// Every shape along every covariate.
pub(super) struct Along<'a> {
    followed: Followed,
    /// Whether each row is of each block.
    blocks: Vec<Vec<bool>>,
    covariates: Vec<OneCovariate<'a>>,
}

/// Shapes along one covariate.
struct OneCovariate<'a> {
    single: Family,
    periods: Family,
    apart: Family,
    course: Option<(Course, &'a [f64])>,
}

/// Shapes of a kind.
#[derive(Default)]
struct Family {
    /// How many are looked at to find each.
    tried: Vec<f64>,
    /// Over all rows.
    all: Vec<Products>,
    /// Over the rows of each block.
    blocks: Vec<Vec<Products>>,
}

impl<'a> Along<'a> {
    pub(super) fn of(
        (all, shapes): (&'a [Covariate], &'a [Shapes]),
        lin: &Linear<'_>,
        (constants, clean): (&DMatrix<f64>, &DVector<f64>),
        rows: &[Rows],
    ) -> Self {
        let followed = Followed::of(lin, constants, clean);
        let blocks: Vec<Vec<bool>> = rows.iter().map(|rows| rows.is_one.clone()).collect();
        let of_none = (0..lin.rows.len()).map(|row| !blocks.iter().any(|block| block[row]));
        let rest = of_none.collect();
        let parts: Vec<Followed> =
            blocks.iter().chain([&rest]).map(|some| followed.narrowed(some)).collect();
        let parts: Vec<&Followed> = parts.iter().collect();
        let covariates = all.iter().zip(shapes).map(|(covariate, shapes)| {
            let of_shapes = |some: &[Shape]| {
                let of_each: Vec<_> = some.iter().map(|shape| products_of(&parts, shape)).collect();
                let of_part = |part: usize| of_each.iter().map(|of| of[part].clone()).collect();
                let tried = some.iter().map(|shape| shape.tried).collect();
                Family::of(tried, (0..parts.len()).map(of_part).collect())
            };
            let periods = shapes.periods.as_ref().map(|periods| {
                let tried = vec![periods.tried; periods.parts.len()];
                Family::of(tried, products_of_periods(&parts, covariate, periods))
            });
            OneCovariate {
                single: of_shapes(&shapes.single),
                periods: periods.unwrap_or_default(),
                apart: of_shapes(&shapes.apart),
                course: (!shapes.breaks.is_empty())
                    .then(|| (followed.course(covariate), &shapes.breaks[..])),
            }
        });
        let covariates = covariates.collect();
        Self { followed, blocks, covariates }
    }

    /// Whether any may be significant at `alpha` without a block.
    pub(super) fn may_pass(&self, beside: &Beside, block: usize, alpha: f64) -> bool {
        let found = self.strongest(beside, block);
        let trials: f64 = found.iter().map(|(tried, _)| tried).sum();
        let passes = |test: &Significance| test.p_value * trials <= alpha;
        found.iter().any(|(_, test)| test.as_ref().is_some_and(passes))
    }

    /// How many were tried and the F test, of the single shapes along each covariate and of the
    /// strongest of its periods, levels apart and interruptions.
    pub(super) fn strongest(
        &self,
        beside: &Beside,
        block: usize,
    ) -> Vec<(f64, Option<Significance>)> {
        let found = self.covariates.iter().flat_map(|covariate| {
            let [single, periods, apart] =
                [&covariate.single, &covariate.periods, &covariate.apart]
                    .map(|family| family.without(beside, block));
            let interruption = covariate.course.as_ref().map(|(course, breaks)| {
                (count(breaks.len()), self.interruption(beside, block, (course, breaks)))
            });
            single.into_iter().chain(best(periods)).chain(best(apart)).chain(interruption)
        });
        found.collect()
    }

    /// The strongest interruption.
    fn interruption(
        &self,
        beside: &Beside,
        block: usize,
        (course, breaks): (&Course, &[f64]),
    ) -> Option<Significance> {
        let left_out = Some(&self.blocks[block][..]);
        let tests = |at: &[f64]| -> Vec<Option<Significance>> {
            let products = self.followed.of_breaks(course, at, left_out);
            products.iter().map(|products| test(products, beside)).collect()
        };
        let at =
            strongest(breaks, |at| tests(at).iter().map(|test| power(test.as_ref())).collect())?;
        tests(&[at]).pop()?
    }
}

fn power(test: Option<&Significance>) -> f64 {
    test.map_or(0.0, |test| test.explained)
}

fn best(found: Vec<(f64, Option<Significance>)>) -> Option<(f64, Option<Significance>)> {
    found.into_iter().max_by(|a, b| power(a.1.as_ref()).total_cmp(&power(b.1.as_ref())))
}

impl Family {
    /// From sums over each block, and last over what is in none.
    fn of(tried: Vec<f64>, mut blocks: Vec<Vec<Products>>) -> Self {
        let rest = blocks.pop().unwrap_or_default().into_iter().enumerate();
        let whole = |(i, rest): (usize, Products)| {
            blocks.iter().fold(rest, |sum, block| sum.with(&block[i]))
        };
        Self { tried, all: rest.map(whole).collect(), blocks }
    }

    /// The F test of each without a block, and how many were tried to find it.
    fn without(&self, beside: &Beside, block: usize) -> Vec<(f64, Option<Significance>)> {
        let tried = self.tried.iter().copied();
        let products = self.all.iter().zip(self.blocks.get(block).into_iter().flatten());
        let tests = products.map(|(all, block)| test(&all.less(block), beside));
        tried.zip(tests).collect()
    }
}
