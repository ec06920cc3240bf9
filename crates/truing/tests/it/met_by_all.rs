//! Effects that every measurement meets: named, and told from what they look like.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use crate::command::Case;

fn names(answer: &Value) -> Vec<String> {
    let steps = answer["steps"].as_array().unwrap();
    steps.iter().map(|step| step["effect"].as_str().unwrap().to_owned()).collect()
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[test]
fn a_session_that_was_warm_is_no_scale_of_everything() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let mut table =
        "point,from_x_mm,from_y_mm,from_z_mm,to_x_mm,to_y_mm,to_z_mm,session\n".to_owned();
    for i in 0..40 {
        let from: [f64; 3] = std::array::from_fn(|_| rng.random_range(-400.0..400.0));
        let (session, growth) = if (20..32).contains(&i) { ("s3", 46e-6) } else { ("s1", 0.0) };
        let session = if i < 10 { "s0" } else { session };
        let to = [from[1] + 50.0, -from[0], from[2] - 20.0];
        let at: [f64; 3] = std::array::from_fn(|k| {
            to[k] + growth * (to[k] - [50.0, 0.0, -20.0][k]) + 0.004 * normal(&mut rng)
        });
        table += &format!(
            "q{i},{:.6},{:.6},{:.6},{:.6},{:.6},{:.6},{session}\n",
            from[0], from[1], from[2], at[0], at[1], at[2]
        );
    }
    let case = Case::new(&[
        ("case.toml", "kind = \"frame-fit\"\n[noise]\npoint_mm = 0.004\n"),
        ("pairs.csv", &table),
    ]);
    let answer = case.json("loop");
    let names = names(&answer);
    assert_eq!(names[0], "session-temperature", "{}", answer["steps"]);
    assert!(!names.contains(&"scale".to_owned()), "{names:?}");
    assert_eq!(answer["steps"][0]["subject"], "session s3");
    let growth = &answer["steps"][0]["parameters"][0];
    let (value, std) = (growth["value"].as_f64().unwrap(), growth["std"].as_f64().unwrap());
    // Four standard uncertainties.
    assert!((value - 46.0).abs() < 4.0 * std, "{growth}");
}

#[test]
fn an_axis_with_reversal_is_no_bent_stylus() {
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    let mut table = "touch,x_mm,y_mm,z_mm\n".to_owned();
    let mut last_x = None;
    for i in 0..90 {
        let z: f64 = rng.random_range(0.05..0.98);
        let around = rng.random_range(0.0..std::f64::consts::TAU);
        let across = (1.0 - z * z).sqrt();
        let place = [28.0 * across * around.cos(), 28.0 * across * around.sin(), 28.0 * z];
        let way = last_x.map_or(0.0, |last: f64| (place[0] - last).signum());
        last_x = Some(place[0]);
        let noise = 0.0006 * normal(&mut rng);
        let read: [f64; 3] = std::array::from_fn(|k| place[k] * (1.0 + noise / 28.0));
        table += &format!("t{i},{:.6},{:.6},{:.6}\n", read[0] + 0.003 * way, read[1], read[2]);
    }
    let case = Case::new(&[
        (
            "case.toml",
            "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
             center_mm = [0.0, 0.0, 0.0]\n[probe]\ntip_radius_mm = 3.0\n[noise]\npoint_mm = 0.0006\n",
        ),
        ("touches.csv", &table),
    ]);
    let answer = case.json("loop");
    let names = names(&answer);
    assert_eq!(names[0], "reversal", "{}", answer["steps"]);
    assert!(!names.contains(&"bending".to_owned()), "{names:?}");
    let x = answer["steps"][0]["parameters"][0]["value"].as_f64().unwrap();
    // Ninety touches of 0.6 µm, of which x shows a third: 0.11 µm, four times.
    assert!((x - 3.0).abs() < 0.45, "{}", answer["steps"][0]);
}

#[test]
#[expect(clippy::cast_precision_loss, reason = "a count of presses")]
fn a_head_that_slips_by_friction_is_no_contact_at_another_height() {
    let mut rng = ChaCha8Rng::seed_from_u64(43);
    let mut presses = "press,machine_x_mm,machine_y_mm,use\n".to_owned();
    let mut wrench = "press,time_s,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n".to_owned();
    for i in 0..24 {
        let place: [f64; 2] = std::array::from_fn(|_| rng.random_range(-30.0..30.0));
        let load: f64 = [-20.0, -40.0, -60.0][i % 3];
        let (ratio, around) =
            (rng.random_range(0.12..0.28), rng.random_range(0.0..std::f64::consts::TAU));
        let drag = [load.abs() * ratio * around.cos(), load.abs() * ratio * around.sin()];
        presses += &format!("p{i},{:.4},{:.4},frame\n", place[0], place[1]);
        let seat: [f64; 2] =
            std::array::from_fn(|k| place[k] + 0.15 * drag[k].signum() + 0.015 * normal(&mut rng));
        for k in 0..40 {
            let read = |value: f64, sigma: f64, rng: &mut ChaCha8Rng| value + sigma * normal(rng);
            let force: [f64; 3] = [drag[0], drag[1], load].map(|f| read(f, 0.05, &mut rng));
            // M = p × F with p = (x, y, 32 mm).
            let moment = [
                seat[1] * load - 32.0 * drag[1],
                32.0 * drag[0] - seat[0] * load,
                seat[0] * drag[1] - seat[1] * drag[0],
            ]
            .map(|m| read(m, 1.5, &mut rng));
            wrench += &format!(
                "p{i},{:.2},{:.6},{:.6},{:.6},{:.6},{:.6},{:.6}\n",
                100.0 * i as f64 + 0.05 * f64::from(k),
                force[0],
                force[1],
                force[2],
                moment[0],
                moment[1],
                moment[2]
            );
        }
    }
    let case = Case::new(&[
        (
            "case.toml",
            "kind = \"ft-center\"\n[contact]\nz0_mm = 32.0\n[noise]\nforce_n = 0.05\nmoment_nmm = 1.5\n",
        ),
        ("presses.csv", &presses),
        ("wrench.csv", &wrench),
    ]);
    let answer = case.json("loop");
    let names = names(&answer);
    assert_eq!(names[0], "slip", "{}", answer["steps"]);
    assert!(!names.contains(&"contact-height".to_owned()), "{names:?}");
    for parameter in answer["steps"][0]["parameters"].as_array().unwrap() {
        // Four standard uncertainties of the mean of 24 presses that seat to 15 µm.
        assert!((parameter["value"].as_f64().unwrap() - 150.0).abs() < 16.0, "{parameter}");
    }
}
