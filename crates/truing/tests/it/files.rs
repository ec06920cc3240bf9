//! What is written: whole or not at all, never over an input, and the same in every run.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::command::{Case, Ended, truing};

const BINARY: &str = env!("CARGO_BIN_EXE_truing");

fn words<'a>(words: &[&'a str], paths: &[&'a Path]) -> Vec<&'a str> {
    words.iter().copied().chain(paths.iter().map(|p| p.to_str().unwrap())).collect()
}

/// Names in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn solve_with_report(case: &Case, report: &Path) -> Ended {
    truing(&["solve", case.path().to_str().unwrap(), "--report", report.to_str().unwrap()])
}

#[cfg(unix)]
mod on_unix {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;

    /// Runs the binary where no file may grow beyond 4 KiB.
    fn limited(arguments: &[&str]) -> (Option<i32>, String) {
        let output = Command::new("sh")
            .args(["-c", "ulimit -f 8; exec \"$0\" \"$@\"", BINARY])
            .args(arguments)
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    }

    #[test]
    fn where_a_file_cannot_be_finished_the_old_ones_stay() {
        let case = Case::example("tracker-lm");
        let out = Case::new(&[("b.csv", "old table"), ("b.html", "old page")]);
        let (csv, page) = (out.file("b.csv"), out.file("b.html"));
        let folder = case.path();
        let arguments = words(&["solve"], &[folder]);
        let arguments = [
            &arguments[..],
            &["--errors", csv.to_str().unwrap(), "--report", page.to_str().unwrap()],
        ]
        .concat();
        let (code, message) = limited(&arguments);
        assert_eq!(code, Some(2), "{message}");
        assert!(message.contains("b.html cannot be written: file too large"), "{message}");
        assert_eq!(fs::read_to_string(&csv).unwrap(), "old table", "not even the one that fits");
        assert_eq!(fs::read_to_string(&page).unwrap(), "old page");
        assert_eq!(names(out.path()), ["b.csv", "b.html"], "no temporary file is left");

        let free = truing(&arguments);
        assert_eq!(free.code, 0, "{}", free.stderr);
        assert!(fs::metadata(&page).unwrap().len() > 4096, "the limit was what stopped it");
        assert_eq!(names(out.path()), ["b.csv", "b.html"]);
    }

    #[test]
    fn a_case_is_made_whole_or_not_at_all() {
        let out = Case::new(&[]);
        let folder = out.file("new");
        let (code, message) = limited(&["init", "tracker-lm", folder.to_str().unwrap()]);
        assert_eq!(code, Some(2), "{message}");
        assert!(message.contains("file too large"), "{message}");
        assert_eq!(names(out.path()), Vec::<String>::new());
    }

    /// Whenever it is killed, the old page or the new one is there, whole.
    #[test]
    fn a_killed_process_leaves_a_whole_file() {
        let case = Case::example("frame-fit");
        let out = Case::new(&[]);
        let page = out.file("page.html");
        assert_eq!(solve_with_report(&case, &page).code, 0);
        let new = fs::read_to_string(&page).unwrap();
        for wait in 0..24 {
            fs::write(&page, "old").unwrap();
            let mut child = Command::new(BINARY)
                .args(words(&["solve"], &[case.path()]))
                .args(words(&["--report"], &[&page]))
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(Duration::from_millis(wait));
            child.kill().unwrap();
            child.wait().unwrap();
            let found = fs::read_to_string(&page).unwrap();
            assert!(found == "old" || found == new, "{} bytes after {wait} ms", found.len());
        }
    }

    #[test]
    fn permissions_and_links_stay() {
        let case = Case::example("frame-fit");
        let out = Case::new(&[("real.html", "old")]);
        let (real, link) = (out.file("real.html"), out.file("link.html"));
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("real.html", &link).unwrap();
        let ended = solve_with_report(&case, &link);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(fs::read_to_string(&real).unwrap().starts_with("<!"));
        assert_eq!(fs::metadata(&real).unwrap().mode() & 0o777, 0o640);

        // A link to nothing yet, and a file like any other program would make it.
        let dangling = out.file("dangling.html");
        symlink("new.html", &dangling).unwrap();
        assert_eq!(solve_with_report(&case, &dangling).code, 0);
        let new = fs::metadata(out.file("new.html")).unwrap().mode() & 0o777;
        fs::write(out.file("plain"), "").unwrap();
        assert_eq!(new, fs::metadata(out.file("plain")).unwrap().mode() & 0o777);
    }

