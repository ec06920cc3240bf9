//! Published displacements: Table 4 of [A].

use ft_center::{Displacement, DisplacementModel, FtCenterError, Table};
use model_discrepancy::{Model, State};
use nalgebra::{DMatrix, DVector};

/// Moved and solved, mm.
const TABLE_4: [(f64, f64); 4] = [(1.0, 0.819), (2.0, 1.961), (5.0, 5.168), (10.0, 10.500)];

/// Half a unit in the last digit of the figures quoted.
const QUOTED_MM: f64 = 5e-4;

fn table() -> Vec<Displacement> {
    TABLE_4
        .iter()
        .map(|&(commanded_mm, solved_mm)| Displacement {
            point: format!("{commanded_mm} mm"),
            commanded_mm,
            solved_mm,
        })
        .collect()
}

fn rms(residuals: impl Iterator<Item = f64>) -> f64 {
    let squares: Vec<_> = residuals.map(|r| r * r).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Offset and gain by the model's own tangents, fitted to the rows in `keep`.
fn offset_and_gain(model: &DisplacementModel, gain: &str, keep: &[usize]) -> (State, DVector<f64>) {
    let at = State::start(model);
    let find = |id: &str| model.declared().effects.iter().position(|e| e.id == id).unwrap();
    let (offset, gain) = (find("datum-offset"), find(gain));
    let r = model.residuals(&at);
    let rows = r.len();
    let mut tangents = DMatrix::zeros(rows, 2);
    tangents.set_column(0, &model.tangent(&at, offset).column(0));
    tangents.set_column(1, &model.tangent(&at, gain).column(0));
    let solved =
        tangents.select_rows(keep).svd(true, true).solve(&-r.select_rows(keep), 1e-12).unwrap();
    let mut state = at;
    state.amplitudes[offset][0] = solved[0];
    state.amplitudes[gain][0] = solved[1];
    let residuals = model.residuals(&state);
    (state, residuals)
}

#[test]
fn the_published_errors_come_back() {
    let model = DisplacementModel::new(&table(), None).unwrap();
    let r = model.residuals(&State::start(&model));
    assert!((rms(r.iter().copied()) - 0.280).abs() < QUOTED_MM);
    assert!((r.amax() - 0.500).abs() < QUOTED_MM);
}

#[test]
fn offset_and_scale_explain_them() {
    let model = DisplacementModel::new(&table(), None).unwrap();
    let (state, r) = offset_and_gain(&model, "moment-gain", &[0, 1, 2, 3]);
    assert!((rms(r.iter().copied()) - 0.027).abs() < QUOTED_MM);
    assert!((state.amplitudes[0][0] + 0.215).abs() < QUOTED_MM);
    let gain = model.declared().effects.iter().position(|e| e.id == "moment-gain").unwrap();
    assert!((state.amplitudes[gain][0] - 0.073).abs() < QUOTED_MM);
    let left_out = (0..4).map(|out| {
        let keep: Vec<_> = (0..4).filter(|&i| i != out).collect();
        offset_and_gain(&model, "moment-gain", &keep).1[out]
    });
    assert!((rms(left_out) - 0.066).abs() < QUOTED_MM);
}

fn cosine(model: &dyn Model, a: usize, b: usize) -> f64 {
    let at = State::start(model);
    let white = |effect: usize| {
        let t = model.tangent(&at, effect);
        let sigma = model.declared().layout.rows.iter().map(|r| r.sigma);
        DVector::from_iterator(t.nrows(), t.iter().zip(sigma).map(|(t, s)| t / s)).normalize()
    };
    white(a).dot(&white(b)).abs()
}

#[test]
fn the_gains_are_one_class_until_a_standard_splits_them() {
    let model = DisplacementModel::new(&table(), None).unwrap();
    let find = |id: &str, subject: Option<&str>| {
        let is = |e: &model_discrepancy::Effect| e.id == id && e.subject.as_deref() == subject;
        model.declared().effects.iter().position(is).unwrap()
    };
    let gains = [
        find("moment-gain", None),
        find("force-gain", None),
        find("frame-scale", None),
        find("sensor-bias", Some("normal force")),
    ];
    let shifts = [find("datum-offset", None), find("sensor-bias", Some("moment"))];
    for class in [&gains[..], &shifts[..]] {
        for pair in class.windows(2) {
            assert!(cosine(&model, pair[0], pair[1]) > 1.0 - 1e-12);
        }
    }
    let proposals = model.proposals();
    let split = |text: &str, a: usize, b: usize| {
        let proposal = proposals.iter().find(|p| p.text.contains(text)).unwrap();
        cosine(&*proposal.model().unwrap(), a, b)
    };
    let [moment, force, scale, bias] = gains;
    assert!(split("second load", shifts[0], shifts[1]) < 0.98);
    assert!(split("second load", force, bias) < 0.98);
    assert!(split("lateral force", moment, force) < 0.999);
    assert!(split("lateral force", force, scale) > 1.0 - 1e-12, "a press cannot split these");
    assert!(split("known weight", force, scale) < 0.5);
    assert!(split("interferometer", scale, moment) < 0.5);
}

#[test]
fn tables_are_checked() {
    assert_eq!(
        DisplacementModel::new(&[], None).unwrap_err(),
        FtCenterError::Empty { of: Table::Displacements }
    );
    let mut bad = table();
    bad[2].solved_mm = f64::NAN;
    assert_eq!(
        DisplacementModel::new(&bad, None).unwrap_err(),
        FtCenterError::NotFinite { index: 2 }
    );
    assert!(DisplacementModel::new(&table(), Some(0.0)).is_err());
}
