//! Many pages on one, behind a table.

use super::sample::{four_displacements, nothing_missing, photogrammetry};
use super::{parse, text_of};
use crate::report::{IndexEntry, ReadPageError, render, render_index};

#[test]
fn the_table_has_a_line_per_case_that_leads_to_it() {
    let samples = [photogrammetry(), four_displacements(), nothing_missing()];
    let entries: Vec<IndexEntry> =
        samples.iter().map(|s| IndexEntry::from_page(&render(&s.closed())).unwrap()).collect();
    let page = render_index("Cases", "", &entries);
    let document = parse(&page);
    let table = document.descendants().find(|n| n.has_tag_name("tbody")).unwrap();
    let lines: Vec<_> = table.children().filter(|n| n.has_tag_name("tr")).collect();
    assert_eq!(lines.len(), samples.len());
    for (line, sample) in lines.iter().zip(&samples) {
        assert!(text_of(*line).contains(&sample.title));
        let link = line.descendants().find_map(|n| n.attribute("href")).unwrap();
        let target = document
            .descendants()
            .find(|n| n.attribute("id").is_some_and(|id| link == format!("#{id}")))
            .unwrap();
        let heading = target.descendants().find(|n| n.has_tag_name("h1")).unwrap();
        assert_eq!(text_of(heading), sample.title);
    }
    // Document [A] Table 4: error before, after left out in turn, printed figure, class of names.
    let published = text_of(lines[1]);
    for expected in ["0.280", "0.066", "0.280 mm rms", "moment-gain or force-gain or frame-scale"] {
        assert!(published.contains(expected), "{expected} in {published}");
    }
}

#[test]
fn a_solve_without_the_loop_has_a_line_too() {
    let sample = photogrammetry();
    let entry = IndexEntry::from_page(&render(&sample.solved())).unwrap();
    assert_eq!(entry.summary.verdict, None);
    let page = render_index("Cases", "", std::slice::from_ref(&entry));
    // Root mean square per point over all 24, of residuals made before the page was.
    let squares: f64 = sample.closure.residuals_before.iter().map(|r| r * r).sum();
    let expected = format!("{:.3} (fitted)", (squares / 24.0).sqrt());
    assert!(page.contains(&expected), "{expected}");
}

#[test]
fn an_index_without_cases_is_a_page() {
    parse(&render_index("Cases", "", &[]));
}

#[test]
fn other_files_are_refused() {
    assert!(matches!(IndexEntry::from_page("<html></html>"), Err(ReadPageError::NotAReport)));
    let page = render(&photogrammetry().closed());
    let spoilt = page.replace("\"held_out\":", "\"held-out\":").replace("\"title\"", "\"name\"");
    assert!(matches!(IndexEntry::from_page(&spoilt), Err(ReadPageError::Summary(_))));
    let half = &page[..page.find("<!--/truing:case-->").unwrap()];
    assert!(matches!(IndexEntry::from_page(half), Err(ReadPageError::NotAReport)));
}
