use std::fmt;

use serde::Serialize;

/// What has changed with a row of the stream; serialises as one line of JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PathEvent {
    /// Time of the row.
    pub time_s: f64,
    /// What.
    pub what: What,
    /// Contact − commanded position, machine frame, after the low pass; `None` without contact.
    pub offset_mm: Option<[f64; 2]>,
}

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum What {
    /// The head touches.
    Touched,
    /// It touches no longer.
    Lifted,
    /// The contact is farther from the path than the tolerance.
    Left,
    /// It is near it again.
    Back,
    /// A row that cannot be used: a number is not finite, or time did not increase.
    Invalid,
}

/// What a stream held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PathSummary {
    /// Rows taken.
    pub rows: usize,
    /// Rows that could not be used.
    pub invalid: usize,
    /// Times that the head touched.
    pub touches: usize,
    /// Times that the contact left the path.
    pub departures: usize,
    /// Farthest that it was from it.
    pub farthest_mm: f64,
}

impl fmt::Display for PathEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.what {
            What::Touched => "touched",
            What::Lifted => "lifted",
            What::Left => "left the path",
            What::Back => "back on the path",
            What::Invalid => "row not usable",
        };
        write!(f, "{:.3} s: {what}", self.time_s)?;
        if let Some([x, y]) = self.offset_mm {
            write!(f, ", off by ({x:.3}, {y:.3}) mm, {:.3} mm", x.hypot(y))?;
        }
        writeln!(f)
    }
}

impl fmt::Display for PathSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows, invalid, touches, departures, farthest_mm } = self;
        writeln!(
            f,
            "{rows} rows, {invalid} not usable, touched {touches} times, left the path {departures} \
             times, {farthest_mm:.3} mm at most"
        )
    }
}