    #[test]
    fn devices_are_written_to_as_they_are() {
        let case = Case::example("frame-fit");
        assert_eq!(solve_with_report(&case, Path::new("/dev/null")).code, 0);
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
        let piped = Command::new(BINARY)
            .args(words(&["solve"], &[case.path()]))
            .args(["--report", "/dev/stdout"])
            .output()
            .unwrap();
        assert!(
            String::from_utf8(piped.stdout).unwrap().contains("<!DOCTYPE html>"),
            "{:?}",
            piped.status
        );
        let full = solve_with_report(&case, Path::new("/dev/full"));
        assert_eq!(full.code, 2, "{}", full.stderr);
    }

    #[test]
    fn inputs_by_another_name_are_not_overwritten() {
        let case = Case::example("pose-icp");
        case.write("part.ngc", "G90 G0 X0 Y0 Z0\n");
        fs::hard_link(case.file("points.csv"), case.file("hard.html")).unwrap();
        symlink("points.csv", case.file("soft.html")).unwrap();
        let before = fs::read(case.file("points.csv")).unwrap();
        for name in ["points.csv", "hard.html", "soft.html", "case.toml", "../x/../points.csv"] {
            let at = match name.strip_prefix("../x/") {
                Some(rest) => case.path().join("no").join(rest),
                None => case.file(name),
            };
            fs::create_dir_all(case.file("no")).unwrap();
            for command in ["solve", "loop"] {
                let folder = case.path().to_str().unwrap();
                let ended = truing(&[command, folder, "--report", at.to_str().unwrap()]);
                assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{name}");
                let message = ended.one_message();
                assert!(message.contains("is an input of this run"), "{message}");
            }
        }
        assert_eq!(fs::read(case.file("points.csv")).unwrap(), before);
        let (folder, program) = (case.path().to_str().unwrap(), case.file("part.ngc"));
        let program = program.to_str().unwrap();
        let ended = truing(&["correct", folder, program, "--output", program]);
        assert_eq!(ended.code, 2);
        assert!(ended.one_message().contains("part.ngc is an input of this run"));
        assert_eq!(fs::read_to_string(program).unwrap(), "G90 G0 X0 Y0 Z0\n");
    }

    #[test]
    fn one_file_is_not_two_outputs() {
        let case = Case::example("tracker-lm");
        let out = Case::new(&[("b.tab", "old")]);
        let (a, b) = (out.file("a.csv"), out.file("./a.csv"));
        symlink("b.tab", out.file("link.comp")).unwrap();
        for (errors, other) in [(a, b), (out.file("b.tab"), out.file("link.comp"))] {
            let ended = truing(&[
                "solve",
                case.path().to_str().unwrap(),
                "--errors",
                errors.to_str().unwrap(),
                "--compensation",
                other.to_str().unwrap(),
            ]);
            assert_eq!((ended.code, ended.stdout.as_str()), (2, ""));
            assert!(ended.one_message().contains("are the same file"), "{}", ended.stderr);
        }
        assert_eq!(names(out.path()), ["b.tab", "link.comp"]);
        assert_eq!(fs::read_to_string(out.file("b.tab")).unwrap(), "old");
    }
}

#[test]
fn an_index_is_none_of_its_pages() {
    let case = Case::example("frame-fit");
    let page = case.file("page.html");
    assert_eq!(solve_with_report(&case, &page).code, 0);
    let before = fs::read(&page).unwrap();
    let page_word = page.to_str().unwrap();
    let ended = truing(&["index", "--output", page_word, page_word]);
    assert_eq!(ended.code, 2);
    assert!(ended.one_message().contains("is an input of this run"), "{}", ended.stderr);
    assert_eq!(fs::read(&page).unwrap(), before);
    let index = case.file("index.html");
    assert_eq!(truing(&["index", "--output", index.to_str().unwrap(), page_word]).code, 0);
}

