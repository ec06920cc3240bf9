//! The real-time path never touches the allocator, in any state.
#![expect(unsafe_code, reason = "a counting allocator is the way to see allocations")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use force_impedance::{ControllerSettings, ReferenceMode};

use crate::rig::{Rig, SOFT};

struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's contract is the system's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's contract is the system's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn count(run: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    run();
    ALLOCATIONS.with(Cell::get) - before
}

#[test]
fn the_trap_works() {
    assert!(count(|| drop(std::hint::black_box(vec![1.0; 8]))) >= 2);
}

#[test]
fn nothing_is_allocated_from_construction_on() {
    let mut rig = Rig::new(SOFT, ControllerSettings::default());
    let mut inputs = Vec::new();
    for i in 0..400 {
        let mut seen = rig.read();
        match i % 50 {
            17 => seen.cells_n = None,
            23 => seen.lengths_mm = Some([f64::NAN; 4]),
            29 => seen.reference_n = f64::INFINITY,
            31 => seen.normal *= 2.0,
            37 => seen.lengths_mm = Some([1e6; 4]),
            _ => {}
        }
        inputs.push(seen);
        rig.cycle();
    }
    let allocations = count(|| {
        for seen in &inputs {
            std::hint::black_box(rig.controller.update(seen, 1e-3));
        }
        let other = rig.controller.prepare(SOFT).unwrap();
        rig.controller.adopt(other).unwrap();
        rig.controller.set_mode(ReferenceMode::Absolute);
        let head = *rig.controller.head();
        let pose = head.pose_of_lengths(&[70.1, 69.9, 70.0, 181.0]).unwrap().pose;
        std::hint::black_box(head.balance(&pose).preload_n(&[1.0; 4]));
    });
    assert_eq!(allocations, 0);
}
