//! A simulated session as the tables of a case folder.

use std::fmt::Write as _;

use crate::kinds::ft_center::press::{Recorded, Role, Session};

/// Text of `case.toml`.
pub(crate) fn case_toml(session: &Session, recorded: &Recorded) -> String {
    let mut text = format!(
        "kind = \"ft-center\"\n\n[contact]\nz0_mm = {:.1}\nmin_fz_n = 5.0\n",
        recorded.declared_height_mm
    );
    if session.declare_noise {
        let _ = write!(
            text,
            "\n[noise]\nforce_n = {}\nmoment_nmm = {}\n",
            session.force_noise_n, session.moment_noise_nmm
        );
    }
    text
}

/// Text of `presses.csv`.
pub(crate) fn presses_csv(recorded: &Recorded) -> String {
    let mut text = "press,machine_x_mm,machine_y_mm,use\n".to_owned();
    for (index, press) in recorded.presses.iter().enumerate() {
        let role = match press.role {
            Role::Frame => "frame",
            Role::Check => "check",
            Role::Locate => "locate",
        };
        let [x, y] = press.commanded_mm;
        let _ = writeln!(text, "{},{x:.3},{y:.3},{role}", name(index));
    }
    text
}

/// Text of `wrench.csv`.
pub(crate) fn wrench_csv(recorded: &Recorded) -> String {
    let mut text = "press,time_s,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n".to_owned();
    for (index, press) in recorded.presses.iter().enumerate() {
        for (time_s, [fx, fy, fz, mx, my, mz]) in &press.samples {
            let _ = writeln!(
                text,
                "{},{time_s:.2},{fx:.3},{fy:.3},{fz:.3},{mx:.2},{my:.2},{mz:.1}",
                name(index)
            );
        }
    }
    text
}

fn name(index: usize) -> String {
    format!("P{:02}", index + 1)
}
