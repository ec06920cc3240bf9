//! The two passes over all blocks, in chunks that do not depend on the number of threads.

use std::ops::Range;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use super::block::{Place, Scratch};
use super::eliminate::{Eliminate, Sums};
use super::lanes::LANES;
use super::program::{PANEL, Program};
use super::simd::dispatch;
use super::trial::{Gain, Steps, Try};
use super::{BorderedPoint, BorderedProblem};
use crate::RobustRows;

/// Fewest blocks in a chunk, for whose sake alone another thread is not woken.
const MIN_BLOCKS: usize = 64;
/// Most chunks; each has sums of its own.
const MAX_CHUNKS: usize = 32;
/// Numbers in the sums of all chunks above which there are fewer chunks.
const MAX_NUMBERS: usize = 1 << 20;

/// A range of blocks with room for its sums.
pub(super) struct Chunk {
    pub(super) blocks: Range<usize>,
    scratch: Scratch,
    steps: Steps,
    pub(super) sums: Sums,
    gain: Gain,
}

/// Blocks in a chunk, but for the last.
pub(super) fn chunk_length(program: &Program) -> usize {
    let width = program.first.len() * PANEL;
    let most = (MAX_NUMBERS / width.pow(2)).clamp(1, MAX_CHUNKS);
    let length = program.block_count.div_ceil(most).next_multiple_of(LANES);
    length.max(MIN_BLOCKS)
}

/// Cuts the blocks into chunks.
pub(super) fn chunks(program: &Program) -> Vec<Chunk> {
    let length = chunk_length(program);
    let starts = (0..program.block_count.max(1)).step_by(length);
    starts
        .map(|start| Chunk {
            blocks: start..(start + length).min(program.block_count),
            scratch: Scratch::new(program),
            steps: Steps::new(program),
            sums: Sums::new(program),
            gain: Gain::default(),
        })
        .collect()
}

/// What does not change during a search.
pub(super) struct Setting<'a, P> {
    pub(super) problem: &'a P,
    pub(super) program: &'a Program,
    pub(super) robust: &'a [RobustRows],
}

impl<P: BorderedProblem> Setting<'_, P> {
    /// Linearises all blocks and eliminates them; the first chunk holds the sums of all.
    pub(super) fn eliminate(&self, chunks: &mut [Chunk], point: &BorderedPoint, damping: f64) {
        let Self { problem, program, robust } = *self;
        let place = Place { problem, program, robust, point };
        for_each(chunks, |Chunk { blocks, scratch, sums, .. }| {
            let blocks = blocks.clone();
            dispatch(Eliminate { place, blocks, damping, scratch, sums });
        });
        let (first, rest) = chunks.split_first_mut().expect("there is always a chunk");
        for chunk in rest {
            first.sums.add(&chunk.sums);
        }
    }

    /// Moves all blocks along with the shared point, which `moved` already holds.
    pub(super) fn step(
        &self,
        chunks: &mut [Chunk],
        point: &BorderedPoint,
        step: &[f64],
        damping: f64,
        moved: &mut BorderedPoint,
    ) -> Gain {
        let Self { problem, program, robust } = *self;
        let block_len = point.block_len(program.block_count);
        let length = chunks[0].blocks.len() * block_len;
        let BorderedPoint { shared, blocks: moved } = moved;
        let shared = &*shared;
        let place = Place { problem, program, robust, point };
        for_each_with(
            chunks,
            moved,
            length,
            |Chunk { blocks, scratch, steps, gain, .. }, moved| {
                let blocks = blocks.clone();
                *gain =
                    dispatch(Try { place, damping, step, shared, blocks, moved, scratch, steps });
            },
        );
        let mut total = Gain::default();
        for chunk in chunks {
            total.add(chunk.gain);
        }
        total
    }
}

/// What `work` makes of ranges that together are `0..count`, on as many threads as there are.
pub(super) fn map_chunks<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> T + Sync + Send,
) -> Vec<T> {
    let length = count.div_ceil(MAX_CHUNKS).max(MIN_BLOCKS);
    let range = |chunk: usize| chunk * length..((chunk + 1) * length).min(count);
    let chunks = 0..count.div_ceil(length);
    #[cfg(feature = "parallel")]
    if chunks.len() > 1 {
        return chunks.into_par_iter().map(|chunk| work(range(chunk))).collect();
    }
    chunks.map(|chunk| work(range(chunk))).collect()
}

/// Calls `work` on every chunk, on as many threads as there are.
#[cfg(feature = "parallel")]
fn for_each(chunks: &mut [Chunk], work: impl Fn(&mut Chunk) + Sync + Send) {
    if let [only] = chunks {
        work(only);
    } else {
        chunks.par_iter_mut().for_each(work);
    }
}

#[cfg(not(feature = "parallel"))]
fn for_each(chunks: &mut [Chunk], work: impl Fn(&mut Chunk)) {
    chunks.iter_mut().for_each(work);
}

/// The same with `length` numbers for each chunk.
#[cfg(feature = "parallel")]
fn for_each_with(
    chunks: &mut [Chunk],
    numbers: &mut [f64],
    length: usize,
    work: impl Fn(&mut Chunk, &mut [f64]) + Sync + Send,
) {
    match chunks {
        [only] => work(only, numbers),
        _ if length == 0 => chunks.par_iter_mut().for_each(|chunk| work(chunk, &mut [])),
        _ => chunks
            .par_iter_mut()
            .zip(numbers.par_chunks_mut(length))
            .for_each(|(chunk, numbers)| work(chunk, numbers)),
    }
}

#[cfg(not(feature = "parallel"))]
fn for_each_with(
    chunks: &mut [Chunk],
    numbers: &mut [f64],
    length: usize,
    work: impl Fn(&mut Chunk, &mut [f64]),
) {
    let mut numbers = numbers.chunks_mut(length.max(1));
    for chunk in chunks {
        work(chunk, numbers.next().unwrap_or_default());
    }
}
