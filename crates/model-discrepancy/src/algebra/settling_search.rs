//! The course to rest that a drift takes, found by looking for its time constant.

use nalgebra::{DMatrix, DVector};

use crate::algebra::drifts::Drifts;
use crate::algebra::looked_through::FALSE_ALARM;
use crate::algebra::settling::{APART, LEAST, Rest, Settling, Slower, by_constant, three_digits};
use crate::count::count;

/// Time constants that are tried, as shares of the series: from a few readings to a quarter of it,
/// beyond which the course is a straight line with a bend, and a drift is called so.
const SHARES: [f64; 6] = [0.03, 0.05, 0.08, 0.12, 0.18, 0.27];

/// Longer ones of a slower course beside a fast one.
const SLOWER: [f64; 3] = [0.4, 0.6, 1.0];

/// Share of what the time constant does to the readings that their course must leave, squared: where
/// the readings lie at two levels alone, every course is the same, and rounding leaves 1e-30.
const SHOWN: f64 = 1e-9;

/// Steps of the time constant once one is found, either way.
const REFINED: [f64; 5] = [1.2, 1.1, 1.05, 1.02, 1.01];

/// Standard uncertainties that the amplitude of two courses that go opposite ways is off zero, all numbers free.
const SIZED: f64 = 4.0;

/// Rounds in which the numbers of two courses are moved together, parts of a step that are tried, and by which share more
/// is to be taken to go on.
const ROUNDS: usize = 30;
const HALVED: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];
const MORE: f64 = 1e-9;

/// The time constant with which a drift takes most of the residual, and a second one where the first
/// leaves what that takes, which goes the same way or, where it may, the other; `None` where white noise might show one as
/// clear.
pub(crate) fn settling_of(
    drifts: &Drifts<'_>,
    rest: Rest,
    (false_alarm, may_go_both_ways): (f64, bool),
) -> Option<Settling> {
    let span = drifts.span();
    let tried = |share: f64| drifts.explained(Settling::of(rest, share * span, SHARES.len()));
    let all = SHARES.iter().filter_map(|share| tried(*share));
    let best = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let moved =
        |s: &Settling, factor: f64| Settling::of(rest, s.time_constant * factor, s.searched);
    let (most, best) = drifts.refined(best, &[&moved]);
    if !drifts.shows_constant(&best) {
        return None;
    }
    let columns = drifts.even.ncols();
    let is_clear = drifts.residual.p_value(most, columns) * count(SHARES.len()) <= false_alarm;
    // Two that go opposite ways may leave nothing for one.
    let beside = is_clear.then_some(most);
    let two = drifts.with_slower(rest, span, (beside, may_go_both_ways));
    two.or_else(|| {
        let leaves_another = is_clear && drifts.shows_another(&best, span, most);
        is_clear.then_some(Settling { leaves_another, ..best })
    })
}

/// One of the numbers of a course moved by a factor.
type Moved<'m> = &'m dyn Fn(&Settling, f64) -> Settling;

