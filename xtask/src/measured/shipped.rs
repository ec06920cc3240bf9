//! Cases of measured data that are committed, each as its converter writes it.
//!
//! Questions, expectations and what other calculations gave stand in the `provenance.toml` of each
//! folder and are written by hand; tables, settings, source, licence and hashes are not.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use super::{
    Case, Set, ball, bearing, elevation, mirrors, photogrammetry, spots, stability, wheel,
};
use crate::expectation::Provenance;
use crate::generators::sha256;
use crate::shell;

const PROVENANCE: &str = "provenance.toml";

/// A converted case and where it is kept.
struct Shipped {
    set: &'static Set,
    case: &'static str,
    /// Under `fixtures/`: crate and case.
    folder: &'static str,
}

const fn shipped(set: &'static Set, case: &'static str, folder: &'static str) -> Shipped {
    Shipped { set, case, folder }
}

/// In the order in which they are shown.
const SHIPPED: &[Shipped] = &[
    shipped(&spots::SET, "spots", "frame-fit/measured-camera"),
    shipped(
        &photogrammetry::SET,
        "20250331_Set_04-20250331_Set_05",
        "frame-fit/measured-photogrammetry",
    ),
    shipped(&stability::SET, "cycle-1490", "frame-fit/measured-overnight"),
    shipped(&ball::SET, "frontleft", "frame-fit/measured-ball-in-cups"),
    shipped(&ball::SET, "grid", "frame-fit/measured-cup-grid"),
    shipped(&wheel::SET, "untouched", "ft-center/measured-wheel"),
    shipped(&elevation::BY_STOP, "mirrors", "tracker-lm/measured-elevation-stops"),
    shipped(&elevation::BY_TARGET, "mirrors", "tracker-lm/measured-elevation-targets"),
    shipped(&mirrors::SET, "M1_20250831_1", "pose-icp/measured-mirror-1"),
    shipped(
        &mirrors::SET,
        "M1_20250831_2-after-M1_20250831_1",
        "pose-icp/measured-mirror-1-next-session",
    ),
    shipped(&mirrors::SET, "M2_20250828", "pose-icp/measured-mirror-2"),
    shipped(&bearing::SET, "fitted-1-judged-2", "probe-comp/measured-bearing"),
];

/// Folders of the committed measured cases under `fixtures/`, in the order in which they are shown.
pub(crate) fn folders() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|shipped| shipped.folder)
}

/// Writes every committed case anew from the published files in `data`.
pub(super) fn write(data: &Path) -> Result<()> {
    let fixtures = shell::root().join("fixtures");
    for (shipped, case) in converted(data)? {
        let folder = fixtures.join(shipped.folder);
        fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
        for (name, text) in files(&case) {
            let path = folder.join(name);
            fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        }
        let path = folder.join(PROVENANCE);
        let provenance = provenance(&path, shipped, &case)?;
        let text = toml::to_string(&provenance).context("provenance is plain data")?;
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        println!("fixtures/{}", shipped.folder);
    }
    Ok(())
}

/// Every committed case as its converter makes it.
fn converted(data: &Path) -> Result<Vec<(&'static Shipped, Case)>> {
    let mut made: BTreeMap<&str, Vec<Case>> = BTreeMap::new();
    let mut cases = Vec::new();
    for shipped in SHIPPED {
        let set = shipped.set;
        if !made.contains_key(set.name) {
            let found = (set.convert)(&data.join(set.place))
                .with_context(|| format!("{}: not converted; {}", set.name, set.source))?;
            made.insert(set.name, found);
        }
        let of_set = made.get_mut(set.name).expect("converted above");
        let Some(at) = of_set.iter().position(|case| case.name == shipped.case) else {
            let names: Vec<&str> = of_set.iter().map(|case| &*case.name).collect();
            bail!("{} has no case {}; it has {}", set.name, shipped.case, names.join(", "));
        };
        cases.push((shipped, of_set.swap_remove(at)));
    }
    Ok(cases)
}

/// What the converter knows of a case, over what was written by hand.
fn provenance(path: &Path, shipped: &Shipped, case: &Case) -> Result<Provenance> {
    let by_hand = match fs::read_to_string(path) {
        Ok(text) => {
            toml::from_str(&text).with_context(|| format!("cannot read {}", path.display()))?
        }
        Err(_) => Provenance { title: shipped.case.to_owned(), ..Provenance::default() },
    };
    let hash = |(name, text): (&str, &str)| (name.to_owned(), sha256(text.as_bytes()));
    Ok(Provenance {
        source: shipped.set.source.to_owned(),
        licence: shipped.set.licence.to_owned(),
        converted: case.notes.clone(),
        files: files(case).map(hash).collect(),
        ..by_hand
    })
}

/// Name and text of every file that the converter writes.
fn files(case: &Case) -> impl Iterator<Item = (&str, &str)> {
    let tables = case.tables.iter().map(|(name, text)| (*name, text.as_str()));
    std::iter::once(("case.toml", case.settings.as_str())).chain(tables)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest size of all committed measured cases.
    const LARGEST_BYTES: usize = 8_000_000;

    #[test]
    fn committed_cases_are_what_the_converters_make_of_the_published_files() {
        let Some(data) = std::env::var_os("TRUING_MEASURED_DATA") else {
            eprintln!("skipped: TRUING_MEASURED_DATA names no folder with the published files");
            return;
        };
        let fixtures = shell::root().join("fixtures");
        let mut bytes = 0;
        for (shipped, case) in converted(Path::new(&data)).unwrap() {
            let folder = fixtures.join(shipped.folder);
            for (name, text) in files(&case) {
                let committed = fs::read_to_string(folder.join(name)).unwrap();
                assert!(committed == text, "{}/{name} differs", shipped.folder);
                bytes += text.len();
            }
            let text = fs::read_to_string(folder.join(PROVENANCE)).unwrap();
            let read: Provenance = toml::from_str(&text).unwrap();
            assert_eq!(read, provenance(&folder.join(PROVENANCE), shipped, &case).unwrap());
        }
        assert!(bytes < LARGEST_BYTES, "{bytes} bytes of measured cases");
    }

    #[test]
    fn every_committed_case_says_what_is_asked_and_pins_the_answer() {
        for shipped in SHIPPED {
            let path = shell::root().join("fixtures").join(shipped.folder).join(PROVENANCE);
            let read: Provenance = toml::from_str(&fs::read_to_string(path).unwrap()).unwrap();
            let folder = shipped.folder;
            assert!(read.question.is_some(), "{folder} asks nothing");
            assert!(read.independent.is_some(), "{folder} has nothing to compare with");
            assert_eq!(read.expect.verdict.len(), 1, "{folder}: one verdict");
            let pins = |path: &str| read.expect.loop_numbers.iter().any(|n| n.path == path);
            assert!(pins("before.held_out_rms") && pins("after.held_out_rms"), "{folder}");
            assert!(read.expect.nothing_else, "{folder} lets other effects pass");
        }
    }
}
