//! Small sessions with a mirror in which every effect on a pose is accepted at least once.

use crate::handback::folder::with_column;
use crate::kinds::pose_icp::mirror::{Flaw, Mirror, simulate};

/// Ids with subjects that have a formula of their own; `focus` and `rotation` take parts that are
/// not surfaces of revolution.
pub(crate) const EFFECTS: &[&str] = &[
    "height",
    "decentre",
    "tilt",
    "tip-radius",
    "vertex-radius",
    "conic",
    "astigmatism",
    "coma",
    "trefoil",
    "patch",
    "axis-scale [x]",
    "axis-scale [y]",
    "squareness",
    "reversal [x, by approach]",
    "reversal [y, by touch]",
    "reversal [by approach]",
    "reversal [x, by direction]",
    "drift",
    "drift [settling]",
    "session-shift [sideways, from P41 on]",
    "temperature",
];

type Files = Vec<(&'static str, String)>;

/// Cases by name.
pub(crate) fn scenes() -> Vec<(&'static str, Files)> {
    let base = Mirror { n_points: 64, ..Mirror::new(91) };
    let with = |flaw: Flaw| Mirror { flaw, ..base.clone() };
    // Steep enough for a larger ball to be something else than a shorter vertex radius or another
    // height.
    let steep = Mirror { radius_mm: 45.0, ..base.clone() };
    let skew = Mirror {
        conic: 1.0,
        radius_mm: 80.0,
        flaw: Flaw::Squareness([1e-3, 0.0, 0.0]),
        ..base.clone()
    };
    // Declared at its true pose, but for what is off: mm and degrees.
    let held = |flaw: Flaw, names: &str, off: [f64; 4]| {
        let scene = Mirror { flaw, ..steep.clone() };
        let [x, y, z, alpha, beta] = simulate(&scene).pose;
        let initial = format!(
            "initial = {{ x_mm = {:.4}, y_mm = {:.4}, z_mm = {:.4}, alpha_deg = {:.5}, beta_deg = \
             {beta:.5} }}",
            x + off[0],
            y + off[1],
            z + off[2],
            alpha + off[3],
        );
        files(&scene, &format!("\n[pose]\nheld = [{names}]\n{initial}\n"))
    };
    vec![
        ("tip", held(Flaw::Tip(0.05), "\"z\"", [0.0; 4])),
        ("vertex-radius", files(&with(Flaw::VertexRadius(0.12)), "")),
        ("conic", files(&with(Flaw::Conic(0.05)), "")),
        ("astigmatism", files(&with(Flaw::Astigmatism([0.012, -0.004])), "")),
        ("coma", files(&with(Flaw::Coma([0.010, 0.006])), "")),
        ("trefoil", files(&with(Flaw::Trefoil([0.008, 0.009])), "")),
        ("patch", files(&with(Flaw::Bump(-0.02, 15.0)), "")),
        ("scale-x", files(&with(Flaw::MachineScale([4e-4, 0.0, 0.0])), "")),
        ("scale-y", files(&with(Flaw::MachineScale([0.0, -9e-4, 0.0])), "")),
        // On a paraboloid it is astigmatism.
        ("squareness", files(&skew, "")),
        ("play", files(&Mirror { flaw: Flaw::Play(0, 8e-3), seed: 95, ..steep.clone() }, "")),
        (
            "play-of-both",
            files(
                &Mirror {
                    flaw: Flaw::Play(0, 15e-3),
                    also: Flaw::Play(1, -12e-3),
                    ..steep.clone()
                },
                "",
            ),
        ),
        ("play-between", files(&Mirror { flaw: Flaw::PlayBetween(1, -8e-3), ..steep.clone() }, "")),
        ("to-and-fro", to_and_fro(files(&steep, ""))),
        ("drift", files(&with(Flaw::Drift(0.012)), "")),
        ("settling", files(&with(Flaw::Settling(0.02, 0.08)), "")),
        ("clamped-anew", files(&with(Flaw::Clamped(40, [0.3, -0.2, 0.1])), "")),
        ("temperature", files(&Mirror { record_air: true, ..with(Flaw::Growth(0.012)) }, "")),
        ("bad-point", files(&with(Flaw::BadPoint(4, 0.02)), "")),
        ("height", held(Flaw::None, "\"z\"", [0.0, 0.0, 0.02, 0.0])),
        ("decentre", held(Flaw::None, "\"x\", \"y\"", [0.03, -0.02, 0.0, 0.0])),
        ("tilt", held(Flaw::None, "\"alpha\", \"beta\"", [0.0, 0.0, 0.0, 0.02])),
    ]
}

/// The same with readings of x that are off by 12 µm one way and by as much the other, in turns of five, and a column that
/// says which.
fn to_and_fro(mut files: Files) -> Files {
    const HALF_MM: f64 = 0.012;
    let table = files.iter_mut().find(|(name, _)| *name == "points.csv");
    let (_, text) = table.expect("a table of touches");
    let way = |index: usize| if index % 10 < 5 { 1.0 } else { -1.0 };
    let x = text.lines().next().and_then(|row| row.split(',').position(|name| name == "x_mm"));
    let x = x.expect("a column");
    let moved = text.lines().enumerate().map(|(line, row)| {
        let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
        if let (Some(index), Ok(read)) = (line.checked_sub(1), cells[x].parse::<f64>()) {
            cells[x] = format!("{:.6}", read + way(index) * HALF_MM);
        }
        cells.join(",")
    });
    let moved: Vec<String> = moved.collect();
    let directions = (1..moved.len()).map(|line| way(line - 1).to_string());
    *text = with_column(&moved.join("\n"), "direction", directions);
    files
}

fn files(mirror: &Mirror, more: &str) -> Files {
    let touched = simulate(mirror);
    let mut files =
        vec![("case.toml", touched.case_toml + more), ("points.csv", touched.points_csv)];
    files.extend(touched.edge_csv.map(|text| ("edge.csv", text)));
    files
}
