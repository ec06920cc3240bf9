//! Lists of names for people.

/// Most names listed one by one for people; the JSON has them all.
pub const MOST_NAMES: usize = 6;

/// Names with commas, the many shortened to how many more there are.
#[must_use]
pub fn shortened(names: &[String]) -> String {
    // One more takes no more room than saying so.
    if names.len() <= MOST_NAMES + 1 {
        return names.join(", ");
    }
    format!("{} and {} more", names[..MOST_NAMES].join(", "), names.len() - MOST_NAMES)
}
