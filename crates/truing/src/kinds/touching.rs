//! `[plan]` of the kinds that touch a part, and the places of it that can be touched.

use nalgebra::{Point3, Unit, Vector3};
use serde::Deserialize;
use serde::de::{Deserializer, Error as _};

use super::offer::{Reach, undeclared};
use crate::case::{Finite, Positive};

/// `[plan]`: what the machine can do; lengths in the coordinates of the part.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlanSettings {
    x_mm: Option<Range>,
    y_mm: Option<Range>,
    z_mm: Option<Range>,
    spacing_mm: Option<Positive>,
    keep_out: Option<Vec<Circle>>,
    feeds_mm_per_min: Option<Vec<Positive>>,
    measured_feed_mm_per_min: Option<Positive>,
    oblique_deg: Option<Oblique>,
    spindle_deg: Option<Vec<Finite>>,
    safe_z_mm: Option<Finite>,
    approach_mm: Option<Positive>,
    overtravel_mm: Option<Positive>,
    travel_mm_per_min: Option<Positive>,
    minutes_per_measurement: Option<Positive>,
}

/// From low to high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range(pub(crate) [f64; 2]);

/// x, y and radius of a circle of the xy plane that the contacts stay out of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Circle([f64; 3]);

/// Angle between approach and normal, below a right angle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Oblique(f64);

impl<'de> Deserialize<'de> for Range {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let [Finite(low), Finite(high)] = <[Finite; 2]>::deserialize(deserializer)?;
        if low < high {
            return Ok(Self([low, high]));
        }
        Err(D::Error::custom(format_args!(
            "expected a number and a larger one, [low, high], found [{low}, {high}]"
        )))
    }
}

impl<'de> Deserialize<'de> for Circle {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let circle = <[Finite; 3]>::deserialize(deserializer)?.map(|Finite(v)| v);
        if circle[2] > 0.0 {
            return Ok(Self(circle));
        }
        Err(D::Error::custom(format_args!(
            "expected a number above 0 for the radius of [x, y, radius], found {}",
            circle[2]
        )))
    }
}

impl<'de> Deserialize<'de> for Oblique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Finite(angle) = Finite::deserialize(deserializer)?;
        if (0.0..=STEEPEST_DEG).contains(&angle) {
            return Ok(Self(angle));
        }
        Err(D::Error::custom(format_args!(
            "expected a number from 0 to {STEEPEST_DEG}, the angle between approach and normal, \
             found {angle}"
        )))
    }
}

/// Beyond this an approach slides along the surface.
const STEEPEST_DEG: f64 = 70.0;
/// Angle between approach and normal where none is declared: far enough for what goes with the
/// direction to show at half its size, and no ball slides yet.
const OBLIQUE_DEG: f64 = 30.0;
/// Places across the part along its diagonal, where no spacing is declared.
pub(crate) const ACROSS: f64 = 12.0;
/// Most places of a lattice that are looked at: the nearest point of a mesh takes microseconds.
pub(crate) const MOST_PLACES: f64 = 20_000.0;
/// Least distance between two places over the spacing: feet of a lattice lie unevenly.
const THINNED: f64 = 0.7;
/// Feet this share of the diagonal beside the region still belong to it.
const SLACK: f64 = 0.01;
/// Beyond everything that was touched, where no safe height is declared.
const CLEARANCE_MM: f64 = 20.0;
/// Distance from which a touch begins, and beyond which the surface is not: a part is placed, and
/// its size known, to better than that.
const APPROACH_MM: f64 = 2.0;
/// Feed of a touch where none is recorded or declared.
const FEED_MM_PER_MIN: f64 = 100.0;
/// Between touches, where nothing is declared; a tenth of what a slow machine has.
const TRAVEL_MM_PER_MIN: f64 = 1000.0;

/// A place of the part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) contact_mm: Point3<f64>,
    /// Towards the ball.
    pub(crate) normal: Unit<Vector3<f64>>,
}

impl PlanSettings {
    /// A region and nothing else.
    pub(crate) fn of_region(ranges: [Option<Range>; 3], spacing_mm: Option<Positive>) -> Self {
        let [x_mm, y_mm, z_mm] = ranges;
        Self { x_mm, y_mm, z_mm, spacing_mm, ..Self::default() }
    }

