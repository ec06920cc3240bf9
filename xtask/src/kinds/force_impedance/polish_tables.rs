//! A simulated polishing run as the tables of a case folder.

use std::fmt::Write as _;

use crate::kinds::force_impedance::polish::{Flaw, Run, Sample};
use crate::kinds::force_impedance::polish_head::{HeadModel, LEGS_DEG};

/// Text of `case.toml`.
pub(crate) fn case_toml(run: &Run) -> String {
    let head = HeadModel::USUAL;
    let mut text = format!(
        "kind = \"force-impedance\"\n\n[head]\ntip_to_plane_mm = {:.1}\nplane_to_joint_mm = {:.1}\n\
         head_radius_mm = {:.1}\nbracket_radius_mm = {:.1}\nleg_angles_deg = {LEGS_DEG:?}\n\
         weight_n = {:.1}\ncenter_of_gravity_mm = {:.1}\ngravity = [0.0, 0.0, -1.0]\n",
        head.tip_to_plane_mm,
        head.plane_to_joint_mm,
        head.head_radius_mm,
        head.bracket_radius_mm,
        run.weight_n,
        head.center_of_gravity_mm,
    );
    if run.formula != "full-balance" {
        let _ = write!(text, "\n[model]\nforce = \"{}\"\n", run.formula);
    }
    if run.declare_noise {
        let _ = write!(text, "\n[noise]\nforce_n = {}\n", run.noise_n);
    }
    text
}

/// Text of `log.csv`.
pub(crate) fn log_csv(run: &Run, samples: &[Sample]) -> String {
    let mut text = "time_s,l1_mm,l2_mm,l3_mm,l4_mm,f1_n,f2_n,f3_n,f4_n,nx,ny,nz".to_owned();
    let humid = matches!(run.flaw, Flaw::Humidity(_));
    for (wanted, name) in [
        (run.reference, "reference_n"),
        (run.name_segments, "segment"),
        (humid, "humidity_pct"),
        (run.record_air, "air_c"),
    ] {
        if wanted {
            let _ = write!(text, ",{name}");
        }
    }
    text.push('\n');
    for s in samples {
        let _ = write!(text, "{:.4}", s.time_s);
        push(&mut text, &s.lengths_mm, 4);
        push(&mut text, &s.cells_n, 3);
        push(&mut text, &s.normal, 6);
        if run.reference {
            let _ = write!(text, ",{:.3}", s.reference_n);
        }
        if run.name_segments {
            let _ = write!(text, ",strip {}", s.segment + 1);
        }
        if humid {
            let _ = write!(text, ",{:.2}", s.humidity_pct);
        }
        if run.record_air {
            let _ = write!(text, ",{:.2}", s.air_c);
        }
        text.push('\n');
    }
    text
}

fn push(text: &mut String, values: &[f64], digits: usize) {
    for value in values {
        let _ = write!(text, ",{value:.digits$}");
    }
}
