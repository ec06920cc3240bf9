//! Models of proposed measurements: those of the points that they plan.

use frame_fit::{FrameModel, MeasuredPoint, Options, PointPair, Transform};
use model_discrepancy::{Covariate, Model, Quantity, State};
use nalgebra::{DMatrix, Point3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::scene;

const N: usize = 9;
const SIGMA_MM: f64 = 0.05;
/// Two fits of the same minimum, see the laws; columns are of up to 1e6 mm².
const SAME_TOL: f64 = 1e-9;

/// Points on two bodies, with times in uneven steps and temperatures.
fn measured() -> (Vec<MeasuredPoint<3>>, [Vec<f64>; 2]) {
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let truth = scene::random_map::<3>(&mut rng, Transform::Rigid);
    let points = scene::cloud::<3>(&mut rng, N, 200.0)
        .into_iter()
        .enumerate()
        .map(|(k, source)| {
            let noise = scene::gauss::<3>(&mut rng) * SIGMA_MM;
            let pair = PointPair::isotropic(source, truth.apply(&source) + noise, SIGMA_MM);
            let body = Some(format!("B{}", k % 2));
            MeasuredPoint { body, ..MeasuredPoint::new(format!("P{k}"), pair) }
        })
        .collect();
    let times = (0..N).map(|k| 10.0 + (k * k) as f64).collect();
    let temperatures = (0..N).map(|k| 20.0 + (k % 4) as f64).collect();
    (points, [times, temperatures])
}

fn model(points: Vec<MeasuredPoint<3>>, [times, temperatures]: [Vec<f64>; 2]) -> FrameModel<3> {
    let columns = [
        Covariate::recorded("time_s", Quantity::Time, times),
        Covariate::recorded("part_c", Quantity::Temperature, temperatures),
    ];
    FrameModel::new(points, &columns, &Options::of(Transform::Rigid)).unwrap()
}

fn tangents(model: &dyn Model) -> Vec<(String, DMatrix<f64>)> {
    let start = State::start(model);
    let effects = model.declared().effects.iter().enumerate();
    let said = effects.filter(|(_, effect)| effect.id != "bad-point");
    said.map(|(k, e)| (format!("{} {:?}", e.id, e.subject), model.tangent(&start, k))).collect()
}

/// A reading that is planned: where, like which point, and how much warmer.
type Planned = (Point3<f64>, usize, f64);

/// Time goes on at its mean pace; a reading is where the fit has it, and nothing else changes but what
/// the proposal names.
#[test]
fn a_proposal_is_the_model_of_the_points_that_it_plans() {
    let (points, columns) = measured();
    let before = model(points.clone(), columns.clone());
    let map = before.map_at(&State::start(&before).base);
    let source = |k: usize| points[k].pair.source_mm;
    let again = |k: usize| (source(k), k, 0.0);
    let centroid = (0..N).map(|k| source(k).coords).sum::<Vector3<f64>>() / N as f64;
    let square = (0..N).map(|k| (source(k).coords - centroid).norm_squared()).sum::<f64>();
    // Three and a half times as far as the points are in the mean square.
    let reach_mm = 3.5 * (square / N as f64).sqrt();
    let far = |axis: usize| -> Vec<Planned> {
        [-reach_mm, reach_mm]
            .map(|d| (Point3::from(centroid + Vector3::ith(axis, d)), 0, 0.0))
            .to_vec()
    };
    let planned: [(&str, Vec<Planned>); 6] = [
        ("measure the first 3 points again", (0..3).map(again).collect()),
        ("measure two points far along x", far(0)),
        ("measure two points far along y", far(1)),
        ("measure two points far along z", far(2)),
        ("measure the same points again, 10 K", (0..N).map(|k| (source(k), k, 10.0)).collect()),
        ("measure all points a second time", (0..N).rev().map(again).collect()),
    ];
    let mut proposals = before.proposals();
    for (text, planned) in planned {
        let at = proposals.iter().position(|p| p.text.starts_with(text)).unwrap();
        let found = proposals.remove(at).model().unwrap();
        let (mut points, [mut times, mut temperatures]) = measured();
        let pace_s = (times[N - 1] - times[0]) / (N - 1) as f64;
        for (source_mm, like, warmer_k) in planned {
            let target_mm = map.apply(&source_mm);
            let pair = PointPair { source_mm, target_mm, ..points[like].pair };
            let body = points[like].body.clone();
            let name = format!("again {}", points.len());
            points.push(MeasuredPoint { body, ..MeasuredPoint::new(name, pair) });
            times.push(times[times.len() - 1] + pace_s);
            temperatures.push(temperatures[like] + warmer_k);
        }
        let (found, expected) =
            (tangents(&*found), tangents(&model(points, [times, temperatures])));
        assert_eq!(found.len(), expected.len(), "{text}");
        for ((effect, found), (name, expected)) in found.iter().zip(&expected) {
            assert_eq!(effect, name, "{text}");
            let off = (found - expected).amax();
            assert!(off <= SAME_TOL * expected.amax(), "{text}, {effect}: {off:e}");
        }
    }
    assert!(proposals.is_empty(), "{:?}", proposals.iter().map(|p| &p.text).collect::<Vec<_>>());
}
