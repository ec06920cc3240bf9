//! The model that the loop sees.

use frame_fit::{
    FrameFitError, FrameModel, Handedness, MeasuredPoint, Noise, Options, PointPair, Transform,
    Uncertainty, fit_frame,
};
use model_discrepancy::{Covariate, Model, Origin, Quantity, Role, State, check_tangents};
use nalgebra::{DMatrix, DVector, Point, Rotation3, SVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::scene;

/// What central differences show, see `check_tangents`.
const TANGENT_TOL: f64 = 1e-7;

/// Eight noisy points with a time and two temperatures.
fn model<const D: usize>(rng: &mut ChaCha8Rng, options: &Options) -> FrameModel<D> {
    let mut truth = scene::random_map::<D>(rng, options.transform);
    if options.handedness == Handedness::Improper {
        truth.linear.column_mut(0).neg_mut();
    }
    let points = scene::cloud(rng, 8, 200.0);
    let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.05 });
    scene::disturb(rng, &mut pairs);
    let named = pairs.iter().enumerate().map(|(k, p)| MeasuredPoint::new(format!("P{k}"), *p));
    let mut values = |low: f64, high: f64| (0..8).map(|_| rng.random_range(low..high)).collect();
    let covariates = [
        Covariate::recorded(
            "time_s",
            Quantity::Time,
            (0..8).map(|k| 100.0 + 60.0 * f64::from(k)).collect(),
        ),
        Covariate::recorded("air_c", Quantity::Temperature, values(18.0, 25.0)),
        Covariate::recorded("part_c", Quantity::Temperature, values(19.0, 21.0)),
        Covariate::recorded("humidity", Quantity::Other, values(30.0, 50.0)),
    ];
    FrameModel::new(named.collect(), &covariates, options).unwrap()
}

/// Base parameters and amplitudes of the size that a shift of `size_mm` over 200 mm has.
fn anywhere<const D: usize>(rng: &mut ChaCha8Rng, model: &FrameModel<D>, size_mm: f64) -> State {
    let mut state = State::start(model);
    for (value, parameter) in state.base.iter_mut().zip(&model.declared().base) {
        let lever_mm = if parameter.unit == "mm" { 1.0 } else { 200.0 };
        *value = size_mm / lever_mm * rng.random_range(-1.0..1.0);
    }
    for (amplitudes, effect) in state.amplitudes.iter_mut().zip(&model.declared().effects) {
        for (value, parameter) in amplitudes.iter_mut().zip(&effect.parameters) {
            let per_mm = match parameter.unit.as_str() {
                "mm" => 1.0 / parameter.report_factor,
                "mm/h" => 1.0 / 400.0,
                "µrad" | "µm/m" | "ppm" => 1.0 / 200.0,
                "ppm/K" => 1.0 / 1000.0,
                "µm/K" => 1.0 / 5.0,
                "µm/m²" | "1/m" => 1.0 / 40_000.0,
                "1/m²" => 1.0 / 8_000_000.0,
                other => panic!("unit {other}"),
            };
            *value = size_mm * per_mm * rng.random_range(-1.0..1.0);
        }
    }
    state
}

fn tangents_agree<const D: usize>(seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for transform in Transform::ALL {
        for handedness in [Handedness::Proper, Handedness::Improper] {
            let options = Options { handedness, ..Options::of(transform) };
            if handedness == Handedness::Improper && !transform.has_rotation() {
                continue;
            }
            let model = model::<D>(&mut rng, &options);
            for size_mm in [0.0, 0.1, 20.0] {
                let state = anywhere(&mut rng, &model, size_mm);
                let worst = check_tangents(&model, &state);
                assert!(worst < TANGENT_TOL, "{transform} {D}-d at {size_mm} mm: {worst:.1e}");
            }
        }
    }
}

#[test]
fn tangents_agree_with_differences() {
    tangents_agree::<2>(61);
    tangents_agree::<3>(62);
}

#[test]
fn the_start_is_the_fit() {
    let mut rng = ChaCha8Rng::seed_from_u64(63);
    for transform in Transform::ALL {
        let model = model::<3>(&mut rng, &Options::of(transform));
        let state = State::start(&model);
        let residuals = model.residuals(&state);
        // The start minimises: every column of the Jacobian is orthogonal to the residual.
        let jacobian = model.base_jacobian(&state);
        for column in jacobian.column_iter() {
            let correlation = column.dot(&residuals) / (column.norm() * residuals.norm());
            assert!(correlation.abs() < 1e-9, "{transform}: {correlation:.1e}");
        }
    }
}

