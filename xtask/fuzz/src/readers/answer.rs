//! Answers that were printed before: for `loop --carry`, `plan --answer` and `correct --answer`.

use truing::geometry::nalgebra::Isometry3;
use truing::pose_icp::ProgramOptions;
use truing::{PlanBudget, PlanOptions, close_loop, correct, plan, read_case, read_learnt};

use super::bundle::unpack;

/// Few, so that a plan takes no longer than a loop.
const BUDGET: PlanBudget = PlanBudget::Measurements(6);

/// A case folder with `answer.json` and, for a workpiece, `program.ngc`.
pub(super) fn read(bytes: &[u8]) {
    let folder = unpack(bytes);
    let answer = folder.path().join("answer.json");
    let learnt = read_learnt(&answer);
    // A case that cannot be read is what `case` is for.
    let Ok(case) = read_case(folder.path()) else { return };
    let options = ProgramOptions::default();
    let planned = Isometry3::identity();
    let program = folder.path().join("program.ngc");
    let _ = correct(&case, &program, &planned, &options, Some(&answer));
    let Ok(learnt) = learnt else { return };
    let options = PlanOptions { answer: Some(answer), aim: None, budget: Some(BUDGET) };
    let _ = plan(&case, &options);
    let _ = case.carrying(learnt).and_then(|case| close_loop(&case));
}