    /// Keys of the region that are not declared and would offer more.
    pub(crate) fn undeclared(&self) -> Vec<&'static str> {
        undeclared(&[("x_mm", self.x_mm.is_some()), ("y_mm", self.y_mm.is_some())])
    }

    pub(crate) fn minutes(&self) -> Option<f64> {
        self.minutes_per_measurement.map(|Positive(minutes)| minutes)
    }

    /// Angle between approach and normal of oblique touches; `None` where there are none.
    pub(crate) fn oblique_rad(&self) -> Option<f64> {
        let Oblique(angle) = self.oblique_deg.unwrap_or(Oblique(OBLIQUE_DEG));
        Some(angle.to_radians()).filter(|a| *a > 0.0)
    }

    /// What is said of keys that mean nothing to a kind that knows no approaches.
    pub(crate) fn of_probing_alone(&self) -> Vec<String> {
        let keys = [
            ("oblique_deg", self.oblique_deg.is_some()),
            ("spindle_deg", self.spindle_deg.is_some()),
            ("measured_feed_mm_per_min", self.measured_feed_mm_per_min.is_some()),
        ];
        let unused = keys.into_iter().filter(|(_, is_given)| *is_given);
        unused
            .map(|(key, _)| format!("`[plan] {key}` is not used by a case of this kind"))
            .collect()
    }

    /// Feeds declared.
    pub(crate) fn feeds(&self) -> Option<Vec<f64>> {
        let feeds = self.feeds_mm_per_min.as_ref()?;
        Some(feeds.iter().map(|Positive(feed)| *feed).collect())
    }

    /// One feed for every touch.
    pub(crate) fn feed(&self) -> f64 {
        self.feeds().and_then(|feeds| feeds.first().copied()).unwrap_or(FEED_MM_PER_MIN)
    }

    /// Feed of the touches measured, where it is said here and not in the table.
    pub(crate) fn measured_feed(&self) -> Option<f64> {
        self.measured_feed_mm_per_min.map(|Positive(feed)| feed)
    }

    /// Turns of the spindle declared.
    pub(crate) fn spindle_deg(&self) -> Option<Vec<f64>> {
        let turns = self.spindle_deg.as_ref()?;
        Some(turns.iter().map(|Finite(turn)| *turn).collect())
    }

    /// How the machine goes from touch to touch; `highest_mm` is the highest ball of all.
    pub(crate) fn reach(&self, highest_mm: f64) -> Reach {
        let or = |value: Option<Positive>, default| value.map_or(default, |Positive(v)| v);
        let approach_mm = or(self.approach_mm, APPROACH_MM);
        let safe = highest_mm + CLEARANCE_MM;
        Reach {
            safe_z_mm: self.safe_z_mm.map_or(safe, |Finite(z)| z),
            approach_mm,
            overtravel_mm: or(self.overtravel_mm, approach_mm),
            travel_mm_per_min: or(self.travel_mm_per_min, TRAVEL_MM_PER_MIN),
        }
    }

    /// Places of the part in the declared region, or between the contacts that there are; `foot` is
    /// the point of the part next to one of space. Where no spacing is declared, `across` of them are
    /// along the diagonal. `None` where the spacing makes too many.
    pub(crate) fn places(
        &self,
        contacts: &[Point3<f64>],
        across: f64,
        foot: impl Fn(&Point3<f64>) -> Option<Place>,
    ) -> Option<Vec<Place>> {
        let [low, high] = self.region(contacts);
        let diagonal_mm = (high - low).norm();
        let spacing_mm = self.spacing_mm.map_or(diagonal_mm / across, |Positive(mm)| mm);
        let counts = (high - low).map(|length| (length / spacing_mm).ceil() + 1.0);
        if counts.product() > MOST_PLACES {
            return None;
        }
        let slack_mm = SLACK * diagonal_mm;
        let inside = |p: &Point3<f64>| {
            (0..3).all(|k| p[k] >= low[k] - slack_mm && p[k] <= high[k] + slack_mm)
        };
        let mut places: Vec<Place> = Vec::new();
        for point in lattice(&low, &high, &counts) {
            let Some(place) = foot(&point) else { continue };
            let far = |other: &Place| {
                (other.contact_mm - place.contact_mm).norm() >= THINNED * spacing_mm
            };
            let kept = inside(&place.contact_mm) && !self.is_kept_out(&place.contact_mm);
            if kept && places.iter().all(far) {
                places.push(place);
            }
        }
        Some(shuffled(&places))
    }

    fn is_kept_out(&self, at: &Point3<f64>) -> bool {
        let circles = self.keep_out.as_deref().unwrap_or_default();
        circles.iter().any(|Circle([x, y, r])| (at.x - x).hypot(at.y - y) < *r)
    }

    /// Opposite corners of the region.
    fn region(&self, contacts: &[Point3<f64>]) -> [Vector3<f64>; 2] {
        let (mut low, mut high) = (Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN));
        for contact in contacts {
            (low, high) = (low.inf(&contact.coords), high.sup(&contact.coords));
        }
        for (axis, range) in [self.x_mm, self.y_mm, self.z_mm].iter().enumerate() {
            if let Some(Range([from, to])) = range {
                (low[axis], high[axis]) = (*from, *to);
            }
        }
        [low, high]
    }
}

