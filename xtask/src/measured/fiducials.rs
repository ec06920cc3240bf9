//! Fiducials of a mirror, measured with every section of a session: what they say of where the
//! mirror lies, whatever its surface looks like.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use super::readings::shots;

/// A reading belongs to the nominal place that is nearer than this, mm; they are metres apart.
const NEAR_MM: f64 = 50.0;
const NOMINAL: &str = "geometry/reference.yaml";

/// Pairs of nominal and measured places, in the frame of the tables.
pub(super) struct Fiducials {
    pairs_mm: Vec<[[f64; 3]; 2]>,
}

impl Fiducials {
    /// Those of the mirror called `part` in the nominal places, from all sections of a session.
    pub(super) fn read(folder: &Path, session: &Path, part: &str) -> Result<Self> {
        let nominal = nominal(&folder.join(NOMINAL), part)?;
        let mut pairs_mm = Vec::new();
        for section in 1..=5 {
            let (readings, _) = shots(&session.join(format!("ref_{section}.txt")))?;
            for reading in readings {
                let near =
                    |p: &&[f64; 3]| (0..3).all(|k| (p[k] - reading.at_mm[k]).abs() < NEAR_MM);
                pairs_mm.extend(nominal.iter().find(near).map(|p| [*p, reading.at_mm]));
            }
        }
        ensure!(pairs_mm.len() >= 3, "{} fiducials in {}", pairs_mm.len(), session.display());
        Ok(Self { pairs_mm })
    }

    /// Shift and rotation in the plane of the mirror's own frame, with standard uncertainties from
    /// their scatter.
    #[expect(clippy::cast_precision_loss, reason = "some twenty readings")]
    pub(super) fn words(&self, own: impl Fn([f64; 3]) -> [f64; 3]) -> String {
        let n = self.pairs_mm.len() as f64;
        let pairs: Vec<_> = self.pairs_mm.iter().map(|pair| pair.map(&own)).collect();
        let mean = |of: &dyn Fn(&[[f64; 3]; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / n;
        let middle = [mean(&|p| p[0][0]), mean(&|p| p[0][1])];
        let shift = [mean(&|p| p[1][0] - p[0][0]), mean(&|p| p[1][1] - p[0][1])];
        // About the middle: d = shift + γ (−y, x).
        let arm = |p: &[[f64; 3]; 2]| [p[0][0] - middle[0], p[0][1] - middle[1]];
        let off = |p: &[[f64; 3]; 2]| [p[1][0] - p[0][0] - shift[0], p[1][1] - p[0][1] - shift[1]];
        let arms2 = n * mean(&|p| arm(p)[0].powi(2) + arm(p)[1].powi(2));
        let gamma = n * mean(&|p| arm(p)[0] * off(p)[1] - arm(p)[1] * off(p)[0]) / arms2;
        let left2 = n * mean(&|p| {
            let ([x, y], [dx, dy]) = (arm(p), off(p));
            (dx + gamma * y).powi(2) + (dy - gamma * x).powi(2)
        });
        // Three parameters of 2n numbers.
        let sigma_mm = (left2 / (2.0 * n - 3.0)).sqrt();
        format!(
            "fiducials: off by ({:.3}, {:.3}) ± {:.3} mm, turned about z by {:.3} ± {:.3} mrad",
            shift[0],
            shift[1],
            sigma_mm / n.sqrt(),
            1e3 * gamma,
            1e3 * sigma_mm / arms2.sqrt()
        )
    }
}

/// First place of every entry of a section: `name: [[x, y, z], …`.
fn nominal(path: &Path, part: &str) -> Result<Vec<[f64; 3]>> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let start = format!("{part}:");
    let of_part = (text.lines().skip_while(|line| line.trim_end() != start).skip(1))
        .take_while(|line| line.starts_with(' '));
    let place = |line: &str| -> Option<[f64; 3]> {
        let inner = line.split_once("[[")?.1.split_once(']')?.0;
        let numbers: Option<Vec<f64>> = inner.split(',').map(|n| n.trim().parse().ok()).collect();
        <[f64; 3]>::try_from(numbers?).ok()
    };
    Ok(of_part.filter_map(place).collect())
}
