use std::fmt::Write as _;

use ft_center::{AxisFigures, AxisMotion, AxisReading, OneWay, TargetFigures, axis_figures};
use serde::Serialize;
use truing_report::{COMPENSATED, Curve, CurvePlot, ExtraPlot};

use crate::estimated::{Estimated, Export};
use crate::implausible::ImplausibleResult;
use crate::text_table::TextTable;

/// Triplets that LinuxCNC reads at most.
const LINUXCNC_MOST: usize = 256;
const ARCSEC_PER_DEG: f64 = 3600.0;
/// Half a 95 % interval, in standard uncertainties.
const HALF_95: f64 = 1.96;

/// Largest distance by which an axis misses a target: a tooth of a rack, or half a turn of a screw.
const MAX_POSITION_MM: f64 = 5.0;
/// The same of a rotary axis: a degree, as for its compensation.
const MAX_POSITION_ARCSEC: f64 = 3600.0;

/// An axis over its targets.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisRunEstimate {
    /// Unit of targets: `mm` or `deg`.
    pub target_unit: &'static str,
    /// Unit of figures and deviations: `mm` or `arcsec`.
    pub unit: &'static str,
    /// By ISO 230-2, of the readings as they are.
    pub figures: Vec<AxisFigureEstimate>,
    /// The same with the accepted effects taken off; `None` in `solve`.
    pub corrected: Option<Vec<AxisFigureEstimate>>,
    /// Compensation table, ascending.
    pub targets: Vec<AxisTargetEstimate>,
}

/// One figure of ISO 230-2.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisFigureEstimate {
    /// Symbol, a direction in words: `A`, `R rising`.
    pub symbol: &'static str,
    /// Name.
    pub name: &'static str,
    /// Value; `None` where the readings do not give it.
    pub value: Option<f64>,
    /// Standard uncertainty.
    pub std: Option<f64>,
}

/// One target, deviations as read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisTargetEstimate {
    /// The target.
    pub target: f64,
    /// Readings that came from smaller positions.
    pub n_rising: usize,
    /// Their mean.
    pub mean_rising: Option<f64>,
    /// Their standard deviation.
    pub std_rising: Option<f64>,
    /// Readings that came from larger positions.
    pub n_falling: usize,
    /// Their mean.
    pub mean_falling: Option<f64>,
    /// Their standard deviation.
    pub std_falling: Option<f64>,
    /// Mean of both ways, or of the one there is: what a compensation takes off.
    pub mean: f64,
    /// Rising less falling: what a compensation of backlash takes off.
    pub reversal: Option<f64>,
}

impl AxisRunEstimate {
    /// Of a run with its length standard; `residuals` with the accepted effects taken off.
    pub(crate) fn of(
        readings: &[AxisReading],
        motion: AxisMotion,
        length_ratio: Option<f64>,
        residuals: Option<&[f64]>,
    ) -> Self {
        let ratio = length_ratio.unwrap_or(0.0);
        let found = axis_figures(readings, ratio);
        let corrected = residuals.map(|residuals| {
            let freed: Vec<AxisReading> = (readings.iter().zip(residuals))
                .map(|(r, residual)| AxisReading { deviation: *residual, ..r.clone() })
                .collect();
            listed(&axis_figures(&freed, ratio))
        });
        Self {
            target_unit: motion.target_unit(),
            unit: motion.deviation_unit(),
            figures: listed(&found),
            corrected,
            targets: found.targets.iter().map(AxisTargetEstimate::of).collect(),
        }
    }

    pub(crate) fn parameters(&self) -> Vec<Estimated> {
        let value = |f: &AxisFigureEstimate, of: &str| {
            let name = format!("{}{of}", f.symbol);
            Some(Estimated::new(&name, self.unit, f.value?, f.std))
        };
        let mut all: Vec<Estimated> = self.figures.iter().filter_map(|f| value(f, "")).collect();
        let corrected = self.corrected.iter().flatten();
        all.extend(corrected.filter_map(|f| value(f, COMPENSATED)));
        all
    }

    pub(crate) fn table(&self) -> TextTable {
        let columns = if self.unit == "mm" {
            [
                "target mm",
                "mean mm",
                "reversal mm",
                "rising mm",
                "s rising mm",
                "falling mm",
                "s falling mm",
            ]
        } else {
            [
                "target deg",
                "mean arcsec",
                "reversal arcsec",
                "rising arcsec",
                "s rising arcsec",
                "falling arcsec",
                "s falling arcsec",
            ]
        };
        let mut table = TextTable::new("compensation table, by target", &columns);
        for t in &self.targets {
            table.push(vec![
                t.target.into(),
                t.mean.into(),
                t.reversal.into(),
                t.mean_rising.into(),
                t.std_rising.into(),
                t.mean_falling.into(),
                t.std_falling.into(),
            ]);
        }
        table
    }

