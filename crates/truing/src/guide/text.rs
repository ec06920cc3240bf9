//! Guide points as text for people.

use std::fmt;

use super::answer::Guides;
use crate::layout::written;
use crate::text_table::TextTable;
use crate::{Detail, Layout};

/// Rows that are shown without `-v`.
const SHOWN: usize = 12;

impl fmt::Display for Guides {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl Guides {
    /// The answer for people.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        writeln!(
            f,
            "{} guide points for a ball of radius {} mm that moves along z",
            self.guides.len(),
            self.tip_radius_mm
        )?;
        if self.beside_the_part > 0 {
            writeln!(f, "{} places of the lattice are beside the part", self.beside_the_part)?;
        }
        if layout.detail == Detail::Headline {
            return Ok(());
        }
        writeln!(f)?;
        let columns = [
            "touch",
            "guide x (mm)",
            "guide y (mm)",
            "centre z (mm)",
            "contact x (mm)",
            "contact y (mm)",
            "contact z (mm)",
            "to z (°)",
        ];
        let mut table = TextTable::new("guide points, ball and contact", &columns);
        let shown = if layout.detail == Detail::Full { self.guides.len() } else { SHOWN };
        for g in self.guides.iter().take(shown) {
            table.push(vec![
                g.touch.clone().into(),
                g.guide_x_mm.into(),
                g.guide_y_mm.into(),
                g.center_z_mm.into(),
                g.contact_x_mm.into(),
                g.contact_y_mm.into(),
                g.contact_z_mm.into(),
                g.angle_z_deg.into(),
            ]);
        }
        table.write(f, layout)?;
        if self.guides.len() > shown {
            writeln!(f, "  … and {} more (-v, --json or --out)", self.guides.len() - shown)?;
        }
        Ok(())
    }
}
