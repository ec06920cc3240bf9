//! Parts given as polynomials and meshes, and what the loop says of them.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use crate::command::Case;

type Vector = [f64; 3];

/// Pose of the part: d in mm, α, β and γ in degrees.
const POSE: [f64; 6] = [120.0, -35.0, 8.0, 0.4, -0.3, 1.5];
/// Points are written to 1e-6 mm; a lever arm of the part's size magnifies what tells the pose.
const WRITTEN_MM: f64 = 1e-4;
const WRITTEN_DEG: f64 = 1e-4;
const NOISE_MM: f64 = 1e-3;

/// `Rz(γ) Ry(β) Rx(α) v`.
fn turned([x, y, z]: Vector) -> Vector {
    let [(sa, ca), (sb, cb), (sg, cg)] =
        [POSE[3], POSE[4], POSE[5]].map(|deg: f64| deg.to_radians().sin_cos());
    let (y, z) = (ca * y - sa * z, sa * y + ca * z);
    let (x, z) = (cb * x + sb * z, cb * z - sb * x);
    [cg * x - sg * y, sg * x + cg * y, z]
}

/// `points.csv` of points of the part, each off by its share of noise.
fn points_csv(points: &[Vector], noise_mm: f64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let mut text = "point,x_mm,y_mm,z_mm,use\n".to_owned();
    for (i, point) in points.iter().enumerate() {
        let turned = turned(*point);
        let [x, y, z]: Vector = std::array::from_fn(|k| {
            let unit: f64 = StandardNormal.sample(&mut rng);
            turned[k] + POSE[k] + noise_mm * unit
        });
        let usage = if i % 5 == 4 { "check" } else { "fit" };
        text += &format!("P{i},{x:.6},{y:.6},{z:.6},{usage}\n");
    }
    text
}

/// A saddle with a slope, 80 mm across: nothing in it looks the same after a turn.
fn saddle(x: f64, y: f64) -> f64 {
    let (u, v) = (x / 50.0, y / 50.0);
    2.0 * u * u - 1.5 * v * v + 0.8 * u * v + 0.9 * u * u * u - 0.4 * u * v * v
}

const SADDLE: &str = "kind = \"pose-icp\"\n[surface]\nshape = \"polynomial\"\nunit_mm = 50.0\n\
    terms = [[2, 0, 2.0], [0, 2, -1.5], [1, 1, 0.8], [3, 0, 0.9], [1, 2, -0.4]]\n\
    [pose]\ninitial = { x_mm = 119.0, y_mm = -34.0, z_mm = 8.5 }\n";

fn touched_saddle(n: u32, noise_mm: f64) -> String {
    let at = |i: u32| {
        let radius = 40.0 * ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
        let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
        [radius * cos, radius * sin, saddle(radius * cos, radius * sin)]
    };
    points_csv(&(0..n).map(at).collect::<Vec<_>>(), noise_mm)
}

fn assert_pose(answer: &Value, tolerance: [f64; 2]) {
    let names = ["x_mm", "y_mm", "z_mm", "alpha_deg", "beta_deg", "gamma_deg"];
    for (k, name) in names.into_iter().enumerate() {
        let found = answer["estimates"]["pose"][name].as_f64().unwrap();
        assert!((found - POSE[k]).abs() < tolerance[k / 3], "{name}: {found}, not {}", POSE[k]);
    }
}

#[test]
fn a_polynomial_shows_all_six_components() {
    let points = touched_saddle(40, 0.0);
    let case = Case::new(&[("case.toml", SADDLE), ("points.csv", &points)]);
    assert_pose(&case.json("solve"), [WRITTEN_MM, WRITTEN_DEG]);
}

#[test]
fn a_rotation_that_is_stated_is_held() {
    let points = touched_saddle(40, 0.0);
    let stated = SADDLE.replace("[pose]\n", "[pose]\ngamma_deg = 1.5\n");
    let case = Case::new(&[("case.toml", &stated), ("points.csv", &points)]);
    let answer = case.json("solve");
    assert_pose(&answer, [WRITTEN_MM, WRITTEN_DEG]);
    assert_eq!(answer["estimates"]["pose"]["std_gamma_deg"].as_f64(), Some(0.0));
}

#[test]
fn the_loop_adds_nothing_to_a_sound_polynomial_and_finds_its_bad_touch() {
    let declared = format!("{SADDLE}[noise]\npoint_mm = {NOISE_MM}\n");
    let points = touched_saddle(60, NOISE_MM);
    let case = Case::new(&[("case.toml", &declared), ("points.csv", &points)]);
    let answer = case.json("loop");
    assert_eq!(answer["steps"].as_array().map(Vec::len), Some(0), "{}", answer["steps"]);
    assert_eq!(answer["verdict"], "nothing-missing");
    // P12 is a fitted one; its z reads 20 µm high, twenty times the noise.
    let lifted: String = points
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if cells[0] == "P12" {
                let z_mm: f64 = cells[3].parse().unwrap();
                cells[3] = format!("{:.6}", z_mm + 0.020);
            }
            cells.join(",") + "\n"
        })
        .collect();
    case.write("points.csv", lifted);
    let answer = case.json("loop");
    let steps = answer["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 1, "{steps:?}");
    assert_eq!((&steps[0]["effect"], &steps[0]["subject"]), (&"bad-point".into(), &"P12".into()));
    let height_mm = steps[0]["parameters"][0]["value"].as_f64().unwrap();
    assert!((height_mm - 0.020).abs() < 5.0 * NOISE_MM, "{height_mm}");
    assert_eq!(answer["verdict"], "explained");
}

