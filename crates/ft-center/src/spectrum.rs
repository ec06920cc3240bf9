//! Spectrum of a planar signal at uneven times, for finding the spin.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use nalgebra::Complex;

/// Most cells that a record is sorted into; a 30 s record then reaches 2 kHz.
const MAX_CELLS: usize = 1 << 17;

/// Bins on either side of a line that are the line itself.
const LINE_BINS: usize = 2;

/// Bins on either side that show the noise around a line.
const NEIGHBOUR_BINS: usize = 24;

/// Fewest neighbours from which the noise around a line can be told.
const MIN_NEIGHBOURS: f64 = 12.0;

/// Mean logarithm of the sum of two unit exponentials, ψ(2) = 1 − γ.
const MEAN_LOG_OF_TWO: f64 = 0.422_784_335_098_467_1;

/// Variance of the same logarithm, ψ'(2) = π²/6 − 1.
const LOG_VARIANCE_OF_TWO: f64 = 0.644_934_066_848_226_4;

/// Power of `x + iy` at positive frequencies, both senses of rotation added.
///
/// Samples are sorted into cells of equal length and the record is padded to twice its length,
/// so that bins are half as wide as the record resolves.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    power: Vec<f64>,
    bin_hz: f64,
    /// First bin that makes two turns in the record.
    first: usize,
    /// One past the last bin under the mean Nyquist frequency.
    end: usize,
}

impl Spectrum {
    /// `signal` at `time_s`, increasing; two samples or more.
    pub(crate) fn of(time_s: &[f64], signal: &[[f64; 2]]) -> Self {
        let n = time_s.len();
        let start = time_s[0];
        let length_s = (time_s[n - 1] - start) * crate::count(n) / crate::count(n - 1);
        let cells = (2 * n).next_power_of_two().min(MAX_CELLS);
        let mut grid = vec![Complex::new(0.0, 0.0); 2 * cells];
        for (t, s) in time_s.iter().zip(signal) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a share of the record's length, cut to the grid"
            )]
            let cell = ((t - start) / length_s * crate::count(cells)) as usize;
            grid[cell.min(cells - 1)] += Complex::new(s[0], s[1]);
        }
        transform(&mut grid);
        let half = cells;
        let power = (0..half)
            .map(|k| grid[k].norm_sqr() + grid[(2 * cells - k) % (2 * cells)].norm_sqr())
            .collect();
        // Bin k is k/2 turns in the record; the mean Nyquist frequency is n/2 turns.
        Self { power, bin_hz: 0.5 / length_s, first: 4, end: n.min(half) }
    }

    /// Frequencies of the highest line and of the one that stands out most from its neighbours,
    /// which slow noise or the leakage of the line itself may tell apart.
    pub(crate) fn candidates_hz(&self) -> Vec<f64> {
        let highest = |strength: &dyn Fn(usize) -> Option<f64>| {
            let bins = (self.first..self.end).filter_map(|k| Some((k, strength(k)?)));
            bins.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
        };
        let tallest = highest(&|k| Some(self.power[k]));
        // Each bin is a neighbour of many: its logarithms are taken once.
        let logs: Vec<[f64; 2]> = (0..self.end).map(|j| self.logs(j)).collect();
        let clearest = highest(&|k| Some(self.background(k, |j| logs[j])?.ratio(self.power[k])));
        let mut bins: Vec<_> = tallest.into_iter().chain(clearest).collect();
        bins.dedup();
        bins.into_iter().map(|k| crate::count(k) * self.bin_hz).collect()
    }

    /// Power of both senses of rotation at a frequency.
    pub(crate) fn power(&self, frequency_hz: f64) -> f64 {
        self.bin(frequency_hz).map_or(0.0, |k| self.power[k])
    }

    /// Chance that noise like that of this spectrum makes a line of `power` at a frequency; 1
    /// where the noise around it is not seen.
    pub(crate) fn p_value(&self, frequency_hz: f64, power: f64) -> f64 {
        let background = self.bin(frequency_hz).and_then(|k| self.background(k, |j| self.logs(j)));
        background.map_or(1.0, |b| tail(b.ratio(power)))
    }

    /// Independent frequencies that are searched.
    pub(crate) fn trials(&self) -> f64 {
        0.5 * crate::count(self.end.saturating_sub(self.first))
    }

    /// Mean power of the noise around a frequency, one sense of rotation.
    pub(crate) fn noise_power(&self, frequency_hz: f64) -> Option<f64> {
        Some(self.background(self.bin(frequency_hz)?, |j| self.logs(j))?.power)
    }

    fn bin(&self, frequency_hz: f64) -> Option<usize> {
        let k = (frequency_hz.abs() / self.bin_hz).round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to lie within the table"
        )]
        (k < crate::count(self.power.len())).then_some(k as usize)
    }

    /// Logarithms of a bin and of its power.
    fn logs(&self, j: usize) -> [f64; 2] {
        [crate::count(j).ln(), self.power[j].ln()]
    }

    /// Mean noise power of one sense of rotation around bin `k`: a power law through its
    /// neighbours, by their [`Self::logs`], so that the steep spectrum of slow noise makes no line of
    /// its own.
    fn background(&self, k: usize, logs: impl Fn(usize) -> [f64; 2]) -> Option<Background> {
        let below = k.saturating_sub(2 * NEIGHBOUR_BINS).max(1)..k.saturating_sub(2 * LINE_BINS);
        let above = k + 2 * LINE_BINS + 1..(k + 2 * NEIGHBOUR_BINS + 1).min(self.end);
        let mut sums = LineFit::default();
        let origin = crate::count(k.max(1)).ln();
        for j in below.chain(above).filter(|&j| self.power[j] > 0.0) {
            let [bin, power] = logs(j);
            sums.add(bin - origin, power);
        }
        sums.at_origin()
    }
}

