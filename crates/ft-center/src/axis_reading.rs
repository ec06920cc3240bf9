//! Readings of an axis that was sent to targets.

/// Which way an axis came to a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Approach {
    /// From smaller positions (ISO 230-2: ↑).
    Rising,
    /// From larger positions (ISO 230-2: ↓).
    Falling,
}

impl Approach {
    /// 1 for rising, −1 for falling.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Rising => 1.0,
            Self::Falling => -1.0,
        }
    }
}

/// What an axis does, and with it the units of its readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum AxisMotion {
    /// Targets and deviations in mm.
    Linear,
    /// Targets in degrees, deviations in seconds of arc.
    Rotary,
}

impl AxisMotion {
    /// Unit of a target.
    #[must_use]
    pub fn target_unit(self) -> &'static str {
        match self {
            Self::Linear => "mm",
            Self::Rotary => "deg",
        }
    }

    /// Unit of a deviation.
    #[must_use]
    pub fn deviation_unit(self) -> &'static str {
        match self {
            Self::Linear => "mm",
            Self::Rotary => "arcsec",
        }
    }

    /// Unit in which an amplitude is reported, and the factor from that of a deviation.
    #[must_use]
    pub fn reported(self) -> (&'static str, f64) {
        match self {
            Self::Linear => ("µm", 1e3),
            Self::Rotary => ("arcsec", 1.0),
        }
    }
}

/// One reading of a positioning run.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct AxisReading {
    /// Name, of which each occurs once.
    pub name: String,
    /// Where the axis was sent; mm or degrees.
    pub target: f64,
    /// Where it was found less the target; mm or seconds of arc.
    pub deviation: f64,
    /// Which way it came, where known.
    pub approach: Option<Approach>,
}

/// Different targets in ascending order, −0 the same as 0.
pub(crate) fn distinct_targets(readings: &[AxisReading]) -> Vec<f64> {
    let mut targets: Vec<f64> = readings.iter().map(|r| r.target + 0.0).collect();
    targets.sort_by(f64::total_cmp);
    targets.dedup_by(|a, b| a.total_cmp(b).is_eq());
    targets
}
