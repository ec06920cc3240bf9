//! A log averaged over short blocks, which keep what the effects do and leave fewer rows.

use std::ops::Range;

use crate::missing::log_sensitivity::Sensitivity;
use crate::{ForceFormula, Head, LogSample, LoggedForce};

/// Most blocks of a log: the loop's time grows with their number, what it can tell hardly does.
const MAX_BLOCKS: usize = 400;
/// Groups that a log of few segments is cut into.
const N_GROUPS: usize = 16;
/// Segments from which on they are the groups themselves.
const ENOUGH_SEGMENTS: usize = 6;
/// The slide is taken to move when its speed is this many times what noise makes of it.
const CLEAR_SPEED: f64 = 3.0;
/// Median of |fourth difference| of white noise over its standard deviation: 0.6745·√70. The motion
/// itself leaves nearly nothing in it.
const FOURTH_DIFFERENCE: f64 = 5.643;
/// Time over which the speed of the slide is taken.
const SPEED_SPAN_S: f64 = 0.04;

/// Mean over a block of samples.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    pub(crate) samples: Range<usize>,
    pub(crate) segment: usize,
    /// Time from the beginning of the log as a share of its length.
    pub(crate) elapsed_share: f64,
    pub(crate) normal_n: f64,
    /// Normal force − reference, N, or consistency, mm.
    pub(crate) residual: f64,
    pub(crate) noise_gain: f64,
    /// Mean of −1, 0, +1 as the axial unit shortens, stands, extends.
    pub(crate) slide: f64,
    /// `slide` times how much of an axial force is normal.
    pub(crate) slide_normal: f64,
    pub(crate) sensitivity: Sensitivity,
    /// Columns `…_c` of the log, K from 20 °C.
    pub(crate) warmth_k: Vec<f64>,
}

/// Blocks of at most one segment each, in the order measured.
pub(crate) fn ranges(samples: &[LogSample]) -> Vec<(usize, Range<usize>)> {
    let length = samples.len().div_ceil(MAX_BLOCKS);
    let mut ranges = Vec::new();
    let mut start = 0;
    for run in samples.chunk_by(|a, b| a.segment == b.segment) {
        // Of equal length within a segment, so that no block is a lone sample.
        let n = run.len().div_ceil(length);
        let cut = |i: usize| start + i * run.len() / n;
        ranges.extend((0..n).map(|i| (run[0].segment, cut(i)..cut(i + 1))));
        start += run.len();
    }
    ranges
}

/// Group of each block, and the groups' names: segments, or pieces of them where they are few.
pub(crate) fn groups(blocks: &[Block], names: &[String]) -> (Vec<usize>, Vec<String>) {
    let runs: Vec<&[Block]> = blocks.chunk_by(|a, b| a.segment == b.segment).collect();
    let per_run = if runs.len() >= ENOUGH_SEGMENTS { 1 } else { N_GROUPS.div_ceil(runs.len()) };
    let (mut of_block, mut labels) = (Vec::new(), Vec::new());
    for run in runs {
        let pieces = per_run.min(run.len());
        let name = names.get(run[0].segment).map_or("log", String::as_str);
        let first = labels.len();
        of_block.extend((0..run.len()).map(|i| first + i * pieces / run.len()));
        if pieces == 1 {
            labels.push(name.to_owned());
        } else {
            labels.extend((1..=pieces).map(|piece| format!("{name}, part {piece}")));
        }
    }
    (of_block, labels)
}

/// A log, and how its forces are had from it.
#[derive(Clone, Debug)]
pub(crate) struct Recorded {
    pub(crate) head: Head,
    pub(crate) samples: Vec<LogSample>,
    pub(crate) solved: Vec<LoggedForce>,
    pub(crate) formula: ForceFormula,
    /// One column per temperature.
    pub(crate) warmth_k: Vec<Vec<f64>>,
}

/// Every sample as a block of its own.
pub(crate) fn single(samples: &[LogSample]) -> Vec<(usize, Range<usize>)> {
    samples.iter().enumerate().map(|(i, sample)| (sample.segment, i..i + 1)).collect()
}

