//! The presses as a model: tangents, and what the loop makes of one load and of two.

use ft_center::{
    LocateOptions, OrbitOptions, Press, PressModel, PressRole, SolvedPress, solve_presses,
};
use geometry::Wrench;
use model_discrepancy::{Closure, Model, Options, State, check_tangents, close_loop};
use nalgebra::{Point2, Vector2, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::simulator::{CONTACT, Colour, Head, Placement, press, record};

const PLACEMENT: Placement =
    Placement { angle_rad: 0.4, mirrored: false, shift_mm: Vector2::new(-210.0, 95.0) };

/// Presses on a 3 × 3 grid of 40 mm pitch, the loads in turn; `fault` spoils each reading.
pub(crate) fn grid(
    loads_n: &[f64],
    lateral_n: f64,
    colour: &Colour,
    seed: u64,
    fault: impl Fn(usize, &mut Wrench),
) -> Vec<Press> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut presses = Vec::new();
    for (round, load_n) in loads_n.iter().enumerate() {
        for i in 0..9 {
            let machine =
                Point2::new(500.0 + 40.0 * f64::from(i % 3), 80.0 + 40.0 * f64::from(i / 3));
            let k = 9 * round + i as usize;
            let turn = 1.3 * k as f64;
            let head = Head {
                load_n: *load_n,
                lateral_n: lateral_n * Vector2::new(turn.cos(), turn.sin()),
                ..Head::default()
            };
            let center = PLACEMENT.to_sensor(machine);
            let mut record = record(center, &head, colour, 150, 10.0, &mut rng);
            for sample in &mut record {
                fault(k, &mut sample.wrench);
            }
            presses.push(press(&format!("p{k}"), PressRole::Frame, machine, record));
        }
    }
    presses
}

fn solved(presses: &[Press]) -> Vec<SolvedPress> {
    solve_presses(presses, &CONTACT, &OrbitOptions::default()).unwrap()
}

fn model(presses: &[Press]) -> PressModel {
    PressModel::new(&solved(presses), &CONTACT, &LocateOptions::default(), &[]).unwrap()
}

fn closed(presses: &[Press]) -> Closure {
    let model = model(presses);
    close_loop(&model, &model.covariates(), &Options::default()).unwrap()
}

fn show(c: &Closure) {
    for s in &c.steps {
        println!(
            "step {} {:?} p {:.1e} rivals {:?} by {:?} params {:?}",
            s.effect,
            s.subject,
            s.p_value,
            s.indistinguishable_from,
            s.separate_by,
            s.parameters
                .iter()
                .map(|p| format!("{} {:.4}±{:.4} {}", p.name, p.value, p.std, p.unit))
                .collect::<Vec<_>>()
        );
    }
    println!(
        "verdict {:?} before {:.5}/{:.5} after {:.5}/{:.5}",
        c.verdict,
        c.before.train_rms,
        c.before.held_out_rms,
        c.after.train_rms,
        c.after.held_out_rms
    );
    for n in &c.not_observable {
        println!("  hidden {} {:?} by {:?}", n.effect, n.aliased_with, n.separate_by);
    }
    println!("remaining {:?}", c.remaining);
}

