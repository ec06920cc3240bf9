//! Prints how the solver does on NIST StRD and Moré-Garbow-Hillstrom.

#[path = "../tests/it/suites/mod.rs"]
mod suites;

use least_squares::{Options, Report, Solution, SolveError, solve};
use nalgebra::DVector;
use suites::{mgh, nist};

fn outcome(r: Result<Solution<DVector<f64>>, SolveError>) -> (DVector<f64>, Report, String) {
    match r {
        Ok(s) => {
            let t = match s.report.termination {
                Some(t) => format!("{t:?}"),
                None => "-".into(),
            };
            let t = format!("{t} {}", s.report.searches);
            (s.point, s.report, t)
        }
        Err(SolveError::NotConverged { best, report }) => {
            let t = format!("NotConverged {}", report.searches);
            (*best, *report, t)
        }
        Err(SolveError::Stalled { best, report }) => {
            let t = format!("Stalled {}", report.searches);
            (*best, *report, t)
        }
        Err(SolveError::Unobservable { best, report, .. }) => {
            let t = format!("Unobservable {}", report.searches);
            (*best, *report, t)
        }
        Err(e) => panic!("{e}"),
    }
}

fn main() {
    let options = Options::default();
    let (mut mean, mut six, mut evals) = (0.0, 0, 0);
    for (name, model) in nist::MODELS {
        let p = nist::Nist::read(name, model);
        for (i, start) in p.starts.iter().enumerate() {
            let (x, r, t) = outcome(solve(&p, start.clone(), &options));
            let lre = nist::log_relative_error(&x, &p.certified);
            mean += lre / 54.0;
            six += usize::from(lre >= 6.0);
            evals += r.residual_evaluations;
            println!(
                "{name:10} {} {lre:5.1} f{:5} J{:5} grad {:8.1e} cond {:8.1e} {t}",
                i + 1,
                r.residual_evaluations,
                r.jacobian_evaluations,
                r.gradient,
                r.condition
            );
        }
    }
    println!("StRD {six}/54 mean {mean:.3} evals {evals}");
    let (mut solved, mut evals) = (0, 0);
    for p in &mgh::PROBLEMS {
        for scale in [1.0, 10.0, 100.0] {
            let (_x, r, t) = outcome(solve(p, p.start(scale), &options).or_else(|e| {
                if let SolveError::NonFiniteResidual { .. } = e {
                    solve(
                        p,
                        p.start(1.0),
                        &Options { max_iterations: 0, retry: false, ..Options::default() },
                    )
                } else {
                    Err(e)
                }
            }));
            let ok = p.solved(2.0 * r.final_cost);
            solved += usize::from(ok);
            evals += r.residual_evaluations;
            println!(
                "{:20} {scale:5} {:3} f {:12.5e} opt {:12.5e} f{:5} J{:5} grad {:8.1e} cond {:8.1e} {t}",
                p.name,
                if ok { "yes" } else { "NO" },
                2.0 * r.final_cost,
                p.optimum,
                r.residual_evaluations,
                r.jacobian_evaluations,
                r.gradient,
                r.condition
            );
        }
    }
    println!("MGH {solved}/57 evals {evals}");
}