/// Averages a log over ranges of samples.
pub(crate) fn blocks(log: &Recorded, ranges: Vec<(usize, Range<usize>)>) -> Vec<Block> {
    let Recorded { head, samples, solved, formula, warmth_k } = log;
    let slide = slide(samples);
    let clock = Clock::of(samples);
    let average = |(segment, range): (usize, Range<usize>)| {
        let share = 1.0 / crate::count(range.len());
        let mut block = Block {
            samples: range.clone(),
            segment,
            elapsed_share: 0.0,
            normal_n: 0.0,
            residual: 0.0,
            noise_gain: 0.0,
            slide: 0.0,
            slide_normal: 0.0,
            sensitivity: Sensitivity::default(),
            warmth_k: warmth_k
                .iter()
                .map(|w| share * w[range.clone()].iter().sum::<f64>())
                .collect(),
        };
        for i in range {
            let at = Sensitivity::of(head, &solved[i].tip_mm, &samples[i], *formula);
            block.sensitivity.add(&at, share);
            block.elapsed_share += share * clock.share(i, samples);
            block.normal_n += share * solved[i].normal_n;
            block.residual += share * solved[i].residual_n.unwrap_or(solved[i].consistency_mm);
            block.noise_gain += share * solved[i].noise_gain;
            block.slide += share * slide[i];
            block.slide_normal += share * slide[i] * at.axial_share;
        }
        block
    };
    ranges.into_iter().map(average).collect()
}

/// Time since the log began, also where every segment starts its own clock.
struct Clock {
    runs_on: bool,
    start_s: f64,
    length_s: f64,
    n: f64,
}

impl Clock {
    fn of(samples: &[LogSample]) -> Self {
        let (first, last) = (samples[0].time_s, samples[samples.len() - 1].time_s);
        let runs_on = samples.windows(2).all(|pair| pair[0].time_s < pair[1].time_s);
        let n = crate::count(samples.len().max(2) - 1);
        Self { runs_on, start_s: first, length_s: (last - first).max(f64::MIN_POSITIVE), n }
    }

    fn share(&self, i: usize, samples: &[LogSample]) -> f64 {
        if self.runs_on {
            (samples[i].time_s - self.start_s) / self.length_s
        } else {
            crate::count(i) / self.n
        }
    }
}

/// Direction of the axial unit at each sample, between −1 and 1 where noise could be all.
fn slide(samples: &[LogSample]) -> Vec<f64> {
    let axial = |i: usize| samples[i].lengths_mm[3];
    let mut out = Vec::with_capacity(samples.len());
    let mut start = 0;
    for run in samples.chunk_by(|a, b| a.segment == b.segment) {
        let last = start + run.len() - 1;
        let interval_s =
            (run[run.len() - 1].time_s - run[0].time_s) / crate::count(last - start).max(1.0);
        let half = if interval_s > 0.0 { 0.5 * SPEED_SPAN_S / interval_s } else { 1.0 };
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "small, positive"
        )]
        let half = half.clamp(1.0, 1000.0) as usize;
        let noise_mm = noise(run);
        for i in start..=last {
            let (from, to) = (i.saturating_sub(half).max(start), (i + half).min(last));
            let moved_mm = axial(to) - axial(from);
            let clear_mm = CLEAR_SPEED * 2f64.sqrt() * noise_mm;
            let share = if clear_mm > 0.0 {
                (moved_mm / clear_mm).clamp(-1.0, 1.0)
            } else {
                sign(moved_mm)
            };
            out.push(share);
        }
        start = last + 1;
    }
    out
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Standard deviation of the axial readings from sample to sample.
fn noise(run: &[LogSample]) -> f64 {
    let axial = |s: &LogSample| s.lengths_mm[3];
    let fourth = |w: &[LogSample]| {
        axial(&w[0]) - 4.0 * axial(&w[1]) + 6.0 * axial(&w[2]) - 4.0 * axial(&w[3]) + axial(&w[4])
    };
    let mut bends: Vec<f64> = run.windows(5).map(|w| fourth(w).abs()).collect();
    if bends.is_empty() {
        return 0.0;
    }
    bends.sort_by(f64::total_cmp);
    bends[bends.len() / 2] / FOURTH_DIFFERENCE
}
