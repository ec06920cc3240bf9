//! Whatever is given to be read: only ordinary files of a sane size, and only where they belong.

use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{Case, truing};

/// A face of a box as STL: a mesh that a case may name.
const MESH: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex -50 -50 0\nvertex 50 -50 0\n\
    vertex 50 50 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex -50 -50 0\n\
    vertex 50 50 0\nvertex -50 50 0\nendloop\nendfacet\nendsolid a\n";

fn on_mesh(file: &str) -> Case {
    let toml = format!(
        "kind = \"probe-comp\"\n[surface]\nshape = \"mesh\"\nfile = \"{file}\"\n\
         [probe]\ntip_radius_mm = 1.0\nside = \"+z\"\n[noise]\npoint_mm = 0.001\n"
    );
    let touches = "touch,x_mm,y_mm,z_mm\nA,0,10,1\nB,20,-10,1.001\nC,-20,5,0.999\nD,11,21,1.0\n";
    Case::new(&[("case.toml", &toml), ("touches.csv", touches)])
}

#[cfg(unix)]
mod on_unix {
    use std::os::unix::fs::symlink;
    use std::process::Command;

    use super::*;

    fn pipe(path: &Path) {
        assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
    }

    /// Every command that reads a file, given `bad` in the place of each.
    fn readers(case: &Case, bad: &Path) -> Vec<Vec<String>> {
        let word = |path: &Path| path.to_str().unwrap().to_owned();
        let (folder, bad) = (word(case.path()), word(bad));
        let index = word(&case.file("index.html"));
        [
            vec!["register", &bad, &word(&case.file("face.stl"))],
            vec!["register", &word(&case.file("face.stl")), &bad],
            vec!["correct", &folder, &bad],
            vec!["loop", &folder, "--carry", &bad],
            vec!["index", "--output", &index, &bad],
            vec!["import", "probe-log", &bad],
        ]
        .into_iter()
        .map(|words| words.into_iter().map(str::to_owned).collect())
        .collect()
    }

    fn refused(arguments: &[String], why: &str) {
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let ended = truing(&words);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{words:?}");
        let message = ended.one_message();
        assert!(message.contains(why), "{words:?}: {message}");
    }

    #[test]
    fn pipes_devices_and_folders_are_not_read() {
        let case = Case::example("pose-icp");
        case.write("face.stl", MESH);
        pipe(&case.file("pipe.stl"));
        fs::create_dir(case.file("folder.stl")).unwrap();
        symlink("/dev/zero", case.file("zero.stl")).unwrap();
        for (file, why) in [
            ("pipe.stl", "expected an ordinary file, found a pipe"),
            ("folder.stl", "expected an ordinary file, found a folder"),
            ("zero.stl", "expected an ordinary file, found a device"),
        ] {
            for arguments in readers(&case, &case.file(file)) {
                refused(&arguments, why);
            }
        }
    }

    #[test]
    fn files_of_the_case_are_guarded_alike() {
        for (table, why) in [("touches.csv", "a pipe"), ("part.stl", "a pipe")] {
            let case = on_mesh("part.stl");
            case.write("part.stl", MESH);
            assert_eq!(case.run("solve").code, 0, "{}", case.run("solve").stderr);
            fs::remove_file(case.file(table)).unwrap();
            pipe(&case.file(table));
            let message = case.message("solve", 2);
            assert!(
                message.contains(&format!("expected an ordinary file, found {why}")),
                "{message}"
            );
        }
    }

    /// A hole of five gigabytes takes no place on the disk.
    #[test]
    fn files_of_any_size_are_not_read() {
        let case = Case::example("pose-icp");
        case.write("face.stl", MESH);
        let huge = case.file("huge.stl");
        fs::File::create(&huge).unwrap().set_len(5 << 30).unwrap();
        for arguments in readers(&case, &huge) {
            refused(&arguments, "the file has 5368709120 bytes; at most");
        }
    }

    #[test]
    fn the_ending_is_looked_at_before_the_file() {
        let case = Case::new(&[("face.stl", MESH)]);
        pipe(&case.file("cloud.step"));
        let ended = truing(&[
            "register",
            case.file("cloud.step").to_str().unwrap(),
            case.file("face.stl").to_str().unwrap(),
        ]);
        assert_eq!(ended.code, 2);
        assert!(ended.one_message().contains("unknown ending `step`"), "{}", ended.stderr);
    }

    #[test]
    fn a_case_names_files_of_its_own() {
        let outside = Case::new(&[("part.stl", MESH)]);
        let part: PathBuf = outside.file("part.stl");
        let name = outside.path().file_name().unwrap().to_str().unwrap().to_owned();
        let by_link = on_mesh("link.stl");
        symlink(&part, by_link.file("link.stl")).unwrap();
        let cases =
            [on_mesh(part.to_str().unwrap()), on_mesh(&format!("../{name}/part.stl")), by_link];
        for case in cases {
            let message = case.message("solve", 2);
            assert!(message.contains("case.toml, line 3"), "{message}");
            assert!(message.contains("is outside of the case folder"), "{message}");
            let ended = truing(&["solve", case.path().to_str().unwrap(), "--allow-outside"]);
            assert_eq!(ended.code, 0, "{}", ended.stderr);
        }
        let absent = on_mesh("../nowhere.stl").message("solve", 2);
        assert!(absent.contains("is outside of the case folder"), "{absent}");
        // Inside, by whatever way.
        let case = on_mesh("sub/../part.stl");
        case.write("part.stl", MESH);
        fs::create_dir(case.file("sub")).unwrap();
        assert_eq!(case.run("solve").code, 0, "{}", case.run("solve").stderr);
    }
}

/// Numbers that no machine has, in the place of each number of a command line.
#[test]
fn absurd_numbers_of_the_command_line_are_refused() {
    let case = Case::new(&[("face.stl", MESH)]);
    let face = case.file("face.stl");
    let face = face.to_str().unwrap();
    for absurd in ["nan", "inf", "-inf", "1e308", "-1", "x", ""] {
        for option in ["--keep", "--max-distance", "--tolerance", "--max-iterations"] {
            let ended = truing(&["register", face, face, &format!("{option}={absurd}")]);
            assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{option} {absurd}");
        }
        for option in ["--contact", "--interval", "--delay", "--lag", "--settling"] {
            let ended = truing(&["design", "force", &format!("{option}={absurd}")]);
            assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "{option} {absurd}");
        }
        let both = [format!("--mass={absurd}"), "--damping=1".to_owned()];
        let ended = truing(&["design", "force", &both[0], &both[1]]);
        assert_eq!((ended.code, ended.stdout.as_str()), (2, ""), "--mass {absurd}");
        let ended = truing(&["import", "probe-log", face, &format!("--tip-radius={absurd}")]);
        assert_eq!(ended.code, 2, "--tip-radius {absurd}");
    }
}
