//! Cases of several kinds, whole, for `hostile` to damage.

use std::f64::consts::FRAC_PI_3;
use std::fmt::Write as _;
use std::fs;

use crate::command::Case;

/// How many forms there are.
pub(crate) const FORMS: usize = 7;

/// One of the forms a case can take.
pub(crate) fn whole(form: usize) -> Case {
    match form {
        0 => Case::example("frame-fit"),
        1 => small_presses(),
        2 => Case::new(&[
            ("case.toml", "kind = \"ft-center\"\n[noise]\ndisplacement_mm = 0.05\n"),
            (
                "displacements.csv",
                "point,commanded_mm,solved_mm,air_c\n1,1,0.819,20\n2,2,1.961,20.1\n3,5,5.168,\
                 20.3\n4,10,10.5,20.2\n5,12,12.6,20.4\n",
            ),
        ]),
        3 => gravity(),
        4 => touched_sphere(),
        5 => touched_bowl(),
        _ => Case::new(&[
            (
                "case.toml",
                "kind = \"frame-fit\"\n[model]\ntransform = \"none\"\n[loop]\ngroup = \"day\"\n",
            ),
            (
                "pairs.csv",
                "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,sigma_mm,use,day\n\
                 a,0,0,0.01,0,0.01,fit,1\nb,100,0,100.02,0,0.01,fit,1\nc,100,50,100.01,50.01,0.01,\
                 fit,2\nd,0,50,0,50.02,0.02,fit,2\ne,50,20,50.01,20,0.01,fit,3\nf,20,30,20.01,30,\
                 0.01,check,3\n",
            ),
        ]),
    }
}

/// The example's first presses, twelve samples each: quick to solve many times.
fn small_presses() -> Case {
    let case = Case::example("ft-center");
    let text = fs::read_to_string(case.file("wrench.csv")).unwrap();
    let mut kept = std::collections::HashMap::new();
    let short = text.lines().filter(|line| {
        let press = line.split(',').next().unwrap_or_default().to_owned();
        let n = kept.entry(press).or_insert(0);
        *n += 1;
        line.starts_with('#') || *n <= 12
    });
    case.write("wrench.csv", short.map(|line| line.to_owned() + "\n").collect::<String>());
    case
}

/// A tool of 20 N at (1, 2, 60) mm, turned about x and y.
fn gravity() -> Case {
    let mut text = "pose,qw,qx,qy,qz,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n".to_owned();
    for pose in 0..12 {
        let half = f64::from(pose) * 0.26;
        let (w, v) = (half.cos(), half.sin());
        let about_x = pose % 2 == 0;
        let (qx, qy) = if about_x { (v, 0.0) } else { (0.0, v) };
        // Gravity in sensor axes: −z turned back by the pose.
        let (s, c) = (2.0 * half).sin_cos();
        let (gx, gy, gz) = if about_x { (0.0, -s, -c) } else { (s, 0.0, -c) };
        let (fx, fy, fz) = (20.0 * gx + 0.3, 20.0 * gy - 0.1, 20.0 * gz + 0.2);
        let (lx, ly, lz) = (20.0 * gx, 20.0 * gy, 20.0 * gz);
        let (mx, my, mz) = (2.0 * lz - 60.0 * ly, 60.0 * lx - lz, ly - 2.0 * lx);
        // Noise that is the same in every run.
        let noise = f64::from((pose * 37) % 11) * 0.001;
        text += &format!(
            "{pose},{w},{qx},{qy},0,{},{fy},{},{},{my},{}\n",
            fx + noise,
            fz - noise,
            mx + noise,
            mz - noise
        );
    }
    Case::new(&[("case.toml", "kind = \"ft-center\"\n"), ("gravity.csv", &text)])
}

/// Thousandths of a millimetre that stand for noise.
fn noise_mm(i: u32) -> f64 {
    f64::from(i * i % 11) * 2e-4 - 1e-3
}

/// Touches of a sphere with every column, by a probe that is qualified on another.
fn touched_sphere() -> Case {
    let outward = |i: u32| {
        let z = (f64::from(i) + 0.5) / 24.0;
        let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
        let side = (1.0 - z * z).sqrt();
        [side * cos, side * sin, z]
    };
    let mut touches = "touch,x_mm,y_mm,z_mm,nx,ny,nz,sigma_mm,use,feed_mm_per_min,air_c,time_s,\
                       spindle_deg\n"
        .to_owned();
    let mut reference = "touch,x_mm,y_mm,z_mm\n".to_owned();
    for i in 0..24 {
        let u = outward(i);
        let [x, y, z] = u.map(|v| v * (28.0 + noise_mm(i)));
        let [nx, ny, nz] = u.map(|v| -v);
        let usage = if i % 4 == 3 { "check" } else { "fit" };
        let (feed, air) = (60 + 60 * (i % 3), 20.0 + 0.3 * f64::from(i % 5));
        let _ = writeln!(
            touches,
            "T{i},{x:.6},{y:.6},{z:.6},{nx:.7},{ny:.7},{nz:.7},0.001,{usage},{feed},{air},{},{}",
            12 * i,
            90 * (i % 4)
        );
        let [x, y, z] = u.map(|v| v * (15.502 + noise_mm(i + 5)));
        let _ = writeln!(reference, "Q{i},{:.6},{y:.6},{z:.6}", 300.0 + x);
    }
    let toml = "kind = \"probe-comp\"\n[surface]\nshape = \"sphere\"\nradius_mm = 25.0\n\
                side = \"outside\"\n[probe]\ntip_radius_mm = 3.0\nstylus = [0, 0, 1]\n[noise]\n\
                point_mm = 0.001\n[qualification]\nshape = \"sphere\"\nradius_mm = 12.5\n";
    Case::new(&[("case.toml", toml), ("touches.csv", &touches), ("qualification.csv", &reference)])
}

/// Touches of a bowl with six around each.
fn touched_bowl() -> Case {
    let ball = |x: f64, y: f64| {
        let [a, b] = [-x / 120.0, -y / 120.0];
        let share = 3.0 / (a * a + b * b + 1.0).sqrt();
        [x + share * a, y + share * b, (x * x + y * y) / 240.0 + share]
    };
    let mut touches = "touch,x_mm,y_mm,z_mm,gx_mm,gy_mm\n".to_owned();
    let mut around = "touch,k,x_mm,y_mm,z_mm\n".to_owned();
    for i in 0..20 {
        let radius = 8.0 * (f64::from(i) + 0.5).sqrt();
        let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
        let (at_x, at_y) = (radius * cos, radius * sin);
        let [x, y, z] = ball(at_x, at_y);
        let _ = writeln!(touches, "T{i},{x:.6},{y:.6},{:.6},{x:.6},{y:.6}", z + noise_mm(i));
        for k in 1..=6 {
            let (sin, cos) = (FRAC_PI_3 * f64::from(k)).sin_cos();
            let [x, y, z] = ball(at_x + 0.3 * cos, at_y + 0.3 * sin);
            let _ = writeln!(around, "T{i},{k},{x:.6},{y:.6},{z:.6}");
        }
    }
    let toml = "kind = \"probe-comp\"\n[surface]\nshape = \"asphere\"\nradius_mm = 120.0\n\
                conic = -1.0\ndiameter_mm = 100.0\n[probe]\ntip_radius_mm = 3.0\n[model]\n\
                normal = \"micro-plane\"\n[noise]\npoint_mm = 0.001\n";
    Case::new(&[("case.toml", toml), ("touches.csv", &touches), ("micro.csv", &around)])
}
