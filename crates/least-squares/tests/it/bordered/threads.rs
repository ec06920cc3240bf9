//! One thread or many.

use least_squares::{BorderedOptions, solve_bordered};

use super::problems::{GAUGE, Poses, Ranging};

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (_, ranging, start) = Ranging::simulate(6, 700, 1e-3, 1.0, 9);
    let (poses, pose_start) = Poses::simulate(5, 501, 1e-2, 9);
    let pose_options = BorderedOptions { held_blocks: vec![0], ..BorderedOptions::default() };
    let held = BorderedOptions { held_shared: GAUGE.to_vec(), ..BorderedOptions::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let first = solve_bordered(&ranging, start.clone(), &held).unwrap();
            let second = solve_bordered(&poses, pose_start.clone(), &pose_options).unwrap();
            let costs = [first.report.final_cost, second.report.final_cost];
            let points = [first.point, second.point];
            let numbers = points.iter().flat_map(|p| p.shared.iter().chain(&p.blocks));
            numbers.chain(&costs).map(|v| v.to_bits()).collect::<Vec<_>>()
        })
    };
    let one = on(1);
    for threads in [2, 3, 7] {
        assert!(on(threads) == one, "{threads} threads give other bits");
    }
}
