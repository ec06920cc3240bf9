//! `truing import step`.

use std::fmt::Write as _;
use std::path::Path;

use truing::{Error, StepFace, StepImport, import_step, read_step, write_imported};

use super::output;

/// Lists the faces of a file, or one of them.
pub(super) fn listed(file: &Path, face: Option<usize>) -> Result<(), Error> {
    let step = read_step(file)?;
    let n_faces = step.faces.len();
    let mut text = format!("{}: {n_faces} faces", file.display());
    if step.is_assembly {
        text.push_str(", each in the coordinates of its own part, as no assembly is followed");
    }
    text.push_str("\n  face\n");
    let mut part = None;
    let asked = |number: &usize| face.is_none_or(|face| face == *number);
    for (number, face) in (1..).zip(&step.faces).filter(|(number, _)| asked(number)) {
        let heading = (face.part.as_str(), face.unit_mm);
        if part.replace(heading) != Some(heading) && !heading.0.is_empty() {
            let _ = writeln!(text, "        part {}", heading.0.escape_debug());
        }
        let _ = writeln!(text, "{number:>6}  {}", words(face));
    }
    let _ = writeln!(text, "next: truing import step {} --face N --out CASE", file.display());
    output::answer(&text)
}

fn words(face: &StepFace) -> String {
    match &face.surface {
        Ok(surface) if !surface.has_shape() => format!("{face}; no shape of a case"),
        _ => face.to_string(),
    }
}

/// Writes the case of a face.
pub(super) fn imported(file: &Path, import: &StepImport, folder: &Path) -> Result<(), Error> {
    let imported = import_step(file, import)?;
    let has_case = folder.join(imported.case.0).exists();
    let case = Some(imported.case).filter(|_| !has_case);
    let files: Vec<_> = case.into_iter().chain(imported.control).collect();
    let written = write_imported(&files, folder)?;
    let listed: String = written.iter().fold(String::new(), |mut text, file| {
        let _ = writeln!(text, "  {}", file.display());
        text
    });
    let (words, folder) = (imported.words, folder.display());
    if has_case {
        output::text(&format_args!(
            "{words}, wrote\n{listed}next: write into {folder}/case.toml\n\n{}",
            imported.surface
        ))?;
    } else {
        output::text(&format_args!(
            "{words}, wrote\n{listed}next: put the touches into {folder}, by truing import table or \
             by hand, then truing solve {folder}\n"
        ))?;
    }
    output::notes(&imported.notes);
    Ok(())
}
