//! Simulated strokes along a path that are committed.

use crate::expectation::Expectation;
use crate::generators::{Case, Story, generated, named, nothing};
use crate::kinds::force_impedance::strokes::{Repeats, Strokes, path_csv};

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        stroke_case(
            "path-nothing",
            &Strokes::new(81),
            "Strokes along a path, nothing repeats",
            "Nothing repeats from stroke to stroke.",
            nothing(&["nothing-missing"]),
        ),
        stroke_case(
            "path-loss",
            &Strokes { repeats: Repeats::Loss(0.35), ..Strokes::new(82) },
            "Force lost at one place of a path",
            "Around 260 mm every stroke loses 35 % of the force asked for.",
            named(&["path-share"]),
        ),
        stroke_case(
            "path-kick",
            &Strokes { repeats: Repeats::Kick(6.0), ..Strokes::new(83) },
            "A step of the surface in a path",
            "At 120 mm every stroke is kicked by 6 N, whatever its force, which decays over 25 mm.",
            named(&["path-repeatable"]),
        ),
    ]
}

fn stroke_case(
    folder: &str,
    strokes: &Strokes,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let settings = "kind = \"force-impedance\"\n".to_owned();
    let tables = vec![("case.toml", settings), ("path.csv", path_csv(strokes))];
    let truth = format!(
        "{truth} {} strokes of {} readings at {:?} N in turn; the control's own error is {} N and \
         correlated from reading to reading.",
        strokes.n_runs, strokes.n_samples, strokes.loads_n, strokes.noise_n
    );
    generated(
        &format!("force-impedance/{folder}"),
        strokes.seed,
        tables,
        Story { title, truth, expect },
    )
}
