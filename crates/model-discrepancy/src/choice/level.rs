//! Levels of a covariate: values that come again and again, exactly or but for their noise.

/// Fewest and most values that are levels: two are a step, and of many a table says less than a
/// curve.
const MIN_LEVELS: usize = 3;
const MAX_LEVELS: usize = 64;

/// Visits that each level must have on the mean.
const MIN_VISITS: usize = 2;

/// Widest bunch of one level, as a share of the narrowest gap between levels: readings of a load
/// that is set again are far nearer to each other than to the next load.
const MAX_WIDTH: f64 = 0.1;

/// Distance from a bunch, as a share of the narrowest gap, within which a value is of its level.
const NEAR: f64 = 0.25;

/// Most decimals of a level's name.
const MAX_DECIMALS: i32 = 9;

/// Levels of a covariate, ascending.
#[derive(Clone, Debug)]
pub(crate) struct Levels {
    /// Least and largest fitted value of each, and how many there are.
    bunches: Vec<(f64, f64, usize)>,
    /// Distance from a bunch within which a value is of its level.
    near: f64,
}

impl Levels {
    /// Those of the fitted values; `None` where hardly any comes again.
    pub(crate) fn of(fitted: &[f64]) -> Option<Self> {
        let mut sorted = fitted.to_vec();
        sorted.sort_by(f64::total_cmp);
        let bunched = Self::bunched(&sorted).filter(Self::are_visited);
        bunched.or_else(|| Some(Self::split(&sorted, 0.0)).filter(Self::are_visited))
    }

    /// Bunches that lie apart by more than `gap`.
    fn split(sorted: &[f64], gap: f64) -> Self {
        let runs = sorted.chunk_by(|a, b| b - a <= gap);
        let bunches = runs.map(|run| (run[0], run[run.len() - 1], run.len())).collect();
        Self { bunches, near: 0.0 }
    }

    /// Bunches that are narrow beside the gaps between them; split where gaps jump in size most.
    fn bunched(sorted: &[f64]) -> Option<Self> {
        let mut gaps: Vec<f64> =
            sorted.windows(2).map(|w| w[1] - w[0]).filter(|&gap| gap > 0.0).collect();
        gaps.sort_by(|a, b| b.total_cmp(a));
        let most = gaps.len().min(MAX_LEVELS);
        let jump = |n: usize| gaps[n - 1] / gaps[n];
        let splits = (MIN_LEVELS - 1..most).max_by(|&a, &b| jump(a).total_cmp(&jump(b)))?;
        let (narrowest, next) = (gaps[splits - 1], gaps[splits]);
        let mut levels = Self::split(sorted, next);
        levels.near = NEAR * narrowest;
        let are_narrow =
            levels.bunches.iter().all(|(low, high, _)| high - low <= MAX_WIDTH * narrowest);
        are_narrow.then_some(levels)
    }

    /// Whether there are some, not too many, and each is visited often enough on the mean.
    fn are_visited(&self) -> bool {
        let visits: usize = self.bunches.iter().map(|b| b.2).sum();
        let enough = self.repeated().len() >= MIN_LEVELS && self.len() <= MAX_LEVELS;
        enough && visits >= MIN_VISITS * self.len()
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.bunches.len()
    }

    /// Those that are visited more than once.
    pub(crate) fn repeated(&self) -> Vec<usize> {
        (0..self.bunches.len()).filter(|&l| self.bunches[l].2 > 1).collect()
    }

    /// Level of a value; `None` between levels.
    pub(crate) fn level(&self, value: f64) -> Option<usize> {
        let is_near = |&(low, high, _): &(f64, f64, usize)| {
            value >= low - self.near && value <= high + self.near
        };
        self.bunches.iter().position(is_near)
    }

    /// Its value, as it is written: the middle of a bunch.
    pub(crate) fn name(&self, level: usize) -> String {
        let (low, high, _) = self.bunches[level];
        if self.near == 0.0 {
            return low.to_string();
        }
        // Written so that a hundredth of the gap to the next one shows.
        let step = 0.01 * self.near / NEAR;
        let decimals = (0..MAX_DECIMALS).find(|&n| 0.1_f64.powi(n) <= step);
        let decimals = usize::try_from(decimals.unwrap_or(MAX_DECIMALS)).unwrap_or_default();
        format!("about {:.decimals$}", f64::midpoint(low, high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::count::count;

    #[test]
    fn values_that_come_again_are_levels() {
        let levels = Levels::of(&[3.0, 1.0, 2.0, 1.0, 2.0, 3.0, -0.0, 0.0]).expect("four levels");
        assert_eq!(levels.len(), 4);
        assert_eq!(levels.level(0.0), Some(0));
        assert_eq!((levels.level(2.0), levels.level(2.5)), (Some(2), None));
        assert_eq!(levels.name(1), "1");
    }

    #[test]
    fn readings_of_a_load_that_is_set_again_are_one_level() {
        let loads: Vec<f64> =
            (0..30).map(|i| [20.0, 40.0, 80.0][i % 3] + 0.01 * count(i * i % 7)).collect();
        let levels = Levels::of(&loads).expect("three levels");
        assert_eq!(levels.len(), 3);
        assert_eq!(levels.level(39.9), Some(1));
        assert_eq!(levels.name(0), "about 20.0");
    }

    #[test]
    fn scattered_and_unrepeated_values_are_none() {
        let scattered: Vec<f64> = (0..40).map(|i| (count(i) * 0.618).fract()).collect();
        assert!(Levels::of(&scattered).is_none());
        assert!(Levels::of(&[1.0, 2.0, 3.0, 4.0]).is_none());
        assert!(Levels::of(&[1.0, 1.0, 2.0, 2.0]).is_none(), "two are a step");
    }
}
