//! A probing program for LinuxCNC.

use std::fmt::Write as _;

use crate::kinds::{PlannedTouch, Reach};

/// File that the controller writes the touches to.
pub(super) const LOG: &str = "plan.txt";

/// Turns of a spindle that nobody can tell apart.
const SAME_TURN_DEG: f64 = 1e-6;

/// The touches as `G38.3` moves, each from a safe height and back to it.
///
/// Every touch begins `approach_mm` before the nominal contact, looks for the surface at its feed as
/// far as `overtravel_mm` beyond it, and goes back the same way. One that meets nothing ends the
/// program, as the log would have a line too few.
pub(super) fn program(names: &[String], touches: &[PlannedTouch], reach: &Reach) -> String {
    let Reach { safe_z_mm, approach_mm, overtravel_mm, travel_mm_per_min } = *reach;
    let mut text = format!(
        "(probing program, {} touches: ball centres in the coordinates of the case)\n\
         (run it slowly the first time: between touches the ball passes at Z{safe_z_mm:.4})\n\
         G21 G90 G94 G17 G40 G49\n(PROBEOPEN {LOG})\nG0 Z{safe_z_mm:.4}\n",
        touches.len()
    );
    let mut turned = 0.0;
    for (n, (name, touch)) in names.iter().zip(touches).enumerate() {
        let start = touch.ball_mm - touch.approach.into_inner() * approach_mm;
        let end = touch.ball_mm + touch.approach.into_inner() * overtravel_mm;
        let _ = writeln!(text, "({name})");
        if let Some(turn) = touch.spindle_deg.filter(|turn| (turn - turned).abs() > SAME_TURN_DEG) {
            let _ = writeln!(text, "(MSG, turn the probe in its spindle to {turn} degrees)\nM0");
            turned = turn;
        }
        let [x, y, z] = [start.x, start.y, start.z];
        let _ = writeln!(text, "G0 X{x:.4} Y{y:.4}\nG1 Z{z:.4} F{travel_mm_per_min:.1}");
        let [ex, ey, ez] = [end.x, end.y, end.z];
        let feed = touch.feed_mm_per_min;
        let _ = writeln!(text, "G38.3 X{ex:.4} Y{ey:.4} Z{ez:.4} F{feed:.1}");
        let label = 100 + n;
        let _ = writeln!(
            text,
            "o{label} if [#5070 EQ 0]\n  (PROBECLOSE)\n  (ABORT, touch {name} met nothing)\no{label} endif"
        );
        let _ = writeln!(text, "G1 X{x:.4} Y{y:.4} Z{z:.4} F{travel_mm_per_min:.1}");
        let _ = writeln!(text, "G0 Z{safe_z_mm:.4}");
    }
    text.push_str("(PROBECLOSE)\nM2\n");
    text
}

#[cfg(test)]
mod tests {
    use super::program;
    use crate::kinds::{PlannedTouch, Reach};
    use nalgebra::{Point3, Vector3};

    #[test]
    fn a_touch_begins_before_the_surface_and_looks_beyond_it() {
        let touch = PlannedTouch {
            contact_mm: Point3::new(1.0, 2.0, 3.0),
            normal: Vector3::z_axis(),
            ball_mm: Point3::new(1.0, 2.0, 6.0),
            approach: -Vector3::z_axis(),
            feed_mm_per_min: 60.0,
            spindle_deg: None,
        };
        let reach = Reach {
            safe_z_mm: 30.0,
            approach_mm: 2.0,
            overtravel_mm: 1.5,
            travel_mm_per_min: 800.0,
        };
        let text = program(&["N1".to_owned()], &[touch], &reach);
        let moves: Vec<&str> = text
            .lines()
            .filter(|l| l.starts_with("G0") || l.starts_with("G1") || l.starts_with("G38"))
            .collect();
        assert_eq!(
            moves,
            [
                "G0 Z30.0000",
                "G0 X1.0000 Y2.0000",
                "G1 Z8.0000 F800.0",
                "G38.3 X1.0000 Y2.0000 Z4.5000 F60.0",
                "G1 X1.0000 Y2.0000 Z8.0000 F800.0",
                "G0 Z30.0000",
            ]
        );
    }
}