/// Noise around a line.
#[derive(Clone, Copy, Debug)]
struct Background {
    /// Mean power of one sense of rotation.
    power: f64,
    /// Standard uncertainty of its logarithm.
    log_std: f64,
}

impl Background {
    /// Power of a line over the noise, the noise taken two standard uncertainties up.
    fn ratio(&self, line: f64) -> f64 {
        line / (self.power * (2.0 * self.log_std).exp())
    }
}

/// Straight line through logarithms of power.
#[derive(Clone, Copy, Debug, Default)]
struct LineFit {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
}

impl LineFit {
    fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
    }

    /// Height at `x = 0`; `None` where too few points tell.
    fn at_origin(&self) -> Option<Background> {
        let spread = self.n * self.xx - self.x * self.x;
        if self.n < MIN_NEIGHBOURS || spread <= 0.0 {
            return None;
        }
        let height = (self.xx * self.y - self.x * self.xy) / spread;
        // Neighbouring bins, half as wide as the record resolves, are correlated in pairs.
        let variance = 2.0 * LOG_VARIANCE_OF_TWO * self.xx / spread;
        Some(Background { power: (height - MEAN_LOG_OF_TWO).exp(), log_std: variance.sqrt() })
    }
}

/// Chance of noise power above `ratio` times its mean.
///
/// That of an exponential of mean two: right where the noise shakes along one line, too large
/// (on the safe side) where it is round.
fn tail(ratio: f64) -> f64 {
    // NaN: a record without any noise and without any line.
    if ratio.is_nan() { 1.0 } else { (-0.5 * ratio).exp() }
}

/// `e^(−2πi k/n)` for the first half of the turn, `n` being two to the power `bits`; made once.
fn roots(bits: u32) -> &'static [Complex<f64>] {
    static MADE: [OnceLock<Vec<Complex<f64>>>; MAX_CELLS.trailing_zeros() as usize + 2] =
        [const { OnceLock::new() }; MAX_CELLS.trailing_zeros() as usize + 2];
    MADE[bits as usize].get_or_init(|| {
        let n = 1 << bits;
        let root = |k| Complex::from_polar(1.0, -TAU * crate::count(k) / crate::count(n));
        (0..n / 2).map(root).collect()
    })
}

/// In-place radix-2 Fourier transform, `Σ x e^(−2πi jk/n)`; the length is a power of two.
fn transform(x: &mut [Complex<f64>]) {
    let n = x.len();
    let bits = n.trailing_zeros();
    for i in 0..n {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            x.swap(i, j);
        }
    }
    let roots = roots(bits);
    let mut half = 1;
    while half < n {
        let stride = n / (2 * half);
        for block in x.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turned = roots[k * stride] * *b;
                *b = *a - turned;
                *a += turned;
            }
        }
        half *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off of 64 sums of unit terms.
    const EXACT: f64 = 1e-12;

    /// One point, and any number at one frequency, have no slope; fewer than enough are not trusted.
    #[test]
    fn a_background_needs_enough_neighbours_that_lie_apart() {
        let through = |points: &[f64]| {
            let mut line = LineFit::default();
            for x in points {
                line.add(*x, 3.0 - 2.0 * x);
            }
            line.at_origin()
        };
        let apart: Vec<f64> = (0_i32..12).map(|i| f64::from(i) / 8.0 - 0.5).collect();
        assert_eq!(crate::count(apart.len()).to_bits(), MIN_NEIGHBOURS.to_bits());
        assert!(through(&apart[1..]).is_none());
        assert!(through(&[0.5; 12]).is_none());
        // The logarithm of two halves of an exponential lies under that of its mean by this.
        let height = through(&apart).unwrap().power.ln() + MEAN_LOG_OF_TWO;
        assert!((height - 3.0).abs() < EXACT, "{height}");
    }

    #[test]
    fn transform_matches_the_sum_it_stands_for() {
        let n = 64;
        let x: Vec<_> = (0..n)
            .map(|i| Complex::new((f64::from(i) * 0.7).sin(), (f64::from(i * i) * 0.1).cos()))
            .collect();
        let mut fast = x.clone();
        transform(&mut fast);
        for (k, value) in fast.iter().enumerate() {
            let term = |(i, v): (usize, &Complex<f64>)| {
                v * Complex::from_polar(1.0, -TAU * crate::count(i * k) / f64::from(n))
            };
            let slow: Complex<f64> = x.iter().enumerate().map(term).sum();
            assert!((slow - value).norm() < EXACT * f64::from(n), "bin {k}");
        }
    }
}
