//! Small runs of a tracer in which every effect on ranges is accepted at least once.

use crate::kinds::tracker_lm::tracer::{Run, simulate};
use crate::kinds::tracker_lm::tracer_run::Defect;
use crate::kinds::tracker_lm::tracer_tables::tables;

/// Beginnings of ids with subjects.
pub(crate) const EFFECTS: &[&str] = &[
    "range-scale",
    "scale-drift",
    "range-drift",
    "range-drift [S",
    "backlash",
    "incidence",
    "station-drift [S",
    "station-shift [S2 from",
    "session-shift [from",
    "bad-station [S",
    "temperature",
    "dead-path-jump [S2-R3 at",
    "mount-slip [R2 at",
];

type Files = Vec<(&'static str, String)>;

/// Cases by name.
pub(crate) fn scenes() -> Vec<(&'static str, Files)> {
    let run = |seed: u64, defect: Defect| Run { n_angles: 13, defect, ..Run::new(seed) };
    let known = |run: Run| Run { stations_off_mm: 5e-4, ..run };
    vec![
        ("range-scale", files(&known(run(701, Defect::RangeScale(150e-6))))),
        ("scale-drift", files(&run(716, Defect::Warming(40e-6, 1.0)))),
        ("scale-that-settles", files(&run(717, Defect::Warming(60e-6, 0.2)))),
        ("range-drift", files(&Run { one_tracer: true, ..run(702, Defect::RangeDrift(0.012)) })),
        (
            "backlash",
            files(&Run {
                both_ways: true,
                ..run(703, Defect::Backlash(12e-6, [0.0, 0.0015, 0.0]))
            }),
        ),
        ("incidence", files(&run(704, Defect::Incidence(0.012)))),
        ("station-drift", files(&run(705, Defect::StationDrift(2, [0.03, -0.05, 0.03])))),
        ("creep", files(&run(715, Defect::Creep(3, 0.02)))),
        ("knocked", files(&run(712, Defect::Knocked(1, 5, [0.05, -0.04, 0.06])))),
        // The axis meets each angle before and after.
        (
            "moved",
            files(&Run {
                both_ways: true,
                ..run(713, Defect::Moved(8, [0.03, -0.02, 0.04], [60e-6, 40e-6, -50e-6]))
            }),
        ),
        (
            "station-drift-in-its-turn",
            files(&Run { one_tracer: true, ..run(714, Defect::StationDrift(3, [0.2, -0.3, 0.2])) }),
        ),
        ("bad-station", files(&known(run(706, Defect::BadStation(1, 120e-6))))),
        (
            "temperature",
            files(&Run { record_air: true, ..known(run(707, Defect::Wavelength(-8e-6))) }),
        ),
        ("dead-path-jump", files(&run(708, Defect::DeadPathJump(1, 2, 6, 0.006)))),
        ("mount-slip", files(&run(709, Defect::MountSlip(1, 6, [0.02, 0.015, -0.02])))),
        // So far that rows are not linear from one to the other.
        ("beam-lost-for-20-mm", files(&run(710, Defect::DeadPathJump(1, 2, 6, 20.0)))),
        ("mount-knocked-by-2-mm", files(&run(711, Defect::MountSlip(1, 6, [1.0, 1.5, -1.0])))),
    ]
}

fn files(run: &Run) -> Files {
    tables(run, &simulate(run))
}