/// Points of a lattice of `counts` along each axis.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "counts are whole, positive, and their product is bounded before"
)]
fn lattice(
    low: &Vector3<f64>,
    high: &Vector3<f64>,
    counts: &Vector3<f64>,
) -> impl Iterator<Item = Point3<f64>> {
    let [nx, ny, nz] = [counts.x as usize, counts.y as usize, counts.z as usize];
    let (low, step) = (*low, (high - low).zip_map(counts, |length, n| length / (n - 1.0).max(1.0)));
    (0..nx * ny * nz).map(move |i| {
        let at = [i % nx, i / nx % ny, i / (nx * ny)].map(|n| n as f64);
        Point3::from(low + Vector3::from(at).component_mul(&step))
    })
}

/// The same in an order in which neighbours do not follow each other: every step goes on by the
/// golden section of all, made coprime to their number.
pub(crate) fn shuffled<T: Clone>(of: &[T]) -> Vec<T> {
    let n = of.len();
    let divisor = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    // 0.618 of n, in whole numbers.
    let start = n * 618 / 1000;
    let step = (start..start + n).find(|step| *step > 0 && divisor(*step, n) == 1).unwrap_or(1);
    (0..n).map(|i| of[i * step % n].clone()).collect()
}

#[cfg(test)]
mod tests {
    use super::{ACROSS, Place, PlanSettings, shuffled};
    use nalgebra::{Point3, Vector3};

    #[test]
    fn every_thing_is_in_the_shuffled_order_once() {
        for n in [0, 1, 2, 3, 10, 97, 618] {
            let mut order = shuffled(&(0..n).collect::<Vec<usize>>());
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..n), "{n}");
        }
    }

    #[test]
    fn places_keep_their_distance_and_stay_out_of_circles() {
        let plane = |p: &Point3<f64>| {
            let contact_mm = Point3::new(p.x, p.y, 0.0);
            Some(Place { contact_mm, normal: Vector3::z_axis() })
        };
        let settings: PlanSettings =
            toml::from_str("spacing_mm = 5.0\nkeep_out = [[0.0, 0.0, 6.0]]").unwrap();
        let corners = [Point3::new(-20.0, -20.0, 0.0), Point3::new(20.0, 20.0, 0.0)];
        let places = settings.places(&corners, ACROSS, plane).unwrap();
        // Nine by nine, less those nearer than 6 mm to the middle: itself and four.
        assert_eq!(places.len(), 81 - 5);
        for (i, a) in places.iter().enumerate() {
            assert!(a.contact_mm.coords.norm() >= 6.0);
            for b in &places[..i] {
                assert!((a.contact_mm - b.contact_mm).norm() > 3.4);
            }
        }
        let fine: PlanSettings = toml::from_str("spacing_mm = 1e-3").unwrap();
        assert_eq!(fine.places(&corners, ACROSS, plane), None);
    }
}
