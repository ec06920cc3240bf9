//! Targets that an axis could be sent to next.

use ft_center::{Approach, AxisReading};
use serde::Deserialize;

use crate::case::{Finite, Positive};
use crate::kinds::touching::shuffled;
use crate::kinds::{Cells, Offer, Offered, undeclared};

/// `[plan]` of an axis, targets in the unit of the table.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AxisPlanSettings {
    pub(crate) targets: Option<Vec<Finite>>,
    pub(crate) directions: Option<Ways>,
    pub(crate) cycles: Option<u8>,
    pub(crate) minutes_per_measurement: Option<Positive>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Ways {
    Both,
    Rising,
    Falling,
}

/// How a table of an axis names its columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisTable {
    pub(crate) file: &'static str,
    pub(crate) target: &'static str,
    /// What is read, and whether it is the position reached, not a deviation.
    pub(crate) reading: (&'static str, bool),
    /// Whether it has a column `direction`, and one `cycle`.
    pub(crate) has_direction: bool,
    pub(crate) has_cycle: bool,
}

/// Times that a target is offered in every direction where nothing is declared.
const CYCLES: u8 = 3;

impl AxisPlanSettings {
    /// Targets declared, or those that there were and the middles between them, from every side.
    pub(crate) fn offer(&self, table: &AxisTable, readings: &[AxisReading]) -> Offer {
        let mut targets: Vec<f64> = match &self.targets {
            Some(targets) => targets.iter().map(|Finite(target)| *target).collect(),
            None => readings.iter().map(|reading| reading.target).collect(),
        };
        targets.sort_by(f64::total_cmp);
        targets.dedup();
        if self.targets.is_none() {
            let middles: Vec<f64> = targets.windows(2).map(|p| 0.5 * (p[0] + p[1])).collect();
            targets.extend(middles);
        }
        let ways: &[Option<Approach>] = match (table.has_direction, self.directions) {
            (false, _) => &[None],
            (true, None | Some(Ways::Both)) => &[Some(Approach::Rising), Some(Approach::Falling)],
            (true, Some(Ways::Rising)) => &[Some(Approach::Rising)],
            (true, Some(Ways::Falling)) => &[Some(Approach::Falling)],
        };
        let (reading, is_position) = table.reading;
        let mut offered = Vec::new();
        for cycle in 1..=self.cycles.unwrap_or(CYCLES) {
            for target in &targets {
                for way in ways {
                    let at = format!("{target:.6}");
                    let read = if is_position { at.clone() } else { "0".to_owned() };
                    let mut cells: Cells = vec![(table.target, at), (reading, read)];
                    if let Some(way) = way {
                        let word = if *way == Approach::Rising { "+1" } else { "-1" };
                        cells.push(("direction", word.to_owned()));
                    }
                    if table.has_cycle {
                        cells.push(("cycle", format!("plan {cycle}")));
                    }
                    offered.push(Offered::of_row("point", cells));
                }
            }
        }
        Offer {
            table: table.file,
            readings: vec![reading],
            columns: Vec::new(),
            offered: shuffled(&offered),
            noun: "reading",
            is_record: false,
            is_new_session: false,
            controls: Vec::new(),
            undeclared: undeclared(&[("targets", self.targets.is_some())]),
            made: None,
            minutes: self.minutes_per_measurement.map(|Positive(minutes)| minutes),
            reach: None,
        }
    }
}
