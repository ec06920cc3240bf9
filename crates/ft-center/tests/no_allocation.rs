//! The monitor does not allocate: counted by the allocator itself, in a binary of its own.
#![expect(unsafe_code, reason = "a global allocator cannot be written without; test only")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use ft_center::{CoupleAxis, Monitor, MonitorOptions, Platform, Sample};
use geometry::{Asphere, AsphereShape, Wrench};
use nalgebra::{Isometry3, Point3, Vector3};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is handed to the system allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's promise about `layout` is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn allocations(during: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    during();
    ALLOCATIONS.with(Cell::get) - before
}

/// Touching, lifting, missing the workpiece, and bad samples.
fn sample(i: u32) -> Sample {
    let angle = f64::from(i) * 0.1;
    let radius_mm = if i % 11 == 10 { 500.0 } else { 20.0 };
    let at = Point3::new(radius_mm * angle.cos(), radius_mm * angle.sin(), 120.0);
    let load_n = if i.is_multiple_of(17) { 0.5 } else { 40.0 };
    let mut wrench = Wrench::of_force(Vector3::new(2.0, -1.0, -load_n), &at);
    wrench.torque_nmm.z += if i.is_multiple_of(23) { f64::NAN } else { 150.0 };
    Sample { time_s: f64::from(i) * 1e-3, wrench }
}

#[test]
fn the_counter_counts() {
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(7)))), 1);
}

#[test]
fn updates_do_not_allocate() {
    let bowl = Asphere::new(AsphereShape::on_axis(480.0, -1.0, vec![1e-9], 100.0)).unwrap();
    let workpiece = Platform::Workpiece {
        surface: Box::new(bowl),
        workpiece_from_sensor: Isometry3::translation(0.0, 0.0, -120.0),
        couple_axis: CoupleAxis::Normal,
    };
    for platform in [Platform::Plane { z0_mm: 30.0 }, workpiece] {
        let mut monitor = Monitor::new(platform, MonitorOptions::default()).unwrap();
        let mut seen = [0usize; 5];
        let count = allocations(|| {
            for i in 0..10_000 {
                let reading = monitor.update(&sample(i));
                seen[reading.status as usize] += 1;
            }
        });
        assert_eq!(count, 0);
        assert!(seen[0] > 5000 && seen[2] > 500 && seen[4] > 400, "{seen:?}");
    }
}