impl Drifts<'_> {
    /// What the fitted parameters leave of the drift along a course.
    fn left_of(&self, settling: &Settling) -> DMatrix<f64> {
        self.left_along(|t| settling.come(t))
    }

    /// Whether another time constant is anything else than another amplitude.
    fn shows_constant(&self, best: &Settling) -> bool {
        let left = self.left_of(best);
        let Some(amplitudes) = self.residual.amplitudes(&left) else { return false };
        let way = self.left_along(|t| by_constant(t, best.time_constant)) * amplitudes;
        let Some(inverse) = left.tr_mul(&left).cholesky() else { return false };
        let taken = &left * inverse.solve(&left.tr_mul(&way));
        (&way - taken).norm_squared() > SHOWN * way.norm_squared()
    }

    fn explained(&self, settling: Settling) -> Option<(f64, Settling)> {
        Some((self.residual.explained(&self.left_of(&settling))?, settling))
    }

    /// The one of two that takes more; of one constant and of two only where the two take clearly more.
    pub(crate) fn likelier(&self, one: Settling, other: Settling) -> Settling {
        let explained =
            |settling: &Settling| self.residual.explained(&self.left_of(settling)).unwrap_or(0.0);
        let (few, many) = if one.slower.is_some() && other.slower.is_none() {
            (other, one)
        } else {
            (one, other)
        };
        let [of_few, of_many] = [&few, &many].map(explained);
        let is_likelier = if few.slower.is_some() == many.slower.is_some() {
            of_many > of_few
        } else {
            self.takes_clearly_more([of_few, of_many], many.searched)
        };
        if is_likelier { many } else { few }
    }

    /// Whether what two courses take, of so many that were tried, is clearly more than what one does: a second time constant
    /// and a share.
    fn takes_clearly_more(&self, [one, two]: [f64; 2], searched: usize) -> bool {
        self.residual.p_value_of_more(two - one, 2, two) * count(searched) <= FALSE_ALARM
    }

    /// Whether it is more than noise does where there is not one.
    fn takes_clearly(&self, two: f64, searched: usize) -> bool {
        let numbers = self.even.ncols() + 3;
        self.residual.p_value(two, numbers) * count(searched) <= FALSE_ALARM
    }

    fn refined(&self, best: (f64, Settling), ways: &[Moved<'_>]) -> (f64, Settling) {
        let mut best = best;
        for step in REFINED {
            for (way, factor) in ways.iter().flat_map(|way| [(way, 1.0 / step), (way, step)]) {
                let moved = self.explained(way(&best.1, factor));
                if let Some(more) = moved.filter(|(more, _)| *more > best.0) {
                    best = more;
                }
            }
        }
        best
    }

    /// Two courses with all of their numbers moved together, which one by one come to a stop short of the best: Gauss and
    /// Newton's steps, halved where they lead too far.
    fn polished(&self, refined: (f64, Settling)) -> (f64, Settling) {
        let mut best = refined;
        for _ in 0..ROUNDS {
            let Some(step) = self.step(&best.1) else { break };
            let nearer = |part: &f64| {
                let moved = best.1.moved(step.map(|number| number * part))?;
                self.explained(moved).filter(|(explained, _)| *explained > best.0 * (1.0 + MORE))
            };
            let Some(better) = HALVED.iter().find_map(nearer) else { break };
            best = better;
        }
        let rounded = self.explained(best.1.rounded());
        rounded.filter(|(explained, _)| *explained >= refined.0).unwrap_or(refined)
    }

    /// What the residual adds to the three numbers of two courses, beside their amplitudes.
    fn step(&self, settling: &Settling) -> Option<[f64; 3]> {
        let (all, _) = self.with_numbers(settling)?;
        let step = self.residual.amplitudes(&all)?;
        Some(std::array::from_fn(|number| step[all.ncols() - 3 + number]))
    }

    /// What the fitted parameters leave of two courses, and of a unit of each of their three numbers; and the amplitudes.
    fn with_numbers(&self, settling: &Settling) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let left = self.left_of(settling);
        let amplitudes = self.residual.amplitudes(&left)?;
        let columns = left.ncols();
        let mut all = left.insert_columns(columns, 3, 0.0);
        for number in 0..3 {
            let way = self.left_along(|t| settling.by_constant(t)[number]) * &amplitudes;
            all.set_column(columns + number, &way);
        }
        Some((all, amplitudes))
    }

    /// Whether courses that go opposite ways have a size beside their other numbers: those that take most of each other
    /// are any hump, and as large as one likes.
    fn has_a_size(&self, two: &Settling, explained: f64) -> bool {
        if !two.goes_both_ways() {
            return true;
        }
        let sized = || {
            let (all, amplitudes) = self.with_numbers(two)?;
            let columns = amplitudes.len();
            let covariance = all.tr_mul(&all).cholesky()?.inverse();
            let own = covariance.view((0, 0), (columns, columns)).into_owned();
            let square = amplitudes.dot(&own.cholesky()?.solve(&amplitudes));
            let variance = self.residual.variance_beside(explained, all.ncols());
            Some(square >= SIZED * SIZED * count(columns) * variance)
        };
        sized().unwrap_or(false)
    }

    /// Two courses, where one leaves clearly more than they do, or where there is no one.
    fn with_slower(
        &self,
        rest: Rest,
        span: f64,
        (of_one, may_go_both_ways): (Option<f64>, bool),
    ) -> Option<Settling> {
        if of_one.is_none() && !may_go_both_ways {
            return None;
        }
        let slower: Vec<f64> = SHARES.iter().chain(&SLOWER).copied().collect();
        let pairs: Vec<(f64, f64)> = (SHARES.iter())
            .flat_map(|fast| slower.iter().map(move |slow| (*fast, *slow)))
            .filter(|(fast, slow)| *slow >= APART * fast)
            .collect();
        let searched = pairs.len();
        let of_pair = |&(fast, slow): &(f64, f64)| {
            let one = Settling::of(rest, fast * span, searched);
            let time_constant = three_digits(slow * span);
            let share = self.share(&one, &Settling::of(rest, time_constant, 1))?;
            let two = Slower { time_constant, share };
            // Of two that go the same way one shows, too.
            let may_be = if share < 0.0 { may_go_both_ways } else { of_one.is_some() };
            let may_be = may_be && two.is_apart(one.time_constant);
            may_be.then(|| self.explained(Settling { slower: Some(two), ..one })).flatten()
        };
        let all = pairs.iter().filter_map(of_pair);
        let best = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let faster = |s: &Settling, factor: f64| Settling {
            time_constant: three_digits(s.time_constant * factor),
            ..*s
        };
        let of_slower = |s: &Settling, change: &dyn Fn(Slower) -> Slower| Settling {
            slower: s.slower.map(change),
            ..*s
        };
        let later = |s: &Settling, factor: f64| {
            of_slower(s, &|two| Slower {
                time_constant: three_digits(two.time_constant * factor),
                ..two
            })
        };
        let more = |s: &Settling, factor: f64| {
            let within = |share: f64| share.abs().clamp(LEAST, 1.0 - LEAST).copysign(share);
            of_slower(s, &|two| Slower { share: within(three_digits(two.share * factor)), ..two })
        };
        let (explained, two) = self.polished(self.refined(best, &[&faster, &later, &more]));
        let is_clear = match of_one {
            Some(most) => self.takes_clearly_more([most, explained], searched),
            None => self.takes_clearly(explained, searched),
        };
        (is_clear && self.has_a_size(&two, explained)).then_some(two)
    }

    /// Whether another course, with amplitudes of its own, takes what white noise hardly ever shows
    /// beside one that takes `most`.
    fn shows_another(&self, one: &Settling, span: f64, most: f64) -> bool {
        let explained = |share: &f64| {
            let both = self.left_of_both(one, &Settling::of(one.rest, share * span, 1));
            self.residual.explained(&both)
        };
        let all = SHARES.iter().filter_map(explained).fold(most, f64::max);
        let p_value = self.residual.p_value_of_more(all - most, self.even.ncols(), all);
        p_value * count(SHARES.len()) <= FALSE_ALARM
    }

    fn left_of_both(&self, one: &Settling, other: &Settling) -> DMatrix<f64> {
        self.left_along_each(&[&|t| one.come(t), &|t| other.come(t)])
    }

    /// Share of the second of two courses in both, where both have a part in them.
    fn share(&self, one: &Settling, other: &Settling) -> Option<f64> {
        let columns = self.even.ncols();
        let both = self.left_of_both(one, other);
        let amplitudes = self.residual.amplitudes(&both)?;
        // In what each amplitude moves the readings: their units may differ.
        let moved: Vec<f64> = both.column_iter().skip(columns).map(|c| c.norm_squared()).collect();
        let all = || (0..columns).map(|k| (amplitudes[k], amplitudes[columns + k], moved[k]));
        let of = |part: fn(f64, f64) -> f64| all().map(|(a, b, m)| m * part(a, b)).sum::<f64>();
        let alike = of(|a, b| b * (a + b)) / of(|a, b| (a + b) * (a + b));
        let times = of(|a, b| a * b) / of(|a, _| a * a);
        let share = three_digits(if times < 0.0 { times / (1.0 - times) } else { alike });
        (LEAST..=1.0 - LEAST).contains(&share.abs()).then_some(share)
    }
}
