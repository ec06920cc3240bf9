//! `truing register`: answers on clouds and meshes, and one message for whatever is unusable.

use std::fs;
use std::path::PathBuf;

use nalgebra::{Isometry3, Point3, Vector3};
use serde_json::Value;
use tempfile::TempDir;

use crate::command::{Ended, truing};

/// Files of one test.
struct Files {
    folder: TempDir,
}

impl Files {
    fn new() -> Self {
        Self { folder: TempDir::new().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> &Self {
        fs::write(self.path(name), content).unwrap();
        self
    }

    fn run(&self, source: &str, target: &str, more: &[&str]) -> Ended {
        let (source, target) = (self.path(source), self.path(target));
        let files = ["register", source.to_str().unwrap(), target.to_str().unwrap()];
        truing(&[&files[..], more].concat())
    }

    fn json(&self, source: &str, target: &str, more: &[&str]) -> Value {
        let ended = self.run(source, target, &[more, &["--json"]].concat());
        assert_eq!(ended.code, 0, "{}", ended.stderr);
        serde_json::from_str(&ended.stdout).unwrap()
    }

    fn message(&self, source: &str, target: &str, code: i32) -> String {
        let ended = self.run(source, target, &[]);
        assert_eq!((ended.code, ended.stdout.as_str()), (code, ""), "{}", ended.stderr);
        ended.one_message()
    }
}

/// Half a degree and a millimetre, target from source.
fn truth() -> Isometry3<f64> {
    Isometry3::new(Vector3::new(0.6, -0.45, 0.5), Vector3::new(3e-3, -4e-3, 5e-3))
}

/// A wavy face of `n × n` points, 40 mm across.
fn face(n: u32) -> Vec<Point3<f64>> {
    let step = 40.0 / f64::from(n - 1);
    let at = |k: u32| step * f64::from(k) - 20.0;
    let height = |x: f64, y: f64| 2.0 * (x / 5.0).sin() * (y / 6.0).cos() + x * y / 80.0;
    (0..n * n)
        .map(|k| (at(k % n), at(k / n)))
        .map(|(x, y)| Point3::new(x, y, height(x, y)))
        .collect()
}

fn corners_of_squares(n: u32) -> impl Iterator<Item = [u32; 3]> {
    let squares = (0..n - 1).flat_map(move |i| (0..n - 1).map(move |j| i * n + j));
    squares.flat_map(move |k| [[k, k + 1, k + n + 1], [k, k + n + 1, k + n]])
}

/// Points inside the face, where the source's frame has them.
fn source() -> Vec<Point3<f64>> {
    let inside = |p: &Point3<f64>| p.x.abs() < 17.0 && p.y.abs() < 17.0;
    face(60).into_iter().filter(inside).map(|p| truth().inverse() * p).collect()
}

fn xyz(points: &[Point3<f64>]) -> String {
    points.iter().map(|p| format!("{} {} {}\n", p.x, p.y, p.z)).collect()
}

#[test]
fn without_a_start_one_is_found_on_a_cloud_and_on_a_mesh() {
    // The face alone is the same after half a turn about y.
    let lopsided = |p: Point3<f64>| Point3::new(p.x, p.y, p.z + p.x * p.x / 60.0);
    let target: Vec<_> = face(60).into_iter().map(lopsided).collect();
    let turned = Isometry3::new(Vector3::new(300.0, -80.0, 40.0), Vector3::new(1.1, -2.0, 0.7));
    let inside = |p: &&Point3<f64>| p.x.abs() < 17.0 && p.y.abs() < 17.0;
    let away: Vec<_> = target.iter().filter(inside).map(|p| turned * p).collect();
    let vertices: String = target.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).collect();
    let faces: String = corners_of_squares(60)
        .map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1))
        .collect();
    let files = Files::new();
    files.write("source.xyz", xyz(&away)).write("target.xyz", xyz(&target));
    files.write("target.obj", vertices + &faces);
    let expected = turned.inverse().to_homogeneous();
    for target in ["target.xyz", "target.obj"] {
        let found = files.json("source.xyz", target, &["--global"]);
        for row in 0..3 {
            for column in 0..4 {
                let number = found["matrix"][row][column].as_f64().unwrap();
                // The points are those of the target: the pose is exact but for the stop at 1e-6 mm,
                // which 300 mm away from the part's middle is 2e-5.
                assert!((number - expected[(row, column)]).abs() < 1e-4, "{target}: {found}");
            }
        }
    }
    let ended = files.run("source.xyz", "target.xyz", &["--global", "--hold", "x"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
}

fn ascii_ply(points: &[Point3<f64>], faces: &[[u32; 3]]) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty \
         double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        points.len(),
        faces.len()
    );
    text += &xyz(points);
    text += &faces.iter().map(|f| format!("3 {} {} {}\n", f[0], f[1], f[2])).collect::<String>();
    text
}

