/// A heading as an address or the name of a file: letters and digits in lower case, joined by
/// hyphens.
pub(crate) fn slug(heading: &str) -> String {
    let kept = heading.chars().map(|c| if c.is_alphanumeric() { c } else { '-' });
    let joined = kept.collect::<String>().to_lowercase();
    joined.split('-').filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}
