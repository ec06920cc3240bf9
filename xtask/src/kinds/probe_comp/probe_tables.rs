//! Sessions with a probe as files.

use std::fmt::Write as _;

use crate::kinds::probe_comp::probe::{Flaw, Session, Shape, TOUCH_INTERVAL_S, Touch};

pub(crate) fn case_toml(session: &Session) -> String {
    let surface = match session.shape {
        Shape::Sphere { radius_mm } => {
            format!(
                "shape = \"sphere\"\nradius_mm = {radius_mm:.1}\ncenter_mm = [0.0, 0.0, 0.0]\nside = \"outside\"\n"
            )
        }
        Shape::Bowl { radius_mm } => {
            format!(
                "shape = \"asphere\"\nradius_mm = {radius_mm:.1}\nconic = -1.0\ndiameter_mm = 100.0\n"
            )
        }
    };
    let noise = if session.declare_noise {
        format!("\n[noise]\npoint_mm = {}\n", session.noise_mm)
    } else {
        String::new()
    };
    format!(
        "kind = \"probe-comp\"\n\n[surface]\n{surface}\n[probe]\ntip_radius_mm = {:.1}\n{noise}",
        session.tip_mm
    )
}

pub(crate) fn touches_csv(session: &Session, touches: &[Touch]) -> String {
    let oblique = session.oblique_rad != 0.0;
    let humid = matches!(session.flaw, Flaw::Humidity(_));
    let mut text = "touch,x_mm,y_mm,z_mm,use,time_s".to_owned();
    for (is_there, columns) in [
        (oblique, ",nx,ny,nz"),
        (session.record_feed, ",feed_mm_per_min"),
        (session.record_air, ",air_c"),
        (humid, ",humidity_pct"),
    ] {
        text.push_str(if is_there { columns } else { "" });
    }
    text.push('\n');
    for (i, touch) in touches.iter().enumerate() {
        let [x, y, z] = touch.read_mm;
        let usage = if touch.is_check { "check" } else { "fit" };
        let time = TOUCH_INTERVAL_S * f64::from(u32::try_from(i).expect("few touches"));
        let _ = write!(text, "T{:02},{x:.5},{y:.5},{z:.5},{usage},{time}", i + 1);
        if oblique {
            let [nx, ny, nz] = touch.approach;
            let _ = write!(text, ",{nx:.6},{ny:.6},{nz:.6}");
        }
        if session.record_feed {
            let _ = write!(text, ",{}", touch.feed_mm_per_min);
        }
        if session.record_air {
            let _ = write!(text, ",{:.3}", touch.air_c);
        }
        if humid {
            let _ = write!(text, ",{:.2}", touch.humidity_pct);
        }
        text.push('\n');
    }
    text
}
