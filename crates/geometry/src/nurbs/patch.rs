use nalgebra::{Matrix3, Point3, Vector3, Vector4};

use super::control_net::ControlNet;
use crate::Line;

/// Turn of a leaf along one direction, rad: flat enough for one foot and one hit at most, up to
/// where its curvature itself changes.
const MAX_TURN_RAD: f64 = 0.3;
/// Halvings of a span along one direction; a span that is still not flat then has a cusp.
const MAX_HALVINGS: u32 = 6;

/// A nearly flat piece of the surface within one span each way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Leaf {
    pub(super) domain: [[f64; 2]; 2],
    /// A box along its tangents and normal that holds all its control points, and so itself.
    center_mm: Point3<f64>,
    axes: Matrix3<f64>,
    half_mm: Vector3<f64>,
    /// Corners of a box along x, y and z.
    pub(super) low_mm: Vector3<f64>,
    pub(super) high_mm: Vector3<f64>,
}

impl Leaf {
    /// Cuts a piece of a span into leaves.
    pub(super) fn cut(
        net: &ControlNet,
        spans: [usize; 2],
        domain: [[f64; 2]; 2],
        halvings: [u32; 2],
        out: &mut Vec<Self>,
    ) {
        let piece = Net::of(net, spans, domain);
        let turns = [piece.turn(0), piece.turn(1)];
        let direction = usize::from(turns[1] > turns[0]);
        let splits = |d: usize| turns[d] > MAX_TURN_RAD && halvings[d] < MAX_HALVINGS;
        let Some(along) = [direction, 1 - direction].into_iter().find(|&d| splits(d)) else {
            out.push(piece.leaf(domain));
            return;
        };
        let [from, to] = domain[along];
        let middle = 0.5 * (from + to);
        let mut deeper = halvings;
        deeper[along] += 1;
        for half in [[from, middle], [middle, to]] {
            let mut part = domain;
            part[along] = half;
            Self::cut(net, spans, part, deeper, out);
        }
    }

    pub(super) fn middle(&self) -> [f64; 2] {
        self.domain.map(|[from, to]| 0.5 * (from + to))
    }

    /// Places within the leaf from which a search begins: a quarter in from each corner.
    pub(super) fn quarters(&self) -> [[f64; 2]; 4] {
        let at = |d: usize, share: f64| {
            let [from, to] = self.domain[d];
            from + share * (to - from)
        };
        [[0.25, 0.25], [0.75, 0.25], [0.25, 0.75], [0.75, 0.75]]
            .map(|share| [at(0, share[0]), at(1, share[1])])
    }

    /// Whether the leaf holds a place, up to round-off.
    pub(super) fn holds(&self, at: [f64; 2]) -> bool {
        const ROUNDING: f64 = 1e-9;
        (0..2).all(|d| {
            let [from, to] = self.domain[d];
            let slack = ROUNDING * (to - from);
            (from - slack..=to + slack).contains(&at[d])
        })
    }

    /// Distance from the box: no point of the leaf is nearer.
    pub(super) fn distance_mm(&self, query_mm: &Point3<f64>) -> f64 {
        let local = self.axes.tr_mul(&(query_mm - self.center_mm));
        (local.abs() - self.half_mm).map(|beside| beside.max(0.0)).norm()
    }

    /// Whether a line goes through the box.
    pub(super) fn is_met(&self, line: &Line) -> bool {
        let from = self.axes.tr_mul(&(line.point_mm - self.center_mm));
        let along = self.axes.tr_mul(&line.direction.into_inner());
        meets_box(&from, &along, &self.half_mm)
    }
}

