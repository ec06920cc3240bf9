//! `truing`, run as a process.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::shell;

/// The built program.
#[derive(Clone, Debug)]
pub(crate) struct Truing {
    binary: PathBuf,
}

/// What it answered.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    /// Exit code; `None` where a signal ended it.
    pub code: Option<i32>,
    /// Standard output read as JSON; null where there is none.
    pub json: Value,
    /// Standard error.
    pub message: String,
}

impl Truing {
    /// Builds it in the release profile. With the examples, since what these need decides which
    /// features dependencies have: so it is the build of `cargo xtask test`, and not another one.
    /// `TRUING_PROGRAM` names one that is built already.
    pub(crate) fn build() -> Result<Self> {
        if let Some(binary) = std::env::var_os("TRUING_PROGRAM") {
            return Ok(Self { binary: std::path::absolute(PathBuf::from(binary))? });
        }
        shell::cargo(&[
            "build",
            "--release",
            "--workspace",
            "--all-features",
            "--bin",
            "truing",
            "--examples",
        ])?;
        let metadata = shell::metadata(false)?;
        let target = metadata["target_directory"].as_str().context("no target directory")?;
        let name = format!("truing{}", std::env::consts::EXE_SUFFIX);
        Ok(Self { binary: Path::new(target).join("release").join(name) })
    }

    /// The one that was built with the tests of the workspace, beside which it lies.
    ///
    /// `cargo test -p xtask` alone does not build it: `cargo build -p truing` does.
    #[cfg(test)]
    pub(crate) fn beside_the_tests() -> Result<Self> {
        let test = std::env::current_exe()?;
        let profile = test.ancestors().nth(2).context("tests lie in target/PROFILE/deps")?;
        let binary = profile.join(format!("truing{}", std::env::consts::EXE_SUFFIX));
        anyhow::ensure!(binary.exists(), "no {}: run `cargo build -p truing`", binary.display());
        Ok(Self { binary })
    }

    /// One that is built already, or else built now.
    pub(crate) fn given(binary: Option<&Path>) -> Result<Self> {
        binary.map_or_else(Self::build, |binary| Ok(Self { binary: binary.to_path_buf() }))
    }

    /// Where it lies.
    pub(crate) fn path(&self) -> &Path {
        &self.binary
    }

    /// Writes a case and runs one command on it, on one thread; what was in `folder` goes, as a
    /// table of the case before would be read with this one.
    pub(crate) fn asked<N: AsRef<Path>, T: AsRef<[u8]>>(
        &self,
        verb: &str,
        files: impl IntoIterator<Item = (N, T)>,
        folder: &Path,
    ) -> Result<Answer> {
        write_case(files, folder)?;
        let options = ["--json", "--threads", "1"].map(OsStr::new);
        self.run(&[&[OsStr::new(verb), folder.as_os_str()], &options[..]].concat())
    }

    /// Runs one command.
    pub(crate) fn run<S: AsRef<OsStr>>(&self, arguments: &[S]) -> Result<Answer> {
        let output = Command::new(&self.binary)
            .args(arguments)
            .output()
            .with_context(|| format!("cannot start {}", self.binary.display()))?;
        Ok(Answer {
            code: output.status.code(),
            json: serde_json::from_slice(&output.stdout).unwrap_or(Value::Null),
            message: String::from_utf8_lossy(&output.stderr).trim().to_owned(),
        })
    }
}

/// Writes the files of a case into a folder of its own.
pub(crate) fn write_case<N: AsRef<Path>, T: AsRef<[u8]>>(
    files: impl IntoIterator<Item = (N, T)>,
    folder: &Path,
) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).with_context(|| format!("cannot empty {}", folder.display()))?;
    }
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (name, text) in files {
        let path = folder.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

/// One value of an answer: keys from the root separated by dots, `name=value` picks from a list.
pub(crate) fn value_at<'a>(json: &'a Value, path: &str) -> Option<&'a Value> {
    let mut at = json;
    for key in path.split('.') {
        at = match (key.split_once('='), at) {
            (Some((name, wanted)), Value::Array(items)) => {
                items.iter().find(|item| item[name].as_str() == Some(wanted))?
            }
            (None, Value::Array(items)) => items.get(key.parse::<usize>().ok()?)?,
            _ => at.get(key)?,
        };
    }
    Some(at)
}

/// The number at a path.
pub(crate) fn number_at(json: &Value, path: &str) -> Option<f64> {
    value_at(json, path)?.as_f64()
}

/// Strings of a list, or of one key of a list of objects.
pub(crate) fn strings<'a>(list: &'a Value, key: Option<&str>) -> Vec<&'a str> {
    let items = list.as_array().map_or(&[][..], Vec::as_slice);
    let string = |item: &'a Value| match key {
        Some(key) => item[key].as_str(),
        None => item.as_str(),
    };
    items.iter().filter_map(string).collect()
}

/// An added effect with those that this data cannot tell from it.
pub(crate) fn class_of(step: &Value) -> Vec<&str> {
    let mut class = strings(&step["indistinguishable_from"], None);
    class.extend(step["effect"].as_str());
    class.into_iter().map(without_subject).collect()
}

/// Id of an added effect, its subject in brackets where it has one; `None` where there is no id.
pub(crate) fn label_of(step: &Value) -> Option<String> {
    let id = step["effect"].as_str()?;
    let subject = step["subject"].as_str();
    Some(subject.map_or_else(|| id.to_owned(), |subject| format!("{id} [{subject}]")))
}

/// `bad-point` of `bad-point [P09]` or `bad-point (P09)`.
pub(crate) fn without_subject(effect: &str) -> &str {
    effect.split([' ', '[', '(']).next().unwrap_or(effect)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_pick_by_key_by_place_and_by_name() {
        let json = serde_json::json!({ "a": [ { "press": "P1", "x": 1.5 }, { "press": "P2", "x": 2.5 } ] });
        assert_eq!(number_at(&json, "a.1.x"), Some(2.5));
        assert_eq!(number_at(&json, "a.press=P1.x"), Some(1.5));
        assert_eq!(number_at(&json, "a.press=P3.x"), None);
        assert_eq!(number_at(&json, "b"), None);
    }

    #[test]
    fn a_class_is_the_effect_and_its_rivals_without_subjects() {
        let step = serde_json::json!({
            "effect": "bad-point [P09]", "indistinguishable_from": ["scale"]
        });
        assert_eq!(class_of(&step), ["scale", "bad-point"]);
    }
}
