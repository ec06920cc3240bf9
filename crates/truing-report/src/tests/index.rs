//! Many pages on one, behind a table.

use super::sample::{Sample, four_displacements, nothing_missing, photogrammetry};
use super::{parse, text_of};
use crate::{IndexEntry, Mistake, ReadPageError, ReportInput, Rms, Story, render, render_index};

#[test]
fn the_table_has_a_line_per_case_that_leads_to_it() {
    let samples = [photogrammetry(), four_displacements(), nothing_missing()];
    let entries: Vec<IndexEntry> = (samples.iter().enumerate())
        .map(|(i, s)| IndexEntry::from_page(&render(&s.closed()), format!("{i}.html")).unwrap())
        .collect();
    let page = render_index("Cases", "", &entries);
    let document = parse(&page);
    let table = document.descendants().find(|n| n.has_tag_name("tbody")).unwrap();
    let lines: Vec<_> = table.children().filter(|n| n.has_tag_name("tr")).collect();
    assert_eq!(lines.len(), samples.len());
    for (i, (line, sample)) in lines.iter().zip(&samples).enumerate() {
        assert!(text_of(*line).contains(&sample.title));
        let link = line.descendants().find_map(|n| n.attribute("href")).unwrap();
        assert_eq!(link, format!("{i}.html"));
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
    let entry = IndexEntry::from_page(&render(&sample.solved()), "a.html").unwrap();
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
    assert!(matches!(IndexEntry::from_page("<html></html>", ""), Err(ReadPageError::NotAReport)));
    let page = render(&photogrammetry().closed());
    let spoilt = page.replace("\"held_out\":", "\"held-out\":").replace("\"title\"", "\"name\"");
    assert!(matches!(IndexEntry::from_page(&spoilt, ""), Err(ReadPageError::Summary(_))));
    let half = &page[..page.find("<!--/truing:case-->").unwrap()];
    assert!(matches!(IndexEntry::from_page(half, ""), Err(ReadPageError::NotAReport)));
}

/// Entries of a measured, a published and a simulated case.
fn three() -> Vec<IndexEntry> {
    let samples = [photogrammetry(), four_displacements(), nothing_missing()];
    let story = Story { question: Some("Is it as large as before?".into()), ..Story::default() };
    let page = |(i, sample): (usize, &Sample)| {
        let input =
            ReportInput { story: (i == 0).then_some(&story), simulated: i == 2, ..sample.closed() };
        IndexEntry::from_page(&render(&input), format!("{i}.html")).unwrap()
    };
    samples.iter().enumerate().map(page).collect()
}

/// What was wrong with the input is named with the error before it was mended, not after.
#[test]
fn a_case_whose_input_is_wrong_says_so_in_its_line() {
    let sample = photogrammetry();
    let mistakes = [Mistake {
        names: vec!["input:unit [pairs.csv: to_x_mm]".into(), "input:sign".into()],
        subject: "pairs.csv: to_x_mm".into(),
        description: "in inches".into(),
    }];
    let as_read = Rms { train: Some(300.0), held_out: Some(321.0), held_out_std: Some(9.0) };
    let input = ReportInput { mistakes: &mistakes, as_read: Some(as_read), ..sample.closed() };
    let entry = IndexEntry::from_page(&render(&input), "0.html").unwrap();
    let plain = IndexEntry::from_page(&render(&sample.closed()), "0.html").unwrap();
    assert_eq!(entry.summary.verdict.as_deref(), Some("input wrong"));
    assert_eq!((entry.summary.before, entry.summary.after), (as_read, plain.summary.after));
    assert_eq!(entry.summary.added[0], mistakes[0].names);
    assert_eq!(entry.summary.added[1..], plain.summary.added);
    assert!(render_index("Cases", "", &[entry]).contains("input:unit [pairs.csv: to_x_mm]"));
}

#[test]
fn measured_data_come_first_and_simulated_cases_are_folded() {
    let entries = three();
    let page = render_index("Cases", "", &entries);
    let document = parse(&page);
    let links: Vec<_> = document.descendants().filter_map(|n| n.attribute("href")).collect();
    assert_eq!(links, ["0.html", "1.html", "2.html"]);
    assert!(page.contains("Is it as large as before?"));
    let fold = document.descendants().find(|n| n.has_tag_name("details")).unwrap();
    assert_eq!(fold.attribute("open"), None);
    assert!(fold.descendants().any(|n| n.attribute("href") == Some("2.html")));
    assert!(!page.contains("as recorded"), "nothing was compared");
}

#[test]
fn a_case_that_is_not_as_recorded_is_counted_shown_and_unfolded() {
    let mut entries = three();
    for entry in &mut entries {
        entry.findings = Some(Vec::new());
    }
    let page = render_index("Cases", "", &entries);
    assert_eq!(page.matches("3 of 3 as recorded").count(), 2, "above and below");
    entries[2].findings = Some(vec!["verdict explained, expected nothing-missing".into()]);
    let page = render_index("Cases", "", &entries);
    let document = parse(&page);
    assert!(page.contains("2 of 3 as recorded") && !page.contains("3 of 3 as recorded"));
    assert!(page.contains("NOT AS RECORDED: verdict explained, expected nothing-missing"));
    let fold = document.descendants().find(|n| n.has_tag_name("details")).unwrap();
    assert_eq!(fold.attribute("open"), Some("open"));
}
