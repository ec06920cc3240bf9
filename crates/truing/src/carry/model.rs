use std::sync::Arc;

use model_discrepancy::{Closure, Declared, Effect, Inside, Model, Proposal, Solution, State};
use nalgebra::{DMatrix, DVector};

use crate::measured::{About, Prepared};

/// The case's model with effects of fixed size in what counts as declared.
///
/// An amplitude of this model is what an effect has on top of what was carried.
struct Carrying<'c> {
    inner: Arc<dyn Model + Send + 'c>,
    carried: Vec<DVector<f64>>,
}

/// What the loop needs, with `carried` amplitudes in the declared model.
pub(crate) fn carrying(prepared: Prepared<'_>, carried: Vec<DVector<f64>>) -> Prepared<'_> {
    let Prepared { model, covariates, estimates, about } = prepared;
    let own = carried.clone();
    let estimates = Box::new(move |closure: &Closure| {
        let state = with(&closure.state, &own);
        estimates(&Closure { state, ..closure.clone() })
    });
    let own = carried.clone();
    let known = model.declared().effects.clone();
    let about = about.map(|about| -> About<'_> {
        Box::new(move |found| {
            let on_top = Solution { state: with(&found.state, &own), ..found.clone() };
            let Some(there) = about(&on_top)? else { return Ok(None) };
            // What is found by looking may be other effects there.
            let of_effect = |effect: &Effect| {
                let is_it = |k: &Effect| k.id == effect.id && k.subject == effect.subject;
                let carried = known.iter().position(is_it).map(|k| own[k].clone());
                carried.unwrap_or_else(|| DVector::zeros(effect.parameters.len()))
            };
            let carried = there.model.declared().effects.iter().map(of_effect).collect();
            Ok(Some(carrying(there, carried)))
        })
    });
    Prepared { model: Arc::new(Carrying { inner: model, carried }), covariates, estimates, about }
}

fn with(at: &State, carried: &[DVector<f64>]) -> State {
    let amplitudes = at.amplitudes.iter().zip(carried).map(|(a, c)| a + c).collect();
    State { base: at.base.clone(), amplitudes }
}

impl Model for Carrying<'_> {
    fn declared(&self) -> &Declared {
        self.inner.declared()
    }

    fn residuals(&self, at: &State) -> DVector<f64> {
        self.inner.residuals(&with(at, &self.carried))
    }

    fn base_jacobian(&self, at: &State) -> DMatrix<f64> {
        self.inner.base_jacobian(&with(at, &self.carried))
    }

    fn tangent(&self, at: &State, effect: usize) -> DMatrix<f64> {
        self.inner.tangent(&with(at, &self.carried), effect)
    }

    fn inside(&self, at: &State) -> Option<Inside> {
        self.inner.inside(&with(at, &self.carried))
    }

    fn proposals(&self) -> Vec<Proposal<'_>> {
        self.inner.proposals()
    }
}

#[cfg(test)]
mod tests {
    use model_discrepancy::{Options, close_loop};

    use super::*;

    /// Everything that the loop answers.
    fn answer(prepared: &Prepared<'_>) -> String {
        // The choice repeated without each group sees the model by the same few functions.
        let options = Options { nested: false, ..Options::default() };
        let closure = close_loop(&*prepared.model, &prepared.covariates, &options).unwrap();
        format!("{closure:#?}\n{:#?}", (prepared.estimates)(&closure))
    }

    /// Every case of a kind with all its effects carried at size zero, beside the case as it is.
    fn carrying_zero_changes_nothing(kind: &str) {
        let cases = format!("{}/../../fixtures/{kind}", env!("CARGO_MANIFEST_DIR"));
        let mut n = 0;
        for case in std::fs::read_dir(cases).unwrap() {
            let path = case.unwrap().path();
            if !path.join("case.toml").exists() {
                continue;
            }
            let case = crate::read_case(&path).unwrap();
            let plain = case.prepare().unwrap().0;
            let zeros = State::start(&*plain.model).amplitudes;
            let carried = carrying(case.prepare().unwrap().0, zeros);
            let (plain, carried) = (answer(&plain), answer(&carried));
            let differs = plain.lines().zip(carried.lines()).find(|(a, b)| a != b);
            assert!(plain == carried, "{}: {differs:?}", path.display());
            n += 1;
        }
        assert!(n > 5, "{n} cases of {kind}");
    }

    #[test]
    fn zero_carried_changes_no_frame() {
        carrying_zero_changes_nothing("frame-fit");
    }

    #[test]
    fn zero_carried_changes_no_press() {
        carrying_zero_changes_nothing("ft-center");
    }

    #[test]
    fn zero_carried_changes_no_axis() {
        carrying_zero_changes_nothing("tracker-lm");
    }

    #[test]
    fn zero_carried_changes_no_pose() {
        carrying_zero_changes_nothing("pose-icp");
    }

    #[test]
    fn zero_carried_changes_no_probe() {
        carrying_zero_changes_nothing("probe-comp");
    }

    #[test]
    fn zero_carried_changes_no_head() {
        carrying_zero_changes_nothing("force-impedance");
    }
}