fn sha256(path: &Path) -> String {
    let digest = Sha256::digest(fs::read(path).unwrap());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn answers_say_what_they_rest_on() {
    let case = Case::example("tracker-lm");
    case.write(
        "provenance.toml",
        "title = \"Table of the big machine\"\nmachine = \"M 12\"\ninstrument = \"T 5\"\n\
         operator = \"N. N.\"\ndate = 2026-03-04\nserial = 7\n[temperatures]\nair_c = 20.3\nbed = 21\n",
    );
    for command in ["solve", "loop", "check"] {
        let answer = case.json(command);
        assert_eq!(answer["schema"], format!("truing/{command}/1"));
        assert_eq!(answer["program"]["name"], "truing");
        assert_eq!(answer["program"]["version"], env!("CARGO_PKG_VERSION"));
        let inputs = answer["inputs"].as_array().unwrap();
        let files: Vec<&str> = inputs.iter().map(|i| i["file"].as_str().unwrap()).collect();
        let mut sorted = files.clone();
        sorted.sort_unstable();
        assert_eq!(
            sorted,
            ["case.toml", "mounts.csv", "provenance.toml", "ranges.csv", "stations.csv"]
        );
        for (file, input) in files.iter().zip(inputs) {
            assert_eq!(input["sha256"], sha256(&case.file(file)), "{file}");
        }
        assert_eq!(
            answer["provenance"],
            serde_json::json!({
                "title": "Table of the big machine", "machine": "M 12", "instrument": "T 5",
                "operator": "N. N.", "date": "2026-03-04",
                "temperatures": { "air_c": 20.3, "bed": 21.0 }
            })
        );
    }
}

#[test]
fn meshes_and_carried_answers_are_inputs() {
    let case = Case::example("frame-fit");
    let answer = case.file("loop.json");
    fs::write(&answer, truing(&words(&["loop", "--json"], &[case.path()])).stdout).unwrap();
    let carried = Case::example("frame-fit");
    let ended = truing(
        &[
            &words(&["loop", "--json"], &[carried.path()])[..],
            &["--carry", answer.to_str().unwrap()],
        ]
        .concat(),
    );
    // The example may have nothing to carry: then that is what is said, of the same file.
    if ended.code == 0 {
        let answer_json: Value = serde_json::from_str(&ended.stdout).unwrap();
        let last = answer_json["inputs"].as_array().unwrap().last().unwrap().clone();
        assert_eq!(last["file"], answer.to_str().unwrap());
        assert_eq!(last["sha256"], sha256(&answer));
    } else {
        assert!(ended.one_message().contains("loop.json"), "{}", ended.stderr);
    }
    let overwrite = truing(&[
        "loop",
        carried.path().to_str().unwrap(),
        "--carry",
        answer.to_str().unwrap(),
        "--report",
        answer.to_str().unwrap(),
    ]);
    assert_eq!(overwrite.code, 2);
    assert!(overwrite.one_message().contains("is an input of this run"), "{}", overwrite.stderr);
}

#[test]
fn without_times_every_run_prints_the_same_bytes() {
    for kind in ["frame-fit", "tracker-lm", "pose-icp"] {
        let case = Case::example(kind);
        for command in ["solve", "loop", "check"] {
            let folder = case.path().to_str().unwrap();
            let run = |more: &[&str]| {
                let ended = truing(&[&[command, folder, "--json", "--no-timing"], more].concat());
                assert_eq!(ended.code, 0, "{}", ended.stderr);
                ended.stdout
            };
            let first = run(&["--threads", "1"]);
            assert!(!first.contains("\"timing\""));
            assert_eq!(first, run(&["--threads", "1"]), "{command} of {kind}");
            assert_eq!(first, run(&["--threads", "2"]), "{command} of {kind}");
        }
    }
}