/// Every effect, against the motion of points written out here.
#[test]
fn effects_do_what_their_names_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(64);
    let model = model::<3>(&mut rng, &Options::of(Transform::None));
    let still = State::start(&model);
    let before = model.residuals(&still);
    let sources: Vec<Vector3<f64>> = coordinates(&model);
    let centroid = sources.iter().sum::<Vector3<f64>>() / 8.0;
    let temperatures = temperatures();
    let moved = |id: &str, subject: Option<&str>, reported: &[f64]| -> Vec<Vector3<f64>> {
        let mut state = still.clone();
        let effect = model
            .declared()
            .effects
            .iter()
            .position(|e| e.id == id && e.subject.as_deref() == subject)
            .unwrap_or_else(|| panic!("no effect {id}"));
        for (k, value) in reported.iter().enumerate() {
            state.amplitudes[effect][k] =
                value / model.declared().effects[effect].parameters[k].report_factor;
        }
        assert_eq!(reported.len(), model.declared().effects[effect].parameters.len());
        // A prediction further along leaves a residual shorter by as much.
        let change = &before - model.residuals(&state);
        (0..8).map(|i| Vector3::new(change[3 * i], change[3 * i + 1], change[3 * i + 2])).collect()
    };
    let assert_moves =
        |got: Vec<Vector3<f64>>, expected: &dyn Fn(usize, &Vector3<f64>) -> Vector3<f64>| {
            for (i, (got, source)) in got.iter().zip(&sources).enumerate() {
                let expected = expected(i, source);
                assert!((got - expected).norm() < 1e-12 * 200.0, "point {i}: {got} {expected}");
            }
        };
    assert_moves(moved("shift", None, &[0.1, -0.2, 0.3]), &|_, _| Vector3::new(0.1, -0.2, 0.3));
    let turn = Vector3::new(1e-3, -2e-3, 3e-3);
    let rotation = Rotation3::from_scaled_axis(turn);
    assert_moves(moved("rotation", None, &[1e3, -2e3, 3e3]), &|_, x| rotation * x - x);
    assert_moves(moved("scale", None, &[250.0]), &|_, x| x * 250e-6);
    assert_moves(moved("anisotropic-scale", None, &[100.0, 0.0, -50.0]), &|_, x| {
        Vector3::new(x.x * 100e-6, 0.0, x.z * -50e-6)
    });
    assert_moves(moved("shear", None, &[10.0, 20.0, 40.0]), &|_, x| {
        Vector3::new(x.y * 10e-6 + x.z * 20e-6, x.z * 40e-6, 0.0)
    });
    assert_moves(moved("bad-point", Some("P3"), &[0.5, 0.0, -1.0]), &|i, _| {
        if i == 3 { Vector3::new(0.5, 0.0, -1.0) } else { Vector3::zeros() }
    });
    // One point a minute: 0.6 mm/h is 10 µm a point.
    assert_moves(moved("drift", None, &[0.6, 0.0, -0.6]), &|i, _| {
        Vector3::new(0.01, 0.0, -0.01) * i as f64
    });
    assert_moves(moved("sag", None, &[1000.0, 500.0, 2000.0, 30.0, -20.0, 0.05]), &|_, x| {
        // 1000 µm/m² is 1e-6 mm/mm².
        let (u, v) = (x.x - centroid.x, x.y - centroid.y);
        let bent = 1e-6 * u * u + 0.5e-6 * u * v + 2e-6 * v * v;
        Vector3::z() * -(bent + 30e-6 * u - 20e-6 * v + 0.05)
    });
    assert_moves(moved("temperature", Some("air_c"), &[11.5]), &|i, x| {
        x * (11.5e-6 * (temperatures[i] - 20.0))
    });
}

/// Sets an effect, in report units.
fn set(model: &FrameModel<3>, state: &mut State, id: &str, reported: &[f64]) {
    let effects = &model.declared().effects;
    let index = effects.iter().position(|e| e.id == id).unwrap();
    for (k, value) in reported.iter().enumerate() {
        state.amplitudes[index][k] = value / effects[index].parameters[k].report_factor;
    }
}

