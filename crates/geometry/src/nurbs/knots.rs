use nalgebra::DMatrix;

use crate::GeometryError;
use crate::error::finite;

/// Highest degree along one direction.
pub(super) const MAX_DEGREE: usize = 15;
/// Weights of the control points that act at one place; those past the degree are zero.
pub(super) type Row = [f64; MAX_DEGREE + 1];

/// Degree and knots along one direction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Knots {
    pub(super) degree: usize,
    knots: Vec<f64>,
}

impl Knots {
    pub(super) fn new(
        degree: usize,
        knots: Vec<f64>,
        direction: &'static str,
    ) -> Result<Self, GeometryError> {
        if degree == 0 || degree > MAX_DEGREE {
            return Err(GeometryError::InvalidDegree { direction, degree, limit: MAX_DEGREE });
        }
        finite(&knots, "knot")?;
        let needed = 2 * (degree + 1);
        if knots.len() < needed {
            let got = knots.len();
            return Err(GeometryError::TooFewKnots { direction, got, needed });
        }
        if let Some(index) = knots.windows(2).position(|pair| pair[1] < pair[0]) {
            return Err(GeometryError::KnotsDecrease { direction, index: index + 1 });
        }
        let this = Self { degree, knots };
        let [first, last] = this.domain();
        // A knot that fills a whole degree inside tears the surface apart.
        let inside = 1..this.count();
        let torn = inside.clone().find(|&i| this.knots[i + degree] <= this.knots[i]);
        if torn.is_some() || last <= first {
            let index = torn.unwrap_or(degree);
            return Err(GeometryError::KnotRepeated { direction, index, degree });
        }
        Ok(this)
    }

    /// Control points along this direction.
    pub(super) fn count(&self) -> usize {
        self.knots.len() - self.degree - 1
    }

    /// Where the surface begins and ends.
    pub(super) fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.count()]]
    }

    /// Spans that are not empty: the index of the knot at their beginning, and both ends.
    pub(super) fn spans(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        (self.degree..self.count())
            .map(|span| (span, [self.knots[span], self.knots[span + 1]]))
            .filter(|(_, [from, to])| to > from)
    }

    /// The span that holds a place; the outermost one beyond the ends.
    pub(super) fn span(&self, at: f64) -> usize {
        let at = at.max(self.domain()[0]);
        let inside = &self.knots[self.degree + 1..=self.count()];
        let mut span = self.degree + inside.partition_point(|knot| *knot <= at);
        // At the end, and where a knot is repeated there, the last span that has a length.
        span = span.min(self.count() - 1);
        while span > self.degree && self.knots[span + 1] <= self.knots[span] {
            span -= 1;
        }
        span
    }

    /// Weights of the control points `span − degree …= span`, and their first and second
    /// derivatives; beyond the span, its polynomial goes on.
    pub(super) fn weights(&self, span: usize, at: f64) -> [Row; 3] {
        let mut lower = [[0.0; MAX_DEGREE + 1]; 2];
        let mut row = [0.0; MAX_DEGREE + 1];
        row[0] = 1.0;
        for degree in 1..=self.degree {
            lower = [lower[1], row];
            row = self.raised(span, degree, &row, at);
        }
        let first = self.derived(span, self.degree, &lower[1]);
        let second = if self.degree > 1 {
            let of_lower = self.derived(span, self.degree - 1, &lower[0]);
            self.derived(span, self.degree, &of_lower)
        } else {
            [0.0; MAX_DEGREE + 1]
        };
        [row, first, second]
    }

    /// Bézier points of the piece `from … to` of a span, one row each, as weights of the control
    /// points of the span.
    pub(super) fn bezier(&self, span: usize, [from, to]: [f64; 2]) -> DMatrix<f64> {
        let count = self.degree + 1;
        let mut all = DMatrix::zeros(count, count);
        for point in 0..count {
            // The polar form of the piece: as many arguments at its end as the point's number.
            let mut row = [0.0; MAX_DEGREE + 1];
            row[0] = 1.0;
            for degree in 1..count {
                row = self.raised(span, degree, &row, if degree > point { from } else { to });
            }
            for (k, weight) in row.iter().take(count).enumerate() {
                all[(point, k)] = *weight;
            }
        }
        all
    }

    /// One step of the recursion of Cox and de Boor, to `degree`.
    fn raised(&self, span: usize, degree: usize, below: &Row, at: f64) -> Row {
        let mut row = [0.0; MAX_DEGREE + 1];
        for k in 0..degree {
            // The function of the degree below that begins at this knot.
            let begin = span + 1 + k - degree;
            let (from, to) = (self.knots[begin], self.knots[begin + degree]);
            let share = below[k] / (to - from);
            row[k] += (to - at) * share;
            row[k + 1] += (at - from) * share;
        }
        row
    }

    /// Derivative of the functions of `degree`, from the values or derivatives of those below.
    fn derived(&self, span: usize, degree: usize, below: &Row) -> Row {
        let mut row = [0.0; MAX_DEGREE + 1];
        #[expect(clippy::cast_precision_loss, reason = "degrees are at most 15")]
        let factor = degree as f64;
        for k in 0..degree {
            let begin = span + 1 + k - degree;
            let slope = factor * below[k] / (self.knots[begin + degree] - self.knots[begin]);
            row[k] -= slope;
            row[k + 1] += slope;
        }
        row
    }
}