fn binary_stl(points: &[Point3<f64>], faces: &[[u32; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(u32::try_from(faces.len()).unwrap().to_le_bytes());
    for face in faces {
        bytes.extend([0; 12]);
        for &corner in face {
            #[expect(clippy::cast_possible_truncation, reason = "what the format holds")]
            bytes.extend(points[corner as usize].iter().flat_map(|&v| (v as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(points: &[Point3<f64>], faces: &[[u32; 3]]) -> String {
    let vertices = points.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = faces.iter().map(|f| format!("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1));
    vertices.chain(faces).collect()
}

/// How far the answer is from the truth over the face, mm.
fn miss_mm(answer: &Value) -> f64 {
    let entry = |r: usize, c: usize| answer["matrix"][r][c].as_f64().unwrap();
    let moved = |p: &Point3<f64>| {
        Point3::from(Vector3::from_fn(|r, _| {
            entry(r, 0) * p.x + entry(r, 1) * p.y + entry(r, 2) * p.z + entry(r, 3)
        }))
    };
    source().iter().map(|p| (moved(p) - truth() * p).norm()).fold(0.0, f64::max)
}

#[test]
fn clouds_and_meshes_of_every_format_agree() {
    let files = Files::new();
    let faces: Vec<_> = corners_of_squares(200).collect();
    let fine = face(200);
    files.write("source.xyz", xyz(&source())).write("target.xyz", xyz(&fine));
    files.write("target.ply", ascii_ply(&fine, &faces)).write("cloud.ply", ascii_ply(&fine, &[]));
    files.write("target.stl", binary_stl(&fine, &faces)).write("target.obj", obj(&fine, &faces));
    // Triangles 0.2 mm wide leave the face by κs²/8 with κ below 2/25 + 1/80: 0.5 µm; a plane
    // through twelve neighbours 0.4 mm away by four times that; single precision adds 1 µm.
    for (target, bound_mm) in [
        ("target.xyz", 0.01),
        ("cloud.ply", 0.01),
        ("target.ply", 0.003),
        ("target.stl", 0.003),
        ("target.obj", 0.003),
    ] {
        let answer = files.json("source.xyz", target, &[]);
        let miss = miss_mm(&answer);
        assert!(miss < bound_mm, "{target} misses by {miss} mm");
        assert_eq!(answer["converged"], true);
        assert_eq!(answer["weak_directions"], serde_json::json!([]));
        for time in ["read_s", "build_s", "align_s"] {
            assert!(answer["timing"][time].as_f64().unwrap() > 0.0);
        }
        assert!(answer["rms_mm"].as_f64().unwrap() < bound_mm);
        assert!(answer["iterations"].as_u64().unwrap() > 1);
    }
}

#[test]
fn pose_and_matrix_say_the_same() {
    let files = Files::new();
    files.write("source.csv", format!("x_mm,y_mm,z_mm\n{}", xyz(&source()).replace(' ', ",")));
    files.write("target.xyz", xyz(&face(200)));
    let answer = files.json("source.csv", "target.xyz", &["--method", "symmetric"]);
    let value = |name: &str| answer["pose"][name].as_f64().unwrap();
    let angles = ["alpha_deg", "beta_deg", "gamma_deg"].map(|name| value(name).to_radians());
    let [alpha, beta, gamma] = angles.map(f64::sin_cos);
    // Entries of Rz(γ) Ry(β) Rx(α), written out.
    let expected = [
        (0, 0, gamma.1 * beta.1),
        (1, 0, gamma.0 * beta.1),
        (2, 0, -beta.0),
        (2, 1, beta.1 * alpha.0),
        (2, 2, beta.1 * alpha.1),
        (0, 3, value("x_mm")),
        (1, 3, value("y_mm")),
        (2, 3, value("z_mm")),
    ];
    for (row, column, expected) in expected {
        let entry = answer["matrix"][row][column].as_f64().unwrap();
        // A few roundings of numbers near 1.
        assert!((entry - expected).abs() < 1e-14, "({row}, {column}): {entry} {expected}");
    }
    for name in ["x_mm", "y_mm", "z_mm", "alpha_deg", "beta_deg", "gamma_deg"] {
        assert!(value(&format!("std_{name}")) > 0.0);
    }
}

#[test]
fn a_start_is_taken_and_a_held_component_stays() {
    let files = Files::new();
    files.write("source.xyz", xyz(&source())).write("target.xyz", xyz(&face(120)));
    let more = ["--initial", "0.5,-0.4,0.4 mm, 0,0,0.25 deg", "--hold", "x,gamma"];
    let answer = files.json("source.xyz", "target.xyz", &more);
    assert!((answer["pose"]["gamma_deg"].as_f64().unwrap() - 0.25).abs() < 0.01);
    let refused = files.run("source.xyz", "target.xyz", &["--initial", "1,2,3"]);
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("six numbers x,y,z,alpha,beta,gamma"), "{}", refused.stderr);
}

#[test]
fn threads_change_no_digit() {
    let files = Files::new();
    files.write("source.xyz", xyz(&source())).write("target.xyz", xyz(&face(200)));
    let [one, two] = ["1", "2"].map(|threads| {
        let answer = files.json("source.xyz", "target.xyz", &["--threads", threads]);
        (answer["matrix"].to_string(), answer["pose"].to_string(), answer["rms_mm"].to_string())
    });
    assert_eq!(one, two);
}

#[test]
fn what_the_shape_leaves_free_is_named_with_exit_code_3() {
    let files = Files::new();
    let flat: Vec<_> = face(30).into_iter().map(|p| Point3::new(p.x, p.y, 0.0)).collect();
    files.write("flat.xyz", xyz(&flat)).write("source.xyz", xyz(&flat[200..600]));
    let message = files.message("source.xyz", "flat.xyz", 3);
    assert!(message.contains("leave the") && message.contains("free"), "{message}");
    files.write("few.xyz", xyz(&face(30)[..5])).write("face.xyz", xyz(&face(30)));
    let message = files.message("few.xyz", "face.xyz", 3);
    assert!(message.contains("5 points of the source cannot determine 6 unknowns"), "{message}");
}

#[test]
fn one_that_does_not_come_to_rest_says_so() {
    let files = Files::new();
    files.write("source.xyz", xyz(&source())).write("target.xyz", xyz(&face(100)));
    let more = ["--method", "point-to-point", "--max-iterations", "3", "--json"];
    let ended = files.run("source.xyz", "target.xyz", &more);
    assert_eq!(ended.code, 3);
    let answer: Value = serde_json::from_str(&ended.stdout).unwrap();
    assert_eq!(answer["converged"], false);
    assert!(ended.one_message().contains("not converged after 3 passes"), "{}", ended.stderr);
}

#[test]
fn meshes_with_defects_are_refused() {
    let files = Files::new();
    let points = face(20);
    let mut faces: Vec<_> = corners_of_squares(20).collect();
    files.write("source.xyz", xyz(&source()));
    let hole = faces.remove(371);
    files.write("hole.ply", ascii_ply(&points, &faces));
    let message = files.message("source.xyz", "hole.ply", 2);
    assert!(message.contains("hole.ply") && message.contains("1 holes"), "{message}");
    let answer = files.json("source.xyz", "hole.ply", &["--skip-holes"]);
    assert!(answer["used"].as_u64() < answer["points"].as_u64());
    faces.push(hole);
    faces.push([3, 4, 4]);
    files.write("flat.stl", binary_stl(&points, &faces));
    let message = files.message("source.xyz", "flat.stl", 2);
    assert!(message.contains("no area") && message.contains("face 722"), "{message}");
}

#[test]
fn unusable_files_give_one_message_each() {
    let files = Files::new();
    let good = xyz(&source());
    files.write("good.xyz", &good);
    let mut endless = binary_stl(&face(5), &[[0, 1, 6]]);
    endless[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let vast = "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\nproperty float \
                x\nproperty float y\nproperty float z\nend_header\n";
    let vast_list = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n\
                     property float y\nproperty float z\nelement face 1\nproperty list uint uint \
                     vertex_indices\nend_header\n0123456789ab\u{7f}\u{7f}\u{7f}\u{7f}";
    let cases: [(&str, &[u8], &str); 18] = [
        ("a.stl", b"", "0 bytes"),
        ("a.ply", b"", "0 bytes"),
        ("b.stl", b"solid nothing\nendsolid nothing\n", "no triangles"),
        ("c.stl", b"\x00\x01\x02", "STL"),
        ("d.stl", &endless, "promises 4294967295"),
        ("e.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0", "STL"),
        ("f.ply", b"plx\n", "header"),
        ("g.ply", vast.as_bytes(), "promises 99999999999"),
        ("h.ply", vast_list.as_bytes(), "PLY"),
        ("i.ply", ascii_ply(&face(3), &[[0, 1, 99]]).leak().as_bytes(), "face 0"),
        ("j.ply", ascii_ply(&[], &[]).leak().as_bytes(), "no vertices"),
        ("k.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 9\n", "OBJ"),
        ("l.obj", b"# nothing\n", "no faces"),
        ("m.xyz", b"1 2 3\n4 nan 6\n", "line 2, column 2"),
        ("n.xyz", b"1 2 3\n4 5\n", "line 2: expected 3 cells"),
        ("o.csv", b"x,y\n1,2\n", "line 2: expected x, y, z"),
        ("p.csv", b"x,y,z\n", "no points"),
        ("q.dat", b"1 2 3\n", "unknown ending `dat`"),
    ];
    for (name, content, expected) in cases {
        files.write(name, content);
        for (source, target) in [(name, "good.xyz"), ("good.xyz", name)] {
            let message = files.message(source, target, 2);
            assert!(message.contains(name) && message.contains(expected), "{name}: {message}");
        }
    }
    let message = files.message("good.xyz", "absent.ply", 2);
    assert!(message.contains("absent.ply: cannot be read"), "{message}");
}