    pub(crate) fn plot(&self) -> ExtraPlot {
        type Of = fn(&AxisTargetEstimate) -> (usize, Option<f64>, Option<f64>);
        let ways: [(&str, Of); 2] = [
            ("rising", |t| (t.n_rising, t.mean_rising, t.std_rising)),
            ("falling", |t| (t.n_falling, t.mean_falling, t.std_falling)),
        ];
        let (factor, unit) = if self.unit == "mm" { (1e3, "µm") } else { (1.0, "″") };
        let curve = |(name, of): (&str, Of)| {
            let mut curve = Curve {
                name: name.to_owned(),
                points: Vec::new(),
                half_widths: Vec::new(),
                joined: true,
            };
            for t in &self.targets {
                if let (n, Some(mean), std) = of(t) {
                    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
                    let of_mean = std.unwrap_or(0.0) / (n as f64).sqrt();
                    curve.points.push([t.target, factor * mean]);
                    curve.half_widths.push(HALF_95 * factor * of_mean);
                }
            }
            curve
        };
        let curves: Vec<Curve> =
            ways.into_iter().map(curve).filter(|c| !c.points.is_empty()).collect();
        ExtraPlot::Curves(CurvePlot {
            title: "Deviation by target and direction of approach".to_owned(),
            caption: "Means of the readings as they are; bands are 95 % intervals.".to_owned(),
            x_title: format!("target ({})", self.target_unit),
            y_title: format!("deviation ({unit})"),
            curves,
        })
    }

    /// Names and numbers of the compensation table, or triplets of LinuxCNC.
    pub(crate) fn export(&self, format: Export) -> Option<String> {
        match format {
            Export::Csv => Some(self.csv()),
            Export::LinuxCnc => Some(self.linuxcnc()),
            Export::Heidenhain | Export::PointErrors(_) => None,
        }
    }

    /// A target missed by more than any machine does.
    pub(crate) fn implausible(&self) -> Option<ImplausibleResult> {
        let off = |t: &&AxisTargetEstimate| t.mean.abs();
        let worst = self.targets.iter().max_by(|a, b| off(a).total_cmp(&off(b)))?;
        let limit = if self.unit == "mm" { MAX_POSITION_MM } else { MAX_POSITION_ARCSEC };
        (off(&worst) > limit).then(|| ImplausibleResult::Position {
            target: worst.target,
            target_unit: self.target_unit,
            found: off(&worst),
            unit: self.unit,
            limit,
        })
    }

    fn csv(&self) -> String {
        let (at, unit) = (self.target_unit, self.unit);
        let mut text = format!(
            "target_{at},mean_{unit},reversal_{unit},mean_rising_{unit},std_rising_{unit},n_rising,\
             mean_falling_{unit},std_falling_{unit},n_falling\n"
        );
        let cell = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.9e}"));
        for t in &self.targets {
            let cells = [
                t.target.to_string(),
                cell(Some(t.mean)),
                cell(t.reversal),
                cell(t.mean_rising),
                cell(t.std_rising),
                t.n_rising.to_string(),
                cell(t.mean_falling),
                cell(t.std_falling),
                t.n_falling.to_string(),
            ];
            // A string takes every character.
            let _ = writeln!(text, "{}", cells.join(","));
        }
        text
    }

    /// «nominal forward reverse», `COMP_FILE_TYPE = 0`: where the axis is when it was sent there. A way
    /// that was not measured is taken as the other.
    fn linuxcnc(&self) -> String {
        let factor = if self.unit == "mm" { 1.0 } else { 1.0 / ARCSEC_PER_DEG };
        let stride = self.targets.len().div_ceil(LINUXCNC_MOST - 1).max(1);
        let last = self.targets.len().saturating_sub(1);
        let mut text = String::new();
        let kept = self.targets.iter().enumerate().filter(|(i, _)| i % stride == 0 || *i == last);
        for (_, t) in kept {
            let [forward, reverse] = [t.mean_rising, t.mean_falling]
                .map(|mean| t.target + factor * mean.unwrap_or(t.mean));
            // A string takes every character.
            let _ = writeln!(text, "{:.9} {forward:.9} {reverse:.9}", t.target);
        }
        text
    }
}

fn listed(found: &AxisFigures) -> Vec<AxisFigureEstimate> {
    let of = |f: &ft_center::Figure| AxisFigureEstimate {
        symbol: f.symbol,
        name: f.name,
        value: f.value,
        std: f.std,
    };
    found.figures.iter().map(of).collect()
}

impl AxisTargetEstimate {
    fn of(t: &TargetFigures) -> Self {
        let n = |way: Option<OneWay>| way.map_or(0, |w| w.n);
        Self {
            target: t.target,
            n_rising: n(t.rising),
            mean_rising: t.rising.map(|w| w.mean),
            std_rising: t.rising.and_then(|w| w.std),
            n_falling: n(t.falling),
            mean_falling: t.falling.map(|w| w.mean),
            std_falling: t.falling.and_then(|w| w.std),
            mean: t.mean(),
            reversal: t.reversal(),
        }
    }
}
