//! Small sessions with a mirror in which every effect on a pose is accepted at least once.

use crate::generators::mirror::{Flaw, Mirror, simulate};

/// Ids with subjects that have a formula of their own; `focus` and `rotation` take parts that are
/// not surfaces of revolution.
pub(super) const EFFECTS: &[&str] = &[
    "height",
    "tilt",
    "vertex-radius",
    "conic",
    "astigmatism",
    "coma",
    "trefoil",
    "axis-scale [x]",
    "axis-scale [y]",
    "squareness",
    "drift",
    "temperature",
];

type Files = Vec<(&'static str, String)>;

/// Cases by name.
pub(super) fn scenes() -> Vec<(&'static str, Files)> {
    let base = Mirror { n_points: 64, ..Mirror::new(91) };
    let with = |flaw: Flaw| Mirror { flaw, ..base.clone() };
    let near_sphere = Mirror { radius_mm: 60.0, conic: -0.02, diameter_mm: 80.0, ..base.clone() };
    let held = |names: &str| {
        let [x, y, z] = near(&base);
        let initial = format!("initial = {{ x_mm = {x:.1}, y_mm = {y:.1}, z_mm = {z:.1} }}");
        files(&base, &format!("\n[pose]\nheld = [{names}]\n{initial}\n"))
    };
    vec![
        ("tip", files(&Mirror { flaw: Flaw::Tip(0.02), ..near_sphere }, "")),
        ("vertex-radius", files(&with(Flaw::VertexRadius(0.12)), "")),
        ("conic", files(&with(Flaw::Conic(0.05)), "")),
        ("astigmatism", files(&with(Flaw::Astigmatism([0.012, -0.004])), "")),
        ("coma", files(&with(Flaw::Coma([0.010, 0.006])), "")),
        ("trefoil", files(&with(Flaw::Trefoil([0.008, 0.009])), "")),
        ("scale-x", files(&with(Flaw::MachineScale([4e-4, 0.0, 0.0])), "")),
        ("scale-y", files(&with(Flaw::MachineScale([0.0, -4e-4, 0.0])), "")),
        ("squareness", files(&with(Flaw::Squareness([3e-4, 0.0, 0.0])), "")),
        ("drift", files(&with(Flaw::Drift(0.012)), "")),
        ("temperature", files(&Mirror { record_air: true, ..with(Flaw::Growth(0.012)) }, "")),
        ("bad-point", files(&with(Flaw::BadPoint(4, 0.02)), "")),
        ("height", held("\"z\"")),
        ("decentre", held("\"x\", \"y\"")),
        ("tilt", held("\"alpha\", \"beta\"")),
    ]
}

/// Where the part's vertex is, to a millimetre: the last touch of the side's table is above it.
fn near(mirror: &Mirror) -> [f64; 3] {
    let edge_csv = simulate(mirror).edge_csv.expect("the side is touched");
    let last = edge_csv.lines().last().expect("five touches");
    let cells: Vec<&str> = last.split(',').collect();
    let center = [1, 2, 3].map(|k| cells[k].parse::<f64>().expect("a coordinate"));
    [center[0].round(), center[1].round(), (center[2] - mirror.tip_mm).round()]
}

fn files(mirror: &Mirror, more: &str) -> Files {
    let touched = simulate(mirror);
    let mut files =
        vec![("case.toml", touched.case_toml + more), ("points.csv", touched.points_csv)];
    files.extend(touched.edge_csv.map(|text| ("edge.csv", text)));
    files
}
