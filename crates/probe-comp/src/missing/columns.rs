//! Recorded columns whose names say what they are.

use model_discrepancy::Covariate;

/// Column that times the touches.
pub(crate) const TIME: &str = "time_s";
/// Reference temperature of dimensional measurement, ISO 1.
pub(crate) const REFERENCE_C: f64 = 20.0;

/// Beginnings of the names of a feed.
const FEEDS: [&str; 3] = ["feed", "speed", "velocity"];
/// Endings of a speed with what makes mm/s of it.
const PER_SECOND: [(&str, f64); 4] =
    [("mm_per_s", 1.0), ("mm_s", 1.0), ("mm_per_min", 1.0 / 60.0), ("mm_min", 1.0 / 60.0)];

/// The column that holds the feed towards the part, and what makes mm/s of it.
pub(crate) fn feed(covariates: &[Covariate]) -> Option<(&Covariate, f64)> {
    covariates.iter().find_map(|covariate| {
        let name = covariate.name.as_str();
        let (_, factor) = PER_SECOND.into_iter().find(|(ending, _)| name.ends_with(ending))?;
        FEEDS.iter().any(|feed| name.starts_with(feed)).then_some((covariate, factor))
    })
}

#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
pub(crate) fn as_f64(count: usize) -> f64 {
    count as f64
}
