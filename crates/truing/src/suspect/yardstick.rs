/// What a misfit of a case is measured by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Yardstick {
    /// How far apart the things measured are, in the unit of the residual.
    pub(crate) spread: f64,
    /// What free parameters took up that are near zero on any sound machine, as a residual.
    pub(crate) taken_up: f64,
    /// Misfit over spread beyond which no physics of usual size explains it.
    pub(crate) gross: f64,
    /// Misfit over spread beyond which the tables do not belong together, whatever is wrong.
    pub(crate) unmatched: f64,
    /// The same even where physics takes it away: a model with an error of its own at every target
    /// fits anything.
    pub(crate) beyond_physics: f64,
}

impl Yardstick {
    /// Nothing is too much.
    pub(crate) const NONE: Self = Self {
        spread: f64::INFINITY,
        taken_up: 0.0,
        gross: f64::INFINITY,
        unmatched: f64::INFINITY,
        beyond_physics: f64::INFINITY,
    };
}

/// Spread over the distance from the origin below which places are one, and no yardstick.
const ONE_PLACE: f64 = 1e-3;

/// [`spread_of`] places; without bound where they are all one, beside which any misfit is large.
pub(crate) fn spread_of_places<'p>(places: impl Iterator<Item = &'p [f64]> + Clone) -> f64 {
    let spread = spread_of(places.clone());
    // Of those that are one, any is as far from the origin as their middle.
    let away = places.map(|p| p.iter().map(|v| v * v).sum::<f64>().sqrt()).fold(0.0, f64::max);
    if spread > ONE_PLACE * away { spread } else { f64::INFINITY }
}

/// Root mean square distance of points from their centroid.
pub(crate) fn spread_of<'p>(points: impl Iterator<Item = &'p [f64]> + Clone) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
    let n = points.clone().count() as f64;
    let mut mean = Vec::new();
    for point in points.clone() {
        mean.resize(point.len(), 0.0);
        mean.iter_mut().zip(point).for_each(|(m, v)| *m += v / n);
    }
    let square = |point: &[f64]| point.iter().zip(&mean).map(|(v, m)| (v - m).powi(2)).sum::<f64>();
    (points.map(square).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{spread_of, spread_of_places};

    /// A metre from the origin, a tenth of a millimetre apart: readings have that spread, places are one.
    #[test]
    fn places_are_one_by_their_distance_from_the_origin_and_readings_are_not() {
        let near = [[1000.0, 0.0], [1000.1, 0.0]];
        let spread = |of: &[[f64; 2]]| spread_of(of.iter().map(<[f64; 2]>::as_slice));
        let of_places = |of: &[[f64; 2]]| spread_of_places(of.iter().map(<[f64; 2]>::as_slice));
        assert!((spread(&near) - 0.05).abs() < 1e-9);
        assert!(of_places(&near).is_infinite());
        let apart = [[1000.0, 0.0], [1010.0, 0.0]];
        assert!((of_places(&apart) - 5.0).abs() < 1e-9);
        // About the origin nothing is one but what is the same.
        assert!((of_places(&[[0.0, 0.0], [0.1, 0.0]]) - 0.05).abs() < 1e-9);
        assert!(of_places(&[[0.0, 0.0]; 2]).is_infinite());
    }
}
