//! The touched surface seen obliquely, for the residuals to stand on.

use geometry::Line;
use nalgebra::{Isometry3, Point2, Point3, Vector3};
use pose_icp::{Part, TipSide};
use truing_report::Facet;

/// How much of y goes to the right, and up.
const INTO_THE_PICTURE: [f64; 2] = [0.35, 0.45];
/// Height of the surface in the picture over its width.
const ENLARGED: f64 = 0.3;
/// Facets from the middle of a round part to its rim, and around it.
const RINGS: u8 = 8;
const SECTORS: u8 = 40;
/// Facets along a side of any other part.
const SIDE: u8 = 18;
/// Where the light comes from, machine frame: the left, the front and above.
const LIGHT: [f64; 3] = [-0.5, -0.35, 0.8];

/// A part in the machine, as it is drawn.
pub(super) struct Picture {
    /// Places of the touches.
    pub(super) at: Vec<[f64; 2]>,
    /// The part behind them, the farthest first.
    pub(super) facets: Vec<Facet>,
}

/// Draws a part that lies at `machine_from_part`, touched by balls about `centers_mm`.
pub(super) fn picture(
    part: &Part,
    side: TipSide,
    machine_from_part: &Isometry3<f64>,
    centers_mm: &[Point3<f64>],
) -> Picture {
    let contact = |center: &Point3<f64>| {
        let local = machine_from_part.inverse_transform_point(center);
        part.surface().closest_point(&local).map_or(local, |foot| foot.point_mm)
    };
    let contacts_mm: Vec<Point3<f64>> = centers_mm.iter().map(contact).collect();
    let drawn: Vec<Corners> = (net(part, &contacts_mm).into_iter())
        .filter_map(|places| {
            let corner =
                |place: Point2<f64>| on_surface(part, side, place).map(|at| machine_from_part * at);
            let [a, b, c, d] = places.map(corner);
            Some([a?, b?, c?, d?])
        })
        .collect();
    let touched: Vec<Point3<f64>> =
        contacts_mm.iter().map(|contact| machine_from_part * contact).collect();
    let view = View::of(drawn.iter().flatten().chain(&touched));
    let mut facets: Vec<(f64, Facet)> = drawn.iter().map(|corners| view.facet(corners)).collect();
    facets.sort_by(|a, b| b.0.total_cmp(&a.0));
    Picture {
        at: touched.iter().map(|point| view.seen(point)).collect(),
        facets: facets.into_iter().map(|(_, facet)| facet).collect(),
    }
}

type Corners = [Point3<f64>; 4];

/// Corners of the facets over the part's xy plane: the aperture, or what is touched.
fn net(part: &Part, contacts_mm: &[Point3<f64>]) -> Vec<[Point2<f64>; 4]> {
    if let Some(shape) = part.shape() {
        let (middle, rim_mm) = (shape.aperture_center_mm, 0.5 * shape.diameter_mm);
        let at = |ring: u8, sector: u8| {
            let angle = std::f64::consts::TAU * f64::from(sector) / f64::from(SECTORS);
            let radius_mm = rim_mm * f64::from(ring) / f64::from(RINGS);
            Point2::new(middle.x + radius_mm * angle.cos(), middle.y + radius_mm * angle.sin())
        };
        return cells(RINGS, SECTORS, at);
    }
    let range = |k: usize| {
        let of = contacts_mm.iter().map(|p| p[k]);
        of.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (x, y) = (range(0), range(1));
    let within =
        |(low, high): (f64, f64), i: u8| low + (high - low) * f64::from(i) / f64::from(SIDE);
    cells(SIDE, SIDE, |i, j| Point2::new(within(x, i), within(y, j)))
}

fn cells(n: u8, m: u8, at: impl Fn(u8, u8) -> Point2<f64>) -> Vec<[Point2<f64>; 4]> {
    let cell = |(i, j): (u8, u8)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
    (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).map(cell).collect()
}

/// Where the surface lies over a place; of several sheets the one that the ball can reach.
fn on_surface(part: &Part, side: TipSide, place: Point2<f64>) -> Option<Point3<f64>> {
    let upright = Line::new(Point3::new(place.x, place.y, 0.0), Vector3::z()).ok()?;
    let hits = part.surface().hits(&upright).ok()?;
    let hit = if side == TipSide::Above { hits.last() } else { hits.first() };
    hit.map(|hit| hit.point_mm)
}

/// From the front and above, z enlarged so that a shallow bowl shows.
struct View {
    low_mm: Point3<f64>,
    enlarged: f64,
}

impl View {
    fn of<'a>(points_mm: impl Iterator<Item = &'a Point3<f64>>) -> Self {
        let (mut low, mut high) = (Point3::from([f64::MAX; 3]), Point3::from([f64::MIN; 3]));
        for point in points_mm {
            low = low.inf(point);
            high = high.sup(point);
        }
        let extent = high - low;
        let enlarged = if extent.z > 0.0 {
            (ENLARGED * extent.x.max(extent.y) / extent.z).max(1.0)
        } else {
            1.0
        };
        Self { low_mm: low, enlarged }
    }

    fn seen(&self, point_mm: &Point3<f64>) -> [f64; 2] {
        let from_low = point_mm - self.low_mm;
        let (y, z) = (from_low.y, from_low.z * self.enlarged);
        [from_low.x + INTO_THE_PICTURE[0] * y, z + INTO_THE_PICTURE[1] * y]
    }

    /// A facet with how far into the picture it lies.
    fn facet(&self, corners: &Corners) -> (f64, Facet) {
        let diagonal = |from: usize, to: usize| {
            let along = corners[to] - corners[from];
            Vector3::new(along.x, along.y, self.enlarged * along.z)
        };
        let normal = diagonal(0, 2).cross(&diagonal(1, 3));
        let light = Vector3::from(LIGHT);
        let cos =
            (normal.dot(&light) / (normal.norm() * light.norm()).max(f64::MIN_POSITIVE)).abs();
        let depth = corners.iter().map(|c| c.y).sum::<f64>();
        (depth, Facet { corners: corners.map(|c| self.seen(&c)), shade: 1.0 - cos })
    }
}
