//! How far a sensor, a tool or a head leans.

use serde::Deserialize;

use crate::case::Finite;

/// An angle from upright, below a right angle for a press.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lean(pub(crate) f64);

impl<'de> Deserialize<'de> for Lean {
    fn deserialize<D: serde::de::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Finite(angle) = Finite::deserialize(deserializer)?;
        if (0.0..=180.0).contains(&angle) {
            return Ok(Self(angle));
        }
        Err(serde::de::Error::custom(format_args!(
            "expected an angle from upright, from 0 to 180, found {angle}"
        )))
    }
}
