//! The tables of a case folder, as text and numbers.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::shell;

/// A case folder on disk.
#[derive(Clone, Debug)]
pub(crate) struct Folder {
    pub(crate) path: PathBuf,
}

/// One table: columns by name, in the order of the rows.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    columns: BTreeMap<String, Vec<String>>,
}

impl Folder {
    /// Every committed case of a crate.
    pub(crate) fn committed(krate: &str) -> Vec<Self> {
        let of_crate = shell::root().join("fixtures").join(krate);
        let entries = std::fs::read_dir(&of_crate).expect("fixtures are committed");
        let mut paths: Vec<PathBuf> = entries.map(|e| e.expect("a folder").path()).collect();
        paths.retain(|path| path.join("case.toml").exists());
        paths.sort();
        paths.into_iter().map(|path| Self { path }).collect()
    }

    /// A folder of its own under `target` with these files.
    pub(crate) fn written(name: &str, files: &[(&str, String)]) -> Self {
        let path = shell::root().join("target").join("handback").join(name);
        if path.exists() {
            std::fs::remove_dir_all(&path).expect("an own folder");
        }
        std::fs::create_dir_all(&path).expect("an own folder");
        for (file, text) in files {
            std::fs::write(path.join(file), text).expect("an own file");
        }
        Self { path }
    }

    pub(crate) fn name(&self) -> String {
        let last: Vec<_> = self.path.iter().rev().take(2).collect();
        format!("{}/{}", last[1].display(), last[0].display())
    }

    pub(crate) fn has(&self, file: &str) -> bool {
        self.path.join(file).exists()
    }

    /// `case.toml`.
    pub(crate) fn document(&self) -> toml::Table {
        let text = std::fs::read_to_string(self.path.join("case.toml")).expect("a case has one");
        text.parse().expect("TOML")
    }

    pub(crate) fn table(&self, file: &str) -> Table {
        Table::read(&self.path.join(file))
    }
}

impl Table {
    fn read(path: &Path) -> Self {
        Self::of(&std::fs::read_to_string(path).expect("a table"))
    }

    /// From text.
    pub(crate) fn of(text: &str) -> Self {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let names: Vec<String> =
            reader.headers().expect("a header").iter().map(str::to_owned).collect();
        let mut columns: BTreeMap<String, Vec<String>> =
            names.iter().map(|name| (name.clone(), Vec::new())).collect();
        for record in reader.records() {
            for (name, cell) in names.iter().zip(record.expect("a row").iter()) {
                columns.get_mut(name).expect("of the header").push(cell.to_owned());
            }
        }
        Self { columns }
    }

    pub(crate) fn has(&self, column: &str) -> bool {
        self.columns.contains_key(column)
    }

    pub(crate) fn texts(&self, column: &str) -> &[String] {
        self.columns.get(column).unwrap_or_else(|| panic!("no column {column}"))
    }

    pub(crate) fn numbers(&self, column: &str) -> Vec<f64> {
        let number = |text: &String| text.parse().expect("a number");
        self.texts(column).iter().map(number).collect()
    }

    /// Names of the columns that end so.
    pub(crate) fn ending(&self, ending: &str) -> Vec<String> {
        self.columns.keys().filter(|name| name.ends_with(ending)).cloned().collect()
    }

    pub(crate) fn rows(&self) -> usize {
        self.columns.values().next().map_or(0, Vec::len)
    }
}

/// A table with one column more.
pub(crate) fn with_column(table: &str, name: &str, cells: impl Iterator<Item = String>) -> String {
    let column = std::iter::once(name.to_owned()).chain(cells);
    let rows: Vec<String> =
        table.lines().zip(column).map(|(row, cell)| [row, &cell].join(",")).collect();
    rows.join("\n") + "\n"
}
