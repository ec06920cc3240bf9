//! The proving ground, one folder per kind: simulators, the committed cases that they write, the
//! situations that statistics are taken in, and how an answer is applied to its input.

pub(crate) mod force_impedance;
pub(crate) mod frame_fit;
pub(crate) mod ft_center;
pub(crate) mod pose_icp;
pub(crate) mod positioning;
pub(crate) mod probe_comp;
pub(crate) mod tracker_lm;

use crate::generators::{Case, published};

/// Every committed case that this program can write.
pub(crate) fn cases() -> Vec<Case> {
    let mut cases = published::cases();
    cases.extend(frame_fit::frame_cases::cases());
    cases.extend(ft_center::press_cases::cases());
    cases.extend(pose_icp::mirror_cases::cases());
    cases.extend(force_impedance::polish_cases::cases());
    cases.extend(force_impedance::stroke_cases::cases());
    cases.extend(tracker_lm::tracer_cases::cases());
    cases.extend(tracker_lm::target_cases::cases());
    cases.push(tracker_lm::head::case());
    cases.extend(probe_comp::probe_cases::cases());
    cases
}
