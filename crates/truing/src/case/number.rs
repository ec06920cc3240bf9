//! Numbers of `case.toml` that are checked as they are read.

use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};

/// Values from this magnitude on are slips: in mm it is two and a half times the way to the moon.
///
/// Fourth powers of accepted values stay far inside the range of an `f64`.
pub(crate) const MAX_MAGNITUDE: f64 = 1e12;

/// Standard uncertainties below this are slips: their inverse squares would swamp an `f64`.
pub(crate) const MIN_POSITIVE: f64 = 1e-12;

/// A finite number of sane magnitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Finite(pub(crate) f64);

/// A standard uncertainty, a length: above zero, and sane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Positive(pub(crate) f64);

impl<'de> Deserialize<'de> for Finite {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = deserializer.deserialize_f64(Number("a finite number"))?;
        if value.abs() < MAX_MAGNITUDE {
            Ok(Self(value))
        } else {
            Err(D::Error::custom(format_args!(
                "expected a number of magnitude below {MAX_MAGNITUDE:e}, found {value:e}"
            )))
        }
    }
}

impl<'de> Deserialize<'de> for Positive {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = deserializer.deserialize_f64(Number("a positive number"))?;
        if value > MIN_POSITIVE && value < MAX_MAGNITUDE {
            Ok(Self(value))
        } else {
            Err(D::Error::custom(format_args!(
                "expected a number between {MIN_POSITIVE:e} and {MAX_MAGNITUDE:e}, found {value:e}"
            )))
        }
    }
}

/// Takes integers and floats; the text says what was expected instead.
struct Number(&'static str);

impl Visitor<'_> for Number {
    type Value = f64;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        Ok(value)
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "values are bounded far below 2^53 by the caller"
    )]
    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        Ok(value as f64)
    }

    #[expect(
        clippy::cast_precision_loss,
        reason = "values are bounded far below 2^53 by the caller"
    )]
    fn visit_u64<E: Error>(self, value: u64) -> Result<f64, E> {
        Ok(value as f64)
    }
}
