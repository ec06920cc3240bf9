//! A tool that was weighed in poses about one axis, and goes on.

use anyhow::{Context, Result};
use serde_json::Value;

use super::scene::{Files, Scene};
use crate::kinds::ft_center::gravity_scenes::{as_f64, turned_against};

/// Static poses of a tool: that the base leans and that the sensor is turned on its flange is the same to poses about
/// the axis of that turn.
#[derive(Debug)]
pub(super) struct Hanging {
    /// Rotation about x of gravity against the base, and of the sensor against its flange, rad.
    pub(super) about_x_rad: [f64; 2],
    pub(super) seed: u64,
}

/// A unit quaternion, w first: orientation of the sensor in the base.
type Pose = [f64; 4];

/// Poses of the first series.
const POSES: usize = 13;
/// As far as the tool leans about x to either side, degrees.
const LEANS_DEG: f64 = 60.0;

impl Hanging {
    fn with(&self, further: &[Pose]) -> Files {
        let mut poses = about_x(POSES);
        poses.extend(further);
        turned_against(self.about_x_rad.map(|turn| [turn, 0.0, 0.0]), &poses, self.seed)
    }
}

/// Evenly from one side to the other.
fn about_x(count: usize) -> Vec<Pose> {
    let share = |n: usize| as_f64(n) / as_f64(count.max(2) - 1);
    let lean = |n: usize| (LEANS_DEG * (2.0 * share(n) - 1.0)).to_radians();
    let pose = |n: usize| [(0.5 * lean(n)).cos(), (0.5 * lean(n)).sin(), 0.0, 0.0];
    (0..count).map(pose).collect()
}

impl Scene for Hanging {
    fn files(&self) -> Files {
        self.with(&[])
    }

    fn aim(&self) -> Option<&'static str> {
        Some("rivals")
    }

    fn with_plan(&self, plan: &[Value], _: u64) -> Result<Files> {
        let poses = plan.iter().map(|one| {
            let cell = |name: &str| one["cells"][name].as_f64().context("no pose");
            Ok([cell("qw")?, cell("qx")?, cell("qy")?, cell("qz")?])
        });
        Ok(self.with(&poses.collect::<Result<Vec<_>>>()?))
    }

    fn with_even(&self, count: usize, _: u64) -> Files {
        self.with(&about_x(count))
    }
}
