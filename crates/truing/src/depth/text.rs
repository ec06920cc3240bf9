//! Depths as text for people.

use std::fmt;

use super::answer::{Depth, DepthAt, DepthRange};
use crate::layout::written;
use crate::text_table::{Cell, EXPANDED, TextTable};
use crate::{Detail, Layout};

/// Rows of the table of points that are shown without `-v`.
const SHOWN: usize = 10;

impl fmt::Display for Depth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl Depth {
    /// The answer for people, the decision first.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        if let Some(within) = &self.within {
            let about = match self.tool.depth_mm {
                Some(asked) => format!("{asked} mm"),
                None => "the planned depth".to_owned(),
            };
            // Never rounded up to a certainty.
            let percent = (1e3 * within.probability).floor() / 10.0;
            writeln!(
                f,
                "{}: every depth within ± {} mm of {about} with a probability of {percent:.1} % or \
                 more (asked: {:.0} %), the least in line {}",
                within.decision,
                self.tool.tolerance_mm,
                100.0 * within.required,
                within.line
            )?;
        }
        let range = |range: &DepthRange| {
            let DepthRange { least_mm, mean_mm, largest_mm } = range;
            format!("{least_mm:.4} to {largest_mm:.4} mm, mean {mean_mm:.4} mm")
        };
        if let Some(as_written) = &self.as_written {
            writeln!(f, "depth as written: {}", range(as_written))?;
        }
        if let Some(corrected) = &self.corrected {
            writeln!(f, "depth as corrected: {}", range(corrected))?;
        }
        if let Some(std) = self.std_mm {
            writeln!(f, "largest U (k = 2) of a corrected depth: {:.2} µm", 2e3 * std)?;
        }
        if let Some(removal) = &self.removal {
            let percent = 200.0 * removal.largest_std_ratio;
            writeln!(
                f,
                "removal as depth to the power {}: U (k = 2) up to {percent:.2} %",
                removal.exponent
            )?;
        }
        writeln!(
            f,
            "{} points polish the part, {} lie beside it, {} above the film",
            self.points, self.beside_the_part, self.above_the_film
        )?;
        if layout.detail == Detail::Headline {
            return Ok(());
        }
        writeln!(f)?;
        self.table(layout.detail == Detail::Full).write(f, layout)
    }

    /// The points, those with the largest uncertainty first where not all are shown.
    fn table(&self, all: bool) -> TextTable {
        let mut at: Vec<&DepthAt> = self.depths.iter().collect();
        let title = if all || at.len() <= SHOWN {
            "depths along the program".to_owned()
        } else {
            at.sort_by(|a, b| b.std_mm.unwrap_or(0.0).total_cmp(&a.std_mm.unwrap_or(0.0)));
            at.truncate(SHOWN);
            format!("the {SHOWN} least certain of {} depths", self.depths.len())
        };
        let columns = ["line", "x mm", "y mm", "z mm", "depth", EXPANDED, "unit"];
        let mut table = TextTable::new(title, &columns);
        for one in at {
            table.push(vec![
                one.line.to_string().into(),
                one.x_mm.into(),
                one.y_mm.into(),
                one.z_mm.into(),
                Cell::Known(one.depth_mm, one.std_mm),
                Cell::Expanded(one.std_mm),
                "mm".into(),
            ]);
        }
        table
    }
}