/// A part without a vertex radius that is bent by 30 µm more at 40 mm than drawn. A shift along x
/// and a tilt imitate the x² of it, so the scale of y is a rival.
#[test]
fn the_loop_finds_that_a_polynomial_is_bent_more() {
    let declared = format!("{SADDLE}[noise]\npoint_mm = {NOISE_MM}\n");
    let bent = |i: u32| {
        let radius = 40.0 * ((f64::from(i) + 0.5) / 60.0).sqrt();
        let (sin, cos) = (2.399_963 * f64::from(i)).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        [x, y, saddle(x, y) + 0.030 * (radius / 40.0).powi(2)]
    };
    // In an order that does not run outwards: 37 and 60 have no common factor.
    let points = points_csv(&(0..60).map(|i| bent(i * 37 % 60)).collect::<Vec<_>>(), NOISE_MM);
    let case = Case::new(&[("case.toml", &declared), ("points.csv", &points)]);
    let answer = case.json("loop");
    let steps = answer["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 1, "{steps:?}");
    let rivals = steps[0]["indistinguishable_from"].as_array().unwrap();
    let names = [&[steps[0]["effect"].clone()], &rivals[..]].concat();
    assert!(names.contains(&"focus".into()), "{steps:#?}");
    assert!(!names.contains(&"drift".into()), "{steps:#?}");
    assert_eq!(answer["verdict"], "explained");
}

/// The saddle as a table of heights, 5 mm apart. A cubic spline repeats a cubic but near its ends,
/// where what is off falls to a quarter with every place: seven lie between the ends and the touches.
fn heights_of_the_saddle() -> String {
    let mut text = "x_mm,y_mm,z_mm\n".to_owned();
    for (i, j) in (0..31).flat_map(|i| (0..31).map(move |j| (i, j))) {
        let [x, y] = [i, j].map(|k| 5.0 * f64::from(k) - 75.0);
        text += &format!("{x},{y},{:.9}\n", saddle(x, y));
    }
    text
}

const GRID: &str = "kind = \"pose-icp\"\n[surface]\nshape = \"grid\"\n\
    [pose]\ninitial = { x_mm = 119.0, y_mm = -34.0, z_mm = 8.5 }\n";

#[test]
fn a_grid_of_heights_is_a_part_with_a_pose() {
    let points = touched_saddle(40, 0.0);
    let heights = heights_of_the_saddle();
    let case =
        Case::new(&[("case.toml", GRID), ("points.csv", &points), ("heights.csv", &heights)]);
    assert_pose(&case.json("solve"), [WRITTEN_MM, WRITTEN_DEG]);
    // Errors of form count at the farthest corner of the grid, 75 mm · √2 away.
    let checked = case.json("check");
    let trefoil = checked["observable"].as_array().unwrap().iter();
    let described: Vec<_> = trefoil.filter(|e| e["effect"] == "trefoil").collect();
    let text = described[0]["description"].as_str().unwrap();
    assert!(text.ends_with("height at 106.1 mm from the axis"), "{text}");
    for (shape, more) in [("sphere", "radius_mm = 50.0"), ("plane", "")] {
        let other = GRID.replace("\"grid\"", &format!("\"{shape}\"\n{more}"));
        case.write("case.toml", other);
        let message = case.message("solve", 2);
        let expected = format!("[surface] shape `{shape}`: looks the same from many sides");
        assert!(message.contains(&expected), "{message}");
    }
}

#[test]
fn a_tracker_has_no_axes_to_be_wrong() {
    let points = touched_saddle(40, NOISE_MM);
    let asked = |settings: &str| {
        let text = format!("{SADDLE}{settings}");
        let case = Case::new(&[("case.toml", &text), ("points.csv", &points)]);
        let checked = case.json("check");
        let names = checked["observable"].as_array().unwrap().iter();
        let of_axes = |e: &&Value| e["effect"] == "axis-scale" || e["effect"] == "squareness";
        names.filter(of_axes).count()
    };
    assert!(asked("") > 0);
    assert_eq!(asked("[machine]\naxes = false\n"), 0);
}

/// What fiducials say is not in question: a saddle is then not called a rotation.
#[test]
fn what_is_known_is_not_asked_for() {
    let points = touched_saddle(40, NOISE_MM);
    let names = |key: &str| -> Vec<String> {
        let pose = format!("[pose]\n{key} = [\"x\", \"gamma\"]\n");
        let text = SADDLE.replace("[pose]\n", &pose);
        let case = Case::new(&[("case.toml", &text), ("points.csv", &points)]);
        let checked = case.json("check");
        let all = ["observable", "not_observable"].map(|list| checked[list].as_array().unwrap());
        let name = |e: &Value| e["effect"].as_str().unwrap().to_owned();
        all.into_iter().flatten().map(name).collect()
    };
    for effect in ["rotation", "decentre"] {
        assert!(names("held").iter().any(|name| name == effect), "{effect}");
        assert!(names("known").iter().all(|name| name != effect), "{effect}");
    }
}

/// Three faces of a corner, each 40 mm × 40 mm, the normals towards +x, +y and +z.
fn corner_stl() -> String {
    let mut text = "solid corner\n".to_owned();
    for axis in 0..3 {
        let at = |u: f64, v: f64| -> Vector {
            let mut point = [0.0; 3];
            point[(axis + 1) % 3] = u;
            point[(axis + 2) % 3] = v;
            point
        };
        let [a, b, c, d] = [at(0.0, 0.0), at(40.0, 0.0), at(40.0, 40.0), at(0.0, 40.0)];
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid corner\n"
}

/// Ball centres over the three faces.
fn touched_corner(tip_mm: f64) -> Vec<Vector> {
    let mut centers = Vec::new();
    for axis in 0..3 {
        for [u, v] in [[8.0, 9.0], [31.0, 8.0], [30.0, 33.0], [9.0, 30.0], [20.0, 19.0]] {
            let mut center = [tip_mm; 3];
            center[(axis + 1) % 3] = u;
            center[(axis + 2) % 3] = v;
            centers.push(center);
        }
    }
    centers
}

const CORNER: &str = "kind = \"pose-icp\"\n[surface]\nshape = \"mesh\"\nfile = \"corner.stl\"\n\
    [pose]\ninitial = { x_mm = 119.5, y_mm = -34.6, z_mm = 8.3 }\n\
    [probe]\ntip_radius_mm = 2.0\n";

#[test]
fn a_mesh_is_a_part_touched_by_a_ball() {
    let points = points_csv(&touched_corner(2.0), 0.0);
    let case =
        Case::new(&[("case.toml", CORNER), ("points.csv", &points), ("corner.stl", &corner_stl())]);
    // Faces 40 mm across turn what was rounded to 1e-6 mm into some 1e-6 degrees.
    assert_pose(&case.json("solve"), [1e-5, 1e-5]);
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "nothing-missing", "{}", answer["steps"]);
}

/// No mesh says its unit: the case may, and a case that does not is told.
#[test]
fn a_mesh_in_inches_is_read_as_the_case_says_and_named_where_it_does_not() {
    let inches: String = corner_stl().replace("40", &format!("{}", 40.0 / 25.4));
    let points = points_csv(&touched_corner(2.0), 0.0);
    let said = CORNER.replace("corner.stl\"", "corner.stl\"\nunit_mm = 25.4");
    let case = Case::new(&[("case.toml", &said), ("points.csv", &points), ("corner.stl", &inches)]);
    assert_pose(&case.json("solve"), [1e-5, 1e-5]);
    case.write("case.toml", CORNER);
    let ended = case.run("loop");
    let answer = format!("{}{}", ended.stdout, ended.stderr);
    assert!(answer.contains("the mesh is in inches: 25.4"), "{answer}");
}

#[test]
fn a_mesh_of_one_face_leaves_three_motions_free() {
    let stl = corner_stl();
    // The first two triangles: the face towards +x.
    let end = stl.match_indices("endfacet\n").nth(1).unwrap().0;
    let face = format!("{}endfacet\nendsolid corner\n", &stl[..end]);
    let points = points_csv(&touched_corner(2.0)[..5], 0.0);
    let case = Case::new(&[("case.toml", CORNER), ("points.csv", &points), ("corner.stl", &face)]);
    let message = case.message("solve", 3);
    assert!(message.contains("points.csv"), "{message}");
}

/// A turn by half: a search that begins at none ends elsewhere, or nowhere.
#[test]
fn the_search_for_gamma_begins_where_the_case_says() {
    let turned: Vec<String> = touched_saddle(60, NOISE_MM)
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            // By 180° about z through the place that the part was touched at.
            if let (Ok(x), Ok(y)) = (cells[1].parse::<f64>(), cells[2].parse::<f64>()) {
                (cells[1], cells[2]) = (format!("{:.6}", 240.0 - x), format!("{:.6}", -70.0 - y));
            }
            cells.join(",") + "\n"
        })
        .collect();
    let begun = SADDLE.replace("z_mm = 8.5", "z_mm = 8.5, gamma_deg = 180.0");
    let case = Case::new(&[("case.toml", &begun), ("points.csv", &turned.concat())]);
    let answer = case.json("solve");
    let gamma = answer["estimates"]["pose"]["gamma_deg"].as_f64().unwrap();
    assert!((gamma.rem_euclid(360.0) - (POSE[5] + 180.0)).abs() < 0.1, "{gamma}");
    assert!(answer["residual"]["rms"].as_f64().unwrap() < 2.0 * NOISE_MM, "{answer}");
    case.write("case.toml", begun.replace("[pose]", "[pose]\ngamma_deg = 3.0"));
    assert!(case.message("solve", 2).contains("keep one"));
}
