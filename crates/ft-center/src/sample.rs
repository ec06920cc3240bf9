use geometry::Wrench;

/// One reading of the sensor during a press.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample {
    /// Time of the reading; only differences within a record matter.
    pub time_s: f64,
    /// Wrench acting on the sensor, moment about its reference point, sensor axes.
    pub wrench: Wrench,
}

/// Where the head touches, and when it counts as touching.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Contact {
    /// Height of the contact plane above the sensor's reference point, along the sensor's z.
    ///
    /// The wrench cannot tell it: the skew matrix of any force has rank 2.
    pub z0_mm: f64,
    /// Least `|Fz|` of a sample in contact, positive.
    ///
    /// `None`: a fifth of the 95th percentile of `|Fz|` in the record.
    pub min_fz_n: Option<f64>,
}

/// Standard uncertainties of one reading of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Noise {
    /// Of each force component.
    pub force_n: f64,
    /// Of each moment component.
    pub moment_nmm: f64,
}