/// Whether an endless line meets a box about the origin.
pub(super) fn meets_box(from: &Vector3<f64>, along: &Vector3<f64>, half: &Vector3<f64>) -> bool {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..3 {
        if along[k] == 0.0 {
            if from[k].abs() > half[k] {
                return false;
            }
            continue;
        }
        let ends = [(-half[k] - from[k]) / along[k], (half[k] - from[k]) / along[k]];
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    enter <= leave
}

/// Bézier points of a piece of one span each way, u running fastest.
struct Net {
    points_mm: Vec<Point3<f64>>,
    counts: [usize; 2],
}

impl Net {
    fn of(net: &ControlNet, spans: [usize; 2], domain: [[f64; 2]; 2]) -> Self {
        let [u, v] = [0, 1].map(|d| net.knots[d].bezier(spans[d], domain[d]));
        let counts = [u.nrows(), v.nrows()];
        // Along u first, for every control point along v.
        let mut along_u = Vec::with_capacity(counts[0] * counts[1]);
        for b in 0..counts[1] {
            for i in 0..counts[0] {
                let terms = (0..counts[0]).map(|a| net.control(spans, a, b) * u[(i, a)]);
                along_u.push(terms.sum::<Vector4<f64>>());
            }
        }
        let mut points_mm = Vec::with_capacity(counts[0] * counts[1]);
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let terms = (0..counts[1]).map(|b| along_u[i + b * counts[0]] * v[(j, b)]);
                let sum: Vector4<f64> = terms.sum();
                points_mm.push(Point3::from(sum.xyz() / sum.w));
            }
        }
        Self { points_mm, counts }
    }

    fn at(&self, direction: usize, along: usize, across: usize) -> &Point3<f64> {
        let [i, j] = if direction == 0 { [along, across] } else { [across, along] };
        &self.points_mm[i + j * self.counts[0]]
    }

    /// By how much the tangents along a direction may turn, rad: second over first differences.
    fn turn(&self, direction: usize) -> f64 {
        let [along, across] = [self.counts[direction], self.counts[1 - direction]];
        let (mut step, mut bend) = (0.0_f64, 0.0_f64);
        for j in 0..across {
            for i in 1..along {
                let now = self.at(direction, i, j) - self.at(direction, i - 1, j);
                step = step.max(now.norm());
                if i + 1 < along {
                    let next = self.at(direction, i + 1, j) - self.at(direction, i, j);
                    bend = bend.max((next - now).norm());
                }
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "degrees are at most 15")]
        let steps = (along - 2) as f64;
        if step > 0.0 { steps.max(0.0) * bend / step } else { 0.0 }
    }

    fn leaf(&self, domain: [[f64; 2]; 2]) -> Leaf {
        let last = [self.counts[0] - 1, self.counts[1] - 1];
        let corner = |i: usize, j: usize| self.points_mm[i + j * self.counts[0]].coords;
        let along = [
            corner(last[0], 0) - corner(0, 0) + corner(last[0], last[1]) - corner(0, last[1]),
            corner(0, last[1]) - corner(0, 0) + corner(last[0], last[1]) - corner(last[0], 0),
        ];
        let axes = axes(along);
        let local: Vec<Vector3<f64>> =
            self.points_mm.iter().map(|p| axes.tr_mul(&p.coords)).collect();
        let (low, high) = bounds(local.iter());
        let (low_mm, high_mm) = bounds(self.points_mm.iter().map(|p| &p.coords));
        let center_mm = Point3::from(axes * ((low + high) * 0.5));
        // What round-off may put beside the box.
        let slack = Vector3::repeat(1e-14 * (1.0 + center_mm.coords.amax()));
        Leaf { domain, center_mm, axes, half_mm: (high - low) * 0.5 + slack, low_mm, high_mm }
    }
}

/// Orthonormal axes along two tangents; any where they give no plane.
fn axes([first, second]: [Vector3<f64>; 2]) -> Matrix3<f64> {
    let normal = first.cross(&second).try_normalize(f64::MIN_POSITIVE);
    let tangent = first.try_normalize(f64::MIN_POSITIVE);
    match (tangent, normal) {
        (Some(tangent), Some(normal)) => {
            Matrix3::from_columns(&[tangent, normal.cross(&tangent), normal])
        }
        _ => Matrix3::identity(),
    }
}

pub(super) fn bounds<'a>(
    points: impl Iterator<Item = &'a Vector3<f64>>,
) -> (Vector3<f64>, Vector3<f64>) {
    let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    points.fold(none, |(low, high), p| (low.inf(p), high.sup(p)))
}