/// By how much each point is predicted further along than at the start.
fn moved(model: &FrameModel<3>, state: &State) -> Vec<Vector3<f64>> {
    let change = model.residuals(&State::start(model)) - model.residuals(state);
    (0..8).map(|i| Vector3::new(change[3 * i], change[3 * i + 1], change[3 * i + 2])).collect()
}

/// A rotation of the target frame turns points where their deformation has put them, about the
/// origin; a drift comes last.
#[test]
fn a_rotation_turns_what_is_deformed() {
    let mut rng = ChaCha8Rng::seed_from_u64(64);
    let model = model::<3>(&mut rng, &Options::of(Transform::None));
    let mut state = State::start(&model);
    set(&model, &mut state, "anisotropic-scale", &[3e4, -2e4, 5e4]);
    set(&model, &mut state, "rotation", &[1e5, -2e5, 3e5]);
    set(&model, &mut state, "drift", &[600.0, 0.0, -600.0]);
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.1, -0.2, 0.3));
    let stretch = Vector3::new(1.03, 0.98, 1.05);
    for (i, (got, x)) in moved(&model, &state).iter().zip(coordinates(&model)).enumerate() {
        let drifted = Vector3::new(10.0, 0.0, -10.0) * i as f64;
        let expected = rotation * x.component_mul(&stretch) - x + drifted;
        assert!((got - expected).norm() < 1e-12 * 200.0, "point {i}: {got} {expected}");
    }
}

/// The fitted motion moves points where their deformation has put them.
#[test]
fn a_motion_moves_what_is_deformed() {
    let mut rng = ChaCha8Rng::seed_from_u64(68);
    for transform in [Transform::Rigid, Transform::Translation, Transform::Similarity] {
        let model = model::<3>(&mut rng, &Options::of(transform));
        let start = State::start(&model);
        let mut deformed = start.clone();
        set(&model, &mut deformed, "shear", &[3e4, -2e4, 5e4]);
        set(&model, &mut deformed, "sag", &[1e5, 5e4, 2e5]);
        let mut both = deformed.clone();
        both.base = anywhere(&mut rng, &model, 20.0).base;
        let (reference, map) = (model.map_at(&start.base), model.map_at(&both.base));
        let deformations = moved(&model, &deformed);
        let largest_mm = deformations.iter().map(Vector3::norm).fold(0.0, f64::max);
        assert!(largest_mm > 1.0, "{transform}: {largest_mm} mm show nothing");
        for ((got, deformation), x) in
            moved(&model, &both).iter().zip(&deformations).zip(coordinates(&model))
        {
            let image = reference.apply(&Point::from(x)).coords;
            let undone = reference.linear.try_inverse().unwrap() * deformation;
            let expected = map.apply(&Point::from(x + undone)).coords - image;
            assert!((got - expected).norm() < 1e-11 * 1000.0, "{transform}: {got} {expected}");
        }
    }
}

fn coordinates(model: &FrameModel<3>) -> Vec<Vector3<f64>> {
    let columns = model.coordinates();
    let names: Vec<_> = columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["from_x_mm", "from_y_mm", "from_z_mm"]);
    assert!(columns.iter().all(|c| c.origin == Origin::Coordinate));
    (0..8).map(|i| Vector3::from_fn(|k, _| columns[k].values[i])).collect()
}

/// The air temperatures that `model` draws, by drawing them again.
fn temperatures() -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(64);
    let truth = scene::random_map::<3>(&mut rng, Transform::None);
    let points = scene::cloud(&mut rng, 8, 200.0);
    let mut pairs = scene::exact(&points, &truth, Uncertainty::Isotropic { sigma_mm: 0.05 });
    scene::disturb(&mut rng, &mut pairs);
    (0..8).map(|_| rng.random_range(18.0..25.0)).collect()
}

