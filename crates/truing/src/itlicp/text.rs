//! ITLICP beside the exact pose as text for people.

use std::fmt;

use super::answer::{Itlicp, PoseBeside};
use crate::layout::written;
use crate::text_table::TextTable;
use crate::{Detail, Layout};

/// Name, value and unit of a number of a pose.
type Row = (&'static str, fn(&PoseBeside) -> f64, &'static str);

impl fmt::Display for Itlicp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(f, Layout::default())
    }
}

impl Itlicp {
    /// The answer for people.
    #[must_use]
    pub fn text(&self, layout: Layout) -> String {
        written(|text| self.write(text, layout))
    }

    fn write(&self, f: &mut dyn fmt::Write, layout: Layout) -> fmt::Result {
        let method = if self.coarse_mm.is_some() { "ITLICP [D]" } else { "classical ICP [D]" };
        let sampled: Vec<String> = (self.levels.iter())
            .map(|l| format!("{} points, {} passes", l.model_points, l.iterations))
            .collect();
        writeln!(f, "{method}: {}", sampled.join("; then "))?;
        if let Some(timing) = &self.timing {
            writeln!(f, "{:.3} s; the exact pose takes {:.6} s", timing.itlicp_s, timing.exact_s)?;
        }
        if layout.detail == Detail::Headline {
            return Ok(());
        }
        writeln!(f)?;
        let columns = ["", method, "exact", "unit"];
        let mut table = TextTable::of_quantities("pose, and what it leaves", &columns);
        let (a, b) = (&self.itlicp, &self.exact);
        let rows: [Row; 8] = [
            ("x", |p| p.numbers.x_mm, "mm"),
            ("y", |p| p.numbers.y_mm, "mm"),
            ("z", |p| p.numbers.z_mm, "mm"),
            ("alpha", |p| p.numbers.alpha_deg, "°"),
            ("beta", |p| p.numbers.beta_deg, "°"),
            ("gamma", |p| p.numbers.gamma_deg, "°"),
            ("rms", |p| 1e3 * p.rms_mm, "µm"),
            ("largest", |p| 1e3 * p.largest_mm, "µm"),
        ];
        for (name, of, unit) in rows {
            // A tenth of what the best instrument resolves.
            let decimals = match unit {
                "mm" => 5,
                "°" => 6,
                _ => 2,
            };
            let shown = |pose| format!("{:.decimals$}", of(pose));
            table.push(vec![name.into(), shown(a).into(), shown(b).into(), unit.into()]);
        }
        table.write(f, layout)?;
        writeln!(f)?;
        let columns = ["point", "use", "residual µm", "exact µm"];
        let mut table = TextTable::new("points", &columns);
        for point in &self.points {
            let um = |mm: Option<f64>| mm.map(|mm| 1e3 * mm);
            table.push(vec![
                point.point.as_str().into(),
                point.usage.into(),
                um(point.residual_mm).into(),
                um(point.exact_residual_mm).into(),
            ]);
        }
        table.write(f, layout)
    }
}
