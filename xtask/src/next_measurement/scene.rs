//! A case that can be measured further.

use anyhow::Result;
use serde_json::Value;

/// Files of a case: names and texts.
pub(super) type Files = Vec<(&'static str, String)>;

/// A case that can be measured further.
pub(crate) trait Scene {
    /// The case as it stands.
    fn files(&self) -> Files;
    /// What the plan is made for, where it is not what the loop leaves open.
    fn aim(&self) -> Option<&'static str>;
    /// The case with the planned measurements made; those of one that goes on with its own noise need no seed.
    fn with_plan(&self, plan: &[Value], seed: u64) -> Result<Files>;
    /// The case with as many measurements as one would spread without a plan.
    fn with_even(&self, count: usize, seed: u64) -> Files;
}
