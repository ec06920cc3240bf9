//! The two passes over all blocks, in chunks that do not depend on the number of threads.
//!
//! A few chunks are worked on at a time, and handed on before the next: what there is room for grows
//! with the number of threads, not with that of the chunks.

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
/// Chunks at a time for each of several threads, which wait for each other after them.
const CHUNKS_PER_THREAD: usize = 4;

/// Chunks that are worked on at a time.
fn at_a_time() -> usize {
    #[cfg(feature = "parallel")]
    let threads = rayon::current_num_threads();
    #[cfg(not(feature = "parallel"))]
    let threads = 1;
    if threads > 1 { CHUNKS_PER_THREAD * threads } else { 1 }
}

/// Blocks in a chunk, but for the last.
pub(super) fn chunk_length(program: &Program) -> usize {
    let width = program.first.len() * PANEL;
    let most = (MAX_NUMBERS / width.pow(2)).clamp(1, MAX_CHUNKS);
    let length = program.block_count.div_ceil(most).next_multiple_of(LANES);
    length.max(MIN_BLOCKS)
}

/// Room for the chunks that are worked on at a time, and the sums of all.
pub(super) struct Room {
    /// Blocks in a chunk, but for the last.
    length: usize,
    slots: Vec<Slot>,
    pub(super) sums: Sums,
}

/// Room for one chunk.
struct Slot {
    scratch: Scratch,
    steps: Steps,
    sums: Sums,
}

impl Room {
    pub(super) fn new(program: &Program) -> Self {
        let length = chunk_length(program);
        let count = program.block_count.div_ceil(length).clamp(1, at_a_time());
        let slot = |_| Slot {
            scratch: Scratch::new(program),
            steps: Steps::new(program),
            sums: Sums::new(program),
        };
        Self { length, slots: (0..count).map(slot).collect(), sums: Sums::new(program) }
    }
}

/// What does not change during a search.
pub(super) struct Setting<'a, P> {
    pub(super) problem: &'a P,
    pub(super) program: &'a Program,
    pub(super) robust: &'a [RobustRows],
}

impl<P: BorderedProblem> Setting<'_, P> {
    /// Linearises all blocks and eliminates them; the room then holds the sums of all.
    pub(super) fn eliminate(&self, room: &mut Room, point: &BorderedPoint, damping: f64) {
        let Self { problem, program, robust } = *self;
        let place = Place { problem, program, robust, point };
        let Room { length, slots, sums } = room;
        let (length, count) = (*length, program.block_count);
        sums.clear();
        for first in (0..count).step_by(length * slots.len()) {
            let starts = (first..count).step_by(length);
            let chunks = starts.map(|start| start..(start + length).min(count));
            let chunks: Vec<_> = slots.iter_mut().zip(chunks).collect();
            let done = each(chunks, |(slot, blocks)| {
                let Slot { scratch, sums, .. } = slot;
                dispatch(Eliminate { place, blocks, damping, scratch, sums: &mut *sums });
                &*sums
            });
            for chunk in done {
                sums.add(chunk);
            }
        }
    }

    /// Moves all blocks along with the shared point, which `moved` already holds.
    pub(super) fn step(
        &self,
        room: &mut Room,
        point: &BorderedPoint,
        step: &[f64],
        damping: f64,
        moved: &mut BorderedPoint,
    ) -> Gain {
        let Self { problem, program, robust } = *self;
        let block_len = point.block_len(program.block_count);
        let Room { length, slots, .. } = room;
        let (length, count) = (*length, program.block_count);
        let BorderedPoint { shared, blocks: moved } = moved;
        let (shared, mut moved) = (&*shared, &mut moved[..]);
        let place = Place { problem, program, robust, point };
        let mut total = Gain::default();
        for first in (0..count).step_by(length * slots.len()) {
            let starts = (first..count).step_by(length);
            let chunks = starts.map(|start| {
                let blocks = start..(start + length).min(count);
                let own = moved
                    .split_off_mut(..blocks.len() * block_len)
                    .expect("numbers of every block");
                (blocks, own)
            });
            let chunks: Vec<_> = slots.iter_mut().zip(chunks).collect();
            let done = each(chunks, |(Slot { scratch, steps, .. }, (blocks, moved))| {
                dispatch(Try { place, damping, step, shared, blocks, moved, scratch, steps })
            });
            for gain in done {
                total.add(gain);
            }
        }
        total
    }
}

/// Hands `take` in turn what `work` makes of ranges that together are `0..count`, on as many threads as
/// there are.
pub(super) fn map_chunks<T: Send>(
    count: usize,
    work: impl Fn(Range<usize>) -> T + Sync + Send,
    take: impl FnMut(T),
) {
    let length = count.div_ceil(MAX_CHUNKS).max(MIN_BLOCKS);
    let starts: Vec<usize> = (0..count).step_by(length).collect();
    let chunk = |start: usize| work(start..(start + length).min(count));
    starts.chunks(at_a_time()).flat_map(|some| each(some.to_vec(), chunk)).for_each(take);
}

/// What `work` makes of each, on as many threads as there are.
#[cfg(feature = "parallel")]
fn each<A: Send, T: Send>(all: Vec<A>, work: impl Fn(A) -> T + Sync + Send) -> Vec<T> {
    if all.len() > 1 {
        all.into_par_iter().map(work).collect()
    } else {
        all.into_iter().map(work).collect()
    }
}

#[cfg(not(feature = "parallel"))]
fn each<A, T>(all: Vec<A>, work: impl Fn(A) -> T) -> Vec<T> {
    all.into_iter().map(work).collect()
}