/// Which effects are candidates for which family.
#[test]
fn the_catalogue_leaves_out_what_the_transform_has() {
    let mut rng = ChaCha8Rng::seed_from_u64(65);
    let mut ids = |transform| {
        let model = model::<3>(&mut rng, &Options::of(transform));
        let ids = model.declared().effects.iter().filter(|e| e.id != "bad-point");
        ids.map(|e| e.id.clone()).collect::<Vec<_>>()
    };
    let common = ["drift", "sag", "temperature", "temperature"];
    let with = |own: &[&'static str]| [own, &common[..]].concat();
    let deformations = ["scale", "anisotropic-scale", "shear"];
    assert_eq!(ids(Transform::None), with(&[&["shift", "rotation"][..], &deformations].concat()));
    assert_eq!(ids(Transform::Translation), with(&[&["rotation"][..], &deformations].concat()));
    assert_eq!(ids(Transform::Rigid), with(&deformations));
    assert_eq!(ids(Transform::Similarity), with(&deformations[1..]));
    assert_eq!(ids(Transform::Affine), with(&[]));
}

#[test]
fn effects_name_their_drivers_and_subjects() {
    let mut rng = ChaCha8Rng::seed_from_u64(66);
    let model = model::<2>(&mut rng, &Options::default());
    let of = |id: &str| model.declared().effects.iter().filter(|e| e.id == id).collect::<Vec<_>>();
    assert_eq!(of("drift")[0].driver.as_deref(), Some("time_s"));
    let driven: Vec<_> = of("temperature").iter().map(|e| e.driver.as_deref()).collect();
    assert_eq!(driven, [Some("air_c"), Some("part_c")]);
    assert_eq!(of("bad-point").len(), 8);
    assert_eq!(of("bad-point")[2].subject.as_deref(), Some("P2"));
    // Planar: one shear, a sag along −y with its slope, a rotation about z.
    assert_eq!(of("shear")[0].parameters.len(), 1);
    assert_eq!(of("sag")[0].parameters.len(), 2);
}

#[test]
fn groups_and_roles_are_the_users() {
    let place = |x: f64, y: f64, role, group: &str, name: &str| MeasuredPoint {
        name: name.to_owned(),
        group: group.to_owned(),
        role,
        body: None,
        pair: PointPair::isotropic([x, y], [x + 1.0, y], 0.01),
    };
    let points = vec![
        place(0.0, 0.0, Role::Fit, "morning", "A"),
        place(100.0, 0.0, Role::Fit, "morning", "B"),
        place(0.0, 100.0, Role::Check, "noon", "C"),
        place(50.0, 70.0, Role::Fit, "evening", "A"),
    ];
    let options = Options { noise: Noise::Estimated, ..Options::default() };
    let model = FrameModel::new(points, &[], &options).unwrap();
    let layout = &model.declared().layout;
    assert_eq!(layout.observations, [0, 0, 1, 2]);
    let groups: Vec<_> = layout.groups.iter().map(|g| (g.name.as_str(), g.role)).collect();
    assert_eq!(groups, [("morning", Role::Fit), ("noon", Role::Check), ("evening", Role::Fit)]);
    assert_eq!((layout.rows.len(), layout.rows[5].component), (8, 1));
    assert!(!layout.sigma_declared && layout.unit == "mm");
    let subjects: Vec<_> =
        model.declared().effects.iter().filter_map(|e| e.subject.as_deref()).collect();
    // A checked point is never fitted and cannot be found bad; a name that returns is numbered.
    assert_eq!(subjects, ["A", "B", "A (2)"]);
}

/// The check point is judged, not fitted: moving it moves nothing.
#[test]
fn checked_points_do_not_move_the_start() {
    let mut rng = ChaCha8Rng::seed_from_u64(67);
    let points = scene::cloud::<3>(&mut rng, 6, 200.0);
    let mut pairs = scene::exact(
        &points,
        &frame_fit::FrameMap::identity(),
        Uncertainty::Isotropic { sigma_mm: 0.05 },
    );
    scene::disturb(&mut rng, &mut pairs);
    let expected = fit_frame(&pairs[..5], &Options::default()).unwrap().target_from_source;
    pairs[5].target_mm += SVector::from([1.0, 2.0, 3.0]);
    let mut measured: Vec<_> =
        pairs.iter().enumerate().map(|(k, p)| MeasuredPoint::new(k.to_string(), *p)).collect();
    measured[5].role = Role::Check;
    let model = FrameModel::new(measured, &[], &Options::default()).unwrap();
    let map = model.map_at(&model.declared().start);
    assert!(scene::map_distance_mm(&map, &expected, 200.0) < 1e-10);
}

#[test]
fn a_covariate_of_the_wrong_length_is_an_error() {
    let points: Vec<_> = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
        .map(|p| MeasuredPoint::new("P", PointPair::isotropic(p, p, 0.01)))
        .to_vec();
    for values in [vec![20.0, 21.0], vec![20.0, f64::NAN, 21.0]] {
        let error = FrameModel::new(
            points.clone(),
            &[Covariate::recorded("air_c", Quantity::Temperature, values)],
            &Options::default(),
        )
        .unwrap_err();
        let expected = FrameFitError::InvalidCovariate { covariate: "air_c".into(), needed: 3 };
        assert_eq!(error, expected);
    }
}

/// Share of an effect's tangent that the base parameters do not absorb.
fn kept(model: &dyn Model, id: &str, parameter: usize) -> f64 {
    let state = State::start(model);
    let effect = model.declared().effects.iter().position(|e| e.id == id).unwrap();
    let tangent: DVector<f64> = model.tangent(&state, effect).column(parameter).into_owned();
    if tangent.norm() == 0.0 {
        return 0.0;
    }
    let mut base: DMatrix<f64> = model.base_jacobian(&state);
    for mut column in base.column_iter_mut() {
        column.normalize_mut();
    }
    let q = base.qr().q();
    (&tangent - &q * (q.transpose() * &tangent)).norm() / tangent.norm()
}

/// Each proposal makes visible what it is for.
#[test]
fn proposals_show_what_the_design_hides() {
    // A plane plate, measured from left to right at one temperature.
    let points: Vec<_> = (0..9)
        .map(|k| {
            let place = [f64::from(k / 3) * 50.0, f64::from(k % 3) * 50.0, 10.0];
            MeasuredPoint::new(k.to_string(), PointPair::isotropic(place, place, 0.01))
        })
        .collect();
    let air = Covariate::recorded("air_c", Quantity::Temperature, vec![23.0; 9]);
    let model = FrameModel::new(points, &[air], &Options::of(Transform::Affine)).unwrap_err();
    assert!(matches!(model, FrameFitError::Degenerate { .. }), "{model}");

    let points: Vec<_> = (0..9)
        .map(|k| {
            let place = [f64::from(k / 3) * 50.0, f64::from(k % 3) * 50.0, 10.0];
            MeasuredPoint::new(k.to_string(), PointPair::isotropic(place, place, 0.01))
        })
        .collect();
    let air = Covariate::recorded("air_c", Quantity::Temperature, vec![23.0; 9]);
    let model = FrameModel::new(points, &[air], &Options::default()).unwrap();
    let proposed = |start: &str| {
        let proposals = model.proposals();
        let texts: Vec<_> = proposals.iter().map(|p| p.text.clone()).collect();
        let found = proposals.into_iter().find(|p| p.text.starts_with(start));
        found.unwrap_or_else(|| panic!("no «{start}» among {texts:?}")).model().unwrap()
    };
    // The third scale is along the normal of the plate: no trace at all.
    assert!(kept(&model, "anisotropic-scale", 2) < 1e-9);
    assert!(
        kept(proposed("measure two points far along z").as_ref(), "anisotropic-scale", 2) > 0.1
    );
    assert!(kept(proposed("add points out of the plane").as_ref(), "anisotropic-scale", 2) > 0.1);
    // One temperature is one scale: rivals. Two temperatures tell them apart.
    let angle = |model: &dyn Model| beside(model, "temperature", "scale");
    assert!(angle(&model) < 1e-9);
    assert!(angle(proposed("measure the same points again, 10 K warmer").as_ref()) > 0.1);
    // Measured along x in order, a drift along x looks like a scale along x.
    let imitated = |model: &dyn Model| beside(model, "drift", "anisotropic-scale");
    let repeated = proposed("measure the first 3 points again at the end");
    assert!(imitated(repeated.as_ref()) > 1.5 * imitated(&model), "{}", imitated(&model));
    let reversed = proposed("measure all points a second time, in reverse order");
    assert!(imitated(reversed.as_ref()) > 1.5 * imitated(&model));
}

/// Share of the first parameter of one effect that base and another effect do not absorb.
fn beside(model: &dyn Model, id: &str, other: &str) -> f64 {
    let state = State::start(model);
    let tangent = |id: &str| {
        let effect = model.declared().effects.iter().position(|e| e.id == id).unwrap();
        model.tangent(&state, effect)
    };
    let trace = tangent(id).column(0).into_owned();
    let base = model.base_jacobian(&state);
    let other = tangent(other);
    let mut all = DMatrix::zeros(base.nrows(), base.ncols() + other.ncols());
    all.columns_mut(0, base.ncols()).copy_from(&base);
    all.columns_mut(base.ncols(), other.ncols()).copy_from(&other);
    for mut column in all.column_iter_mut() {
        let norm = column.norm();
        column /= if norm > 0.0 { norm } else { 1.0 };
    }
    // Columns of zeros are in nobody's span.
    let svd = all.svd(true, false);
    let u = svd.u.unwrap();
    let span: Vec<_> = (0..u.ncols()).filter(|&k| svd.singular_values[k] > 1e-9).collect();
    let u = u.select_columns(&span);
    (&trace - &u * (u.transpose() * &trace)).norm() / trace.norm()
}

/// Far from the origin shared by the frames, deformations are taken about the centroid.
#[test]
fn far_points_deform_about_their_centroid() {
    for (offset_mm, about_centroid) in [(0.0, false), (300.0, false), (50_000.0, true)] {
        let points: Vec<_> = [[0.0, 0.0], [100.0, 0.0], [0.0, 100.0], [100.0, 100.0]]
            .map(|[x, y]| {
                let place = Point::from([x + offset_mm, y + offset_mm]);
                MeasuredPoint::new("P", PointPair::isotropic(place, place, 0.01))
            })
            .to_vec();
        let model = FrameModel::new(points, &[], &Options::of(Transform::None)).unwrap();
        let state = State::start(&model);
        let scale = model.declared().effects.iter().position(|e| e.id == "scale").unwrap();
        let centre = model.tangent(&state, scale).column(0).sum() / 8.0;
        let expected = if about_centroid { 0.0 } else { -(offset_mm + 50.0) };
        assert!((centre - expected).abs() < 1e-9, "at {offset_mm}: {centre}");
    }
}

/// A map that holds at a temperature names the column of it; that of a session has none.
#[test]
fn a_map_says_at_which_temperature_it_holds() {
    let mut rng = ChaCha8Rng::seed_from_u64(69);
    let model = model::<3>(&mut rng, &Options::default());
    let mut state = State::start(&model);
    set(&model, &mut state, "temperature", &[11.5]);
    let map = model.with_effects(&state, &[], &DMatrix::zeros(0, 0));
    let [condition] = &map.conditions[..] else { panic!("{:?}", map.conditions) };
    assert!(condition.starts_with("the matrix holds at air_c = 20 °C"), "{condition}");
}

/// A session that a column names is shifted as one, and grows by a temperature that is its own; two
/// points are none.
#[test]
fn sessions_are_those_that_columns_name() {
    let mut rng = ChaCha8Rng::seed_from_u64(70);
    let points = scene::cloud::<3>(&mut rng, 8, 200.0);
    let pair = |p: &Point<f64, 3>| PointPair::isotropic(*p, *p, 0.05);
    let measured = points.iter().enumerate();
    let measured = measured.map(|(k, p)| MeasuredPoint::new(k.to_string(), pair(p))).collect();
    let inside =
        |names: &[usize]| (0..8).map(|k| f64::from(u8::from(names.contains(&k)))).collect();
    let columns = [("session: monday", inside(&[1, 4, 6])), ("session: tuesday", inside(&[2, 3]))]
        .map(|(name, values)| Covariate::recorded(name, Quantity::Other, values));
    let model = FrameModel::new(measured, &columns, &Options::of(Transform::None)).unwrap();
    let effects = &model.declared().effects;
    let named = effects.iter().filter(|effect| effect.id.starts_with("session-"));
    let named: Vec<_> = named.map(|e| (e.id.as_str(), e.subject.as_deref())).collect();
    let monday = Some("monday");
    let turned = ("session-shift", Some("monday, and turned"));
    assert_eq!(named, [("session-temperature", monday), ("session-shift", monday), turned]);
    let mut state = State::start(&model);
    set(&model, &mut state, "session-temperature", &[250.0]);
    set(&model, &mut state, "session-shift", &[0.1, -0.2, 0.3]);
    for (k, (got, x)) in moved(&model, &state).iter().zip(&points).enumerate() {
        let of_session = x.coords * 250e-6 + Vector3::new(0.1, -0.2, 0.3);
        let expected = if [1, 4, 6].contains(&k) { of_session } else { Vector3::zeros() };
        assert!((got - expected).norm() < 1e-12 * 200.0, "point {k}: {got} {expected}");
    }
}