#[test]
fn explore_loop() {
    let cases: Vec<(&str, Vec<f64>, f64, Box<dyn Fn(usize, &mut Wrench)>)> = vec![
        ("none", vec![40.0], 3.0, Box::new(|_, _| {})),
        (
            "moment bias one load",
            vec![40.0],
            3.0,
            Box::new(|_, w| w.torque_nmm += Vector3::new(30.0, -50.0, 0.0)),
        ),
        (
            "moment bias two loads",
            vec![40.0, 80.0],
            3.0,
            Box::new(|_, w| w.torque_nmm += Vector3::new(30.0, -50.0, 0.0)),
        ),
        (
            "moment bias three loads",
            vec![40.0, 80.0, 20.0],
            3.0,
            Box::new(|_, w| w.torque_nmm += Vector3::new(30.0, -50.0, 0.0)),
        ),
        ("fz bias one load", vec![40.0], 3.0, Box::new(|_, w| w.force_n.z += 1.0)),
        ("fz bias two loads", vec![40.0, 80.0], 3.0, Box::new(|_, w| w.force_n.z += 1.0)),
        ("fz gain one", vec![40.0], 3.0, Box::new(|_, w| w.force_n.z *= 1.02)),
        ("fz gain two", vec![40.0, 80.0], 3.0, Box::new(|_, w| w.force_n.z *= 1.02)),
        ("moment gain two", vec![40.0, 80.0], 3.0, Box::new(|_, w| w.torque_nmm *= 1.02)),
        ("moment gain two lateral", vec![40.0, 80.0], 12.0, Box::new(|_, w| w.torque_nmm *= 1.02)),
        ("my gain two", vec![40.0, 80.0], 3.0, Box::new(|_, w| w.torque_nmm.y *= 1.02)),
        ("drift", vec![40.0, 80.0], 3.0, Box::new(|k, w| w.torque_nmm.x += 6.0 * k as f64)),
        (
            "height",
            vec![40.0, 80.0],
            12.0,
            Box::new(|_, w| {
                let f = w.force_n;
                w.torque_nmm += Vector3::new(0.0, 0.0, 2.0).cross(&f);
            }),
        ),
    ];
    for (name, loads, lateral, fault) in &cases {
        println!("=== {name}");
        show(&closed(&grid(loads, *lateral, &Colour::COLOURED, 5, fault)));
    }
}

#[test]
fn explore_distance() {
    let m = model(&grid(&[40.0], 3.0, &Colour::COLOURED, 5, |_, w| w.force_n.z += 1.0));
    let pos = |m: &dyn Model, id: &str, s: Option<&str>| {
        m.effects().iter().position(|e| e.id == id && e.subject.as_deref() == s).unwrap()
    };
    let white = |m: &dyn Model, mut x: nalgebra::DMatrix<f64>| {
        for (i, r) in m.layout().rows.iter().enumerate() {
            let mut row = x.row_mut(i);
            row /= r.sigma;
        }
        x
    };
    for p in m.proposals() {
        let e = p.model.as_ref();
        let at = State::declared(e.start(), e.effects());
        let mut d = vec![];
        for (a, b) in [
            (("force-gain", None), ("sensor-bias", Some("normal force"))),
            (("force-gain", None), ("frame-scale", None)),
            (("force-gain", None), ("moment-gain", None)),
        ] {
            let (a, b) = (pos(e, a.0, a.1), pos(e, b.0, b.1));
            let base = white(e, e.base_jacobian(&at));
            let g = white(e, e.tangent(&at, b));
            let t = white(e, e.tangent(&at, a)) * 0.024;
            let mut all = nalgebra::DMatrix::zeros(base.nrows(), base.ncols() + g.ncols());
            all.columns_mut(0, base.ncols()).copy_from(&base);
            all.columns_mut(base.ncols(), g.ncols()).copy_from(&g);
            let q = all.qr().q();
            d.push((&t - &q * (q.transpose() * &t)).norm());
        }
        println!("{} {:?}", p.text, d);
    }
}

#[test]
fn explore_table4() {
    use ft_center::{Displacement, DisplacementModel};
    let rows: Vec<_> = [(1.0, 0.819), (2.0, 1.961), (5.0, 5.168), (10.0, 10.5)]
        .iter()
        .map(|(a, b)| Displacement { point: format!("{a}"), commanded_mm: *a, solved_mm: *b })
        .collect();
    let m = DisplacementModel::new(&rows, None).unwrap();
    let c = close_loop(&m, &m.covariates(), &Options::default()).unwrap();
    show(&c);
    for p in &c.passes {
        println!("---");
        for s in &p.scores {
            println!("{:?}", s);
        }
    }
}
