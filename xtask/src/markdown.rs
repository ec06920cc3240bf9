//! Links and headings of a page of documentation.

use std::collections::BTreeMap;
use std::ops::Range;

use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd};

/// A link or picture of a page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Link {
    /// Where it leads to, as written.
    pub(crate) to: String,
    /// Where that is written in the page.
    pub(crate) at: Range<usize>,
}

fn events(page: &str) -> impl Iterator<Item = (Event<'_>, Range<usize>)> {
    Parser::new_ext(page, Options::ENABLE_TABLES).into_offset_iter()
}

/// Links and pictures in the order written.
pub(crate) fn links(page: &str) -> Vec<Link> {
    let link = |(event, range): (Event<'_>, Range<usize>)| {
        let Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) = event else {
            return None;
        };
        let to = dest_url.into_string();
        // The text of a link may hold the same words as its target.
        let start = range.start + page[range].rfind(&to)?;
        Some(Link { at: start..start + to.len(), to })
    };
    events(page).filter_map(link).collect()
}

/// Anchors of the headings, as GitHub and mdBook make them.
pub(crate) fn anchors(page: &str) -> Vec<String> {
    let (mut anchors, mut heading) = (Vec::new(), None);
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for (event, _) in events(page) {
        match (event, &mut heading) {
            (Event::Start(Tag::Heading { .. }), _) => heading = Some(String::new()),
            (Event::Text(text) | Event::Code(text), Some(heading)) => heading.push_str(&text),
            (Event::End(TagEnd::Heading(_)), Some(text)) => {
                let anchor = anchor(text);
                let before = seen.entry(anchor.clone()).or_default();
                let repeated = format!("{anchor}-{before}");
                anchors.push(if *before == 0 { anchor } else { repeated });
                *before += 1;
                heading = None;
            }
            _ => (),
        }
    }
    anchors
}

fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter_map(|c| match c {
        ' ' => Some('-'),
        '-' | '_' => Some(c),
        c => c.is_alphanumeric().then_some(c),
    });
    kept.collect::<String>().to_lowercase()
}

/// The page with every link led elsewhere; `None` leaves one as it is.
pub(crate) fn with_links(page: &str, lead: impl Fn(&str) -> Option<String>) -> String {
    let mut text = String::new();
    let mut rest = 0;
    // A picture may be within a link, whose target is written behind it.
    let mut links = links(page);
    links.sort_by_key(|link| link.at.start);
    for link in links {
        text.push_str(&page[rest..link.at.start]);
        text.push_str(&lead(&link.to).unwrap_or(link.to));
        rest = link.at.end;
    }
    text + &page[rest..]
}

/// Whether a link leads to another site.
pub(crate) fn is_external(to: &str) -> bool {
    to.contains("://") || to.starts_with("mailto:")
}

/// `to`, written in `page`, as a path from the root of the repository, and its anchor.
pub(crate) fn resolved<'a>(page: &str, to: &'a str) -> (String, Option<&'a str>) {
    let (path, anchor) = to.split_once('#').map_or((to, None), |(path, a)| (path, Some(a)));
    if path.is_empty() {
        return (page.to_owned(), anchor);
    }
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in path.split('/') {
        match part {
            "" | "." => (),
            ".." if parts.last().is_some_and(|last| *last != "..") => {
                parts.pop();
            }
            part => parts.push(part),
        }
    }
    (parts.join("/"), anchor)
}

#[cfg(test)]
mod tests {
    use super::{anchors, links, resolved, with_links};

    const PAGE: &str = "# A `b` c!\n\n[x](x.md), ![p](p.png) [![q](q.png)](y.md#z)\n\n\
                        ```text\n[no](link)\n```\n\n## A b c\n";

    #[test]
    fn links_and_anchors_are_found() {
        let to: Vec<String> = links(PAGE).into_iter().map(|link| link.to).collect();
        assert_eq!(to, ["x.md", "p.png", "y.md#z", "q.png"]);
        assert_eq!(anchors(PAGE), ["a-b-c", "a-b-c-1"]);
        assert_eq!(resolved("docs/a.md", "../crates/b#c"), ("crates/b".to_owned(), Some("c")));
        assert_eq!(resolved("docs/a.md", "#c"), ("docs/a.md".to_owned(), Some("c")));
        assert_eq!(resolved("a.md", "../b").0, "../b");
    }

    #[test]
    fn links_are_led_elsewhere() {
        let led = with_links(PAGE, |to| to.strip_suffix(".md").map(|to| format!("{to}.html")));
        assert!(led.contains("[x](x.html), ![p](p.png) [![q](q.png)](y.md#z)"), "{led}");
    }
}
