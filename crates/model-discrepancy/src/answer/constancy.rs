//! Do the parameters of the model stay what they are while it is measured?

use nalgebra::DMatrix;

use crate::choice::additivity::centred;
use crate::choice::context::Context;
use crate::count::count;
use crate::levels::CONSTANT;
use crate::noise::linear::Linear;
use crate::tests::significance::{Reach, significance};
use crate::{Covariate, Quantity, Remaining};

/// Most parameters that are asked together: of more, one that changes is lost among the others.
const MOST: usize = 12;
/// Readings for each of them.
const LEAST_READINGS: usize = 4;

/// Parameters, those of what was named included, that grow with the time or the order of measurement, all at
/// once: a part that turns, a stand that tilts by and by.
///
/// A test of constant parameters as of Nyblom (1989), with a straight course. Bonferroni over the columns.
pub(crate) fn inconstant(context: &Context<'_>, lin: &Linear<'_>) -> Option<Remaining> {
    let dim = lin.basis.dim();
    if dim == 0 || dim > MOST || lin.rows.len() < LEAST_READINGS * dim {
        return None;
    }
    let is_course = |c: &&Covariate| matches!(c.quantity, Quantity::Order | Quantity::Time);
    let courses: Vec<_> = context.covariates.iter().filter(is_course).collect();
    let level = CONSTANT / count(courses.len()).max(1.0);
    let columns = lin.basis.matrix();
    let of_course = |c: &&Covariate| {
        let course = centred(lin, c);
        let growing = DMatrix::from_fn(columns.nrows(), dim, |i, j| columns[(i, j)] * course[i]);
        let test = significance(lin, &lin.basis, &growing, Reach::Many, level)?;
        (test.p_value <= level).then(|| Remaining {
            covariate: c.name.clone(),
            shape: "what is fitted changes along it".to_owned(),
            p_value: test.p_value,
        })
    };
    courses.iter().filter_map(of_course).min_by(|a, b| a.p_value.total_cmp(&b.p_value))
}
