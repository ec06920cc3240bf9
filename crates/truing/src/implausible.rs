//! Results that are larger than any that a machine needs.

/// Farthest from its flange or sensor that a tool is held: the reach of a large robot.
const MAX_TOOL_MM: f64 = 3000.0;

/// A result larger than any that a machine needs.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImplausibleResult {
    /// The axis turns against its declared direction.
    #[error(
        "the axis turns against `[axis] direction`: its rotation error is twice its angle, up \
         to {largest_deg:.1}°; with the direction the other way, direction = [{}, {}, {}], the data fit",
        reversed[0], reversed[1], reversed[2]
    )]
    Reversed {
        /// Largest rotation error.
        largest_deg: f64,
        /// Direction that fits.
        reversed: [f64; 3],
    },
    /// A compensation beyond its bound.
    #[error(
        "the compensation of axis {letter} is {found_deg:.3}° at {at_deg}°, more than the \
         {limit_deg}° that are taken for a correction: check `[axis] direction` and `angle_deg`; \
         `--max-correction {}` writes it all the same",
        found_deg.abs().ceil()
    )]
    Compensation {
        /// Letter of the axis.
        letter: char,
        /// Largest correction.
        found_deg: f64,
        /// Where it is.
        at_deg: f64,
        /// The bound.
        limit_deg: f64,
    },
    /// A location error beyond any machine.
    #[error(
        "the axis lies {found} {unit} from where it is declared ({name}), more than any machine is \
         wrong by ({limit} {unit}): check `[axis] origin_mm`, `[axis] direction`, the stations and \
         their units"
    )]
    Location {
        /// Name of ISO 230-1.
        name: String,
        /// The error.
        found: f64,
        /// Unit of both.
        unit: &'static str,
        /// The bound.
        limit: f64,
    },
    /// A position beyond any machine.
    #[error(
        "the axis misses its target {target} {target_unit} by {found:.3} {unit}, more than any machine \
         does ({limit:.3} {unit}): check units, signs and the order of the rows"
    )]
    Position {
        /// The target.
        target: f64,
        /// Its unit.
        target_unit: &'static str,
        /// Mean deviation there.
        found: f64,
        /// Unit of it and of the bound.
        unit: &'static str,
        /// The bound.
        limit: f64,
    },
    /// A contact beyond any machine.
    #[error(
        "press {press} lies {found_mm:.1} mm from where the head was sent, more than any machine is \
         wrong by ({limit_mm} mm): check the columns of `presses.csv` and `wrench.csv`, their signs \
         and units, and `[contact] z0_mm`"
    )]
    Contact {
        /// Name of the press.
        press: String,
        /// Distance.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
    /// A tool longer than any.
    #[error(
        "{what} lies {found_mm:.0} mm from {from}, farther than any tool reaches ({limit_mm} mm): \
         check the units of the table, and that the poses turn enough to show it"
    )]
    Tool {
        /// `the tip` or `the centre of gravity`.
        what: &'static str,
        /// What it is measured from.
        from: &'static str,
        /// Distance.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
    /// A workpiece farther away than any machine is long.
    #[error(
        "the workpiece lies {:.0} m from the zero of its readings, farther than any machine is long \
         ({:.0} m): check the units of `points.csv`",
        found_mm / 1000.0, limit_mm / 1000.0
    )]
    Place {
        /// Distance.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
    /// Axes worse than those of any machine.
    #[error(
        "the machine's axes as found change lengths and angles by {:.1} %, more than any machine is \
         wrong by ({:.0} %): check `[surface]` and the units of `points.csv`",
        100.0 * found, 100.0 * limit
    )]
    Axes {
        /// Largest share.
        found: f64,
        /// The bound.
        limit: f64,
    },
    /// A part farther from its drawing than any.
    #[error(
        "touch {touch} is {found_mm:.1} mm off the drawn part, more than any part is wrong by \
         ({limit_mm} mm): check `[surface]`, the workpiece frame and the units of `touches.csv`"
    )]
    Deviation {
        /// Name of the touch.
        touch: String,
        /// Its deviation.
        found_mm: f64,
        /// The bound.
        limit_mm: f64,
    },
}

/// A tool that no robot carries.
pub(crate) fn too_long(
    what: &'static str,
    from: &'static str,
    at_mm: [f64; 3],
) -> Option<ImplausibleResult> {
    let found_mm = at_mm.iter().map(|v| v * v).sum::<f64>().sqrt();
    let limit_mm = MAX_TOOL_MM;
    (found_mm > limit_mm).then_some(ImplausibleResult::Tool { what, from, found_mm, limit_mm })
}

#[cfg(test)]
mod tests {
    use super::too_long;

    #[test]
    fn a_tool_of_kilometres_is_named() {
        assert_eq!(too_long("the tip", "the flange", [900.0, 0.0, 1200.0]), None);
        let found = too_long("the tip", "the flange", [0.0, 2e6, 0.0]).expect("two kilometres");
        assert!(found.to_string().contains("the tip lies 2000000 mm from the flange"), "{found}");
    }
}
