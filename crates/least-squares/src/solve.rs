use crate::covariance::{Factored, report};
use crate::search::{Counts, Ended, Found, Style, search};
use crate::valley;
use crate::{Options, Problem, Report, Solution, SolveError};

/// The second search: long curved steps on a scale that forgets a start far off.
///
/// Chosen for what the first search leaves unsolved; over the certified problems the outcome is
/// the same for a damping of 1e-8 to 1e-4 and a memory of 0.3 to 0.7.
const BOLD: Style =
    Style { initial_damping: 1e-6, relief: 1.0 / 3.0, scale_memory: 0.5, accelerate: true };
/// Relative difference below which two costs are the same minimum.
const SAME_COST: f64 = 1e-9;
/// Share of the start's cost that is rounding: nothing below it is worth another search.
const EXACT_FIT: f64 = 1e-30;

/// Finds the point that minimises `½ Σ ρ(‖rᵢ‖²)`, starting from `start`.
///
/// Ok means converged and of full rank. A first search takes scaled Levenberg-Marquardt steps.
/// Where it ends without a usable answer, and [`Options::retry`] is set, a second one starts
/// over with geodesic acceleration, and if a direction is still free, more start across the
/// valley along it. The lowest cost wins.
///
/// # Errors
///
/// See [`SolveError`]: every variant means that there is no estimate to rely on.
/// [`SolveError::NotConverged`], [`SolveError::Stalled`] and [`SolveError::Unobservable`] carry
/// the best point found.
pub fn solve<P: Problem>(
    problem: &P,
    start: P::Point,
    options: &Options,
) -> Result<Solution<P::Point>, SolveError<P::Point>> {
    if !problem.is_point(&start) {
        return Err(SolveError::InvalidStart);
    }
    let mut counts = Counts::default();
    let first = search(problem, start.clone(), options, plain(options), &mut counts)?;
    let initial_cost = first.initial_cost;
    let mut best = Candidate::new(first, options);
    let settled = |best: &Candidate<P::Point>| {
        !options.retry || best.is_usable() || best.is_exact(initial_cost)
    };
    if !settled(&best) {
        let second = search(problem, start, options, BOLD, &mut counts)?;
        best = best.or(Candidate::new(second, options));
    }
    let weak = best.factored.as_ref().filter(|_| !settled(&best));
    if let Some(factored) = weak {
        for across in valley::starts(problem, options, &best.found, factored, &mut counts) {
            if let Ok(found) = search(problem, across, options, plain(options), &mut counts) {
                best = best.or(Candidate::new(found, options));
            }
            if settled(&best) {
                break;
            }
        }
    }
    best.conclude(problem, counts, initial_cost)
}

/// The first search.
fn plain(options: &Options) -> Style {
    let damping = options.initial_damping;
    let valid = damping.is_finite() && damping > 0.0;
    let initial_damping = if valid { damping } else { Options::default().initial_damping };
    Style { initial_damping, relief: 0.1, scale_memory: 1.0, accelerate: false }
}

/// The end of a search and what its Jacobian determines.
struct Candidate<Point> {
    found: Found<Point>,
    /// `None` where the Jacobian is not finite.
    factored: Option<Factored>,
}

impl<Point: Clone> Candidate<Point> {
    fn new(found: Found<Point>, options: &Options) -> Self {
        let finite = !matches!(found.ended, Ended::NonFinite(_));
        let factored = finite.then(|| Factored::new(&found.at, options.rank_tolerance));
        Self { found, factored }
    }

    fn cost(&self) -> f64 {
        self.found.at.evaluated.cost
    }

    fn is_usable(&self) -> bool {
        let full_rank = self.factored.as_ref().is_some_and(Factored::is_full_rank);
        full_rank && matches!(self.found.ended, Ended::Converged(_))
    }

    /// Whether the fit leaves nothing but rounding, below the data's uncertainty.
    fn is_exact(&self, initial_cost: f64) -> bool {
        self.cost() <= EXACT_FIT * initial_cost && self.found.at.evaluated.residuals.amax() < 1.0
    }

    /// The lower of two costs; of two equal ones, the one to rely on.
    fn or(self, other: Self) -> Self {
        let same = (self.cost() - other.cost()).abs() <= SAME_COST * self.cost();
        let prefer_other =
            if same { other.is_usable() && !self.is_usable() } else { other.cost() < self.cost() };
        if prefer_other { other } else { self }
    }

    fn conclude<P: Problem<Point = Point>>(
        self,
        problem: &P,
        counts: Counts,
        initial_cost: f64,
    ) -> Result<Solution<Point>, SolveError<Point>> {
        let Self { found: Found { point, at, ended, .. }, factored } = self;
        let termination = match ended {
            Ended::Converged(termination) => Some(termination),
            Ended::NonFinite(non_finite) => return Err(non_finite.into()),
            Ended::Stalled | Ended::OutOfIterations => None,
        };
        let factored = factored.expect("a search that ends otherwise has a finite Jacobian");
        let report = Report { termination, ..report(&at, &factored, counts, initial_cost) };
        if !factored.is_full_rank() {
            let directions = factored.free_directions(problem, &at);
            let (best, report) = (Box::new(point), Box::new(report));
            return Err(SolveError::Unobservable { directions, best, report });
        }
        if termination.is_none() {
            let (best, report) = (Box::new(point), Box::new(report));
            return Err(match ended {
                Ended::Stalled => SolveError::Stalled { best, report },
                _ => SolveError::NotConverged { best, report },
            });
        }
        Ok(Solution {
            point,
            covariance: factored.covariance(&at),
            degrees_of_freedom: at.degrees_of_freedom(),
            variance_factor: at.variance_factor(),
            residuals: at.evaluated.residuals,
            weights: at.evaluated.root_weights.map(|w| w * w),
            report,
        })
    }
}
