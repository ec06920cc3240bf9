//! The page of what registration beside peers gave.

use std::fmt::Write as _;

use super::contender::median;
use super::icp_contest::{Contest, Row};

/// Error beyond which an answer is none, whatever its program says.
const WRONG_UM: f64 = 100.0;

/// Name under which the project's own program takes part.
const OURS: &str = "pose-icp";

const HEAD: &str = "# Registration beside packaged peers

Written by `cargo xtask bench --peers clouds`. The problems are those of `xtask/peers/icp/problems.py`:
100k and 1m are a face of 200 × 200 mm with as many points in source and target and 2 µm of noise; scan
has 20 µm of noise on both sides, the target without x > 25 mm and the source without x < −75 mm, so that
half of the face is in both. Programs take turns (A B A B), each figure is the median of its runs, the first
of every turn left out. A shared machine disturbs wall times; *CPU* is the processor time of all threads, which it
disturbs less. Search tree and registration together; *tree* is the search tree apart, in wall time, where a program
can build it apart. Ratios are to pose-icp on as many threads. Error: the largest of any source point
against the pose that made the problem.

Every peer runs as it does best here. Pairs further apart than 5 mm do not count for peers, on scan 1 mm: with 5 mm there
Open3D and small_gicp go to and fro between sets of pairs for 100 iterations and end at 21.5 µm, with 2 mm at 16 to 17. pose-icp is told no distance. Open3D stops at its
own criterion of 1e-6. small_gicp is compiled here for this machine, once more with a residual that is the dot product of normal and offset, by Gauss-Newton,
until a step is below 1e-4 mm (scan: 1e-3 mm, less goes on among noise without getting nearer); as packaged, whose factor multiplies entry by entry, it is shown on 100k alone.
threecrate computes in single precision. Whoever runs the bench puts a program of the same arguments in the place of ours by `TRUING_PEER_SMALL_GICP`,
`TRUING_PEER_POSE_ICP` (its neighbours `threecrate_plane`, `ours_basin` and `ours_poses` with it) or `TRUING_PEER_PYTHON`.

";

/// The page.
pub(super) fn page(contest: &Contest) -> String {
    let parts = [speeds, drawings, queries, basins, poses].map(|part| part(contest));
    format!("{HEAD}{}", parts.concat())
}

fn speeds(contest: &Contest) -> String {
    let mut page = String::from(
        "| problem | threads | program | wall ms | ratio | CPU ms | ratio | tree ms | error µm |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for row in &contest.rows {
        let Row { problem, threads, name, usual } = row;
        let own = ours(contest, row);
        let ratio = |figure: fn(&Row) -> f64| own.map_or(f64::NAN, |o| figure(row) / figure(o));
        let is_answer = usual.error_um < WRONG_UM && usual.converged.unwrap_or(true);
        let remark = if is_answer { "" } else { ", not converged" };
        let tree = usual.build_s.map_or_else(|| "–".to_owned(), |s| format!("{:.1}", 1e3 * s));
        let _ = writeln!(
            page,
            "| {problem} | {threads} | {name} | {:.1} | {:.1} | {:.1} | {:.1} | {tree} | {:.2}{remark} |",
            1e3 * usual.wall_s,
            ratio(|r| r.usual.wall_s),
            1e3 * usual.cpu_s,
            ratio(|r| r.usual.cpu_s),
            usual.error_um,
        );
    }
    page
}

fn ours<'a>(contest: &'a Contest, row: &Row) -> Option<&'a Row> {
    contest.rows.iter().find(|o| (o.problem, o.threads, o.name) == (row.problem, row.threads, OURS))
}

fn drawings(contest: &Contest) -> String {
    let mut page = String::from(
        "\n## The error over many scans\n\nThe error of one scan is one of chance. The same with other drawings of points \
         and noise; µm.\n\n| program | scans | root mean square | median | largest |\n|---|---|---|---|---|\n",
    );
    for (name, errors_um) in &contest.drawings {
        #[expect(clippy::cast_precision_loss, reason = "a dozen")]
        let mean_square = errors_um.iter().map(|e| e * e).sum::<f64>() / errors_um.len() as f64;
        let largest = errors_um.iter().copied().fold(0.0, f64::max);
        let _ = writeln!(
            page,
            "| {name} | {} | {:.1} | {:.1} | {largest:.1} |",
            errors_um.len(),
            mean_square.sqrt(),
            median(errors_um.clone()),
        );
    }
    page
}

fn queries(contest: &Contest) -> String {
    let mut page = String::from(
        "\n## A query\n\nProcessor time of finding the nearest target point of every source point, in no \
         order, sorting the queries included. Beside it, the time of merely reading each query and \
         its answer in the same order: what memory alone asks of any exact search that takes \
         queries as they come.\n\n| problem | threads | ns a query | ns to read |\n|---|---|---|---|\n",
    );
    for Row { problem, threads, usual, .. } in &contest.rows {
        if let (Some(query_ns), Some(floor_ns)) = (usual.query_ns, usual.floor_ns) {
            let _ = writeln!(page, "| {problem} | {threads} | {query_ns:.0} | {floor_ns:.0} |");
        }
    }
    page
}

fn basins(contest: &Contest) -> String {
    let mut page = String::from(
        "\n## From how far off\n\n4000 points on 40 000, 200 mm across, no limit on the \
         distance. Starts that led to within 50 µm, in %, by angle and shift. Where the residuals are not those of a \
         surface on a surface, pose-icp tries other starts about the one given; its `find_start` needs none.\n",
    );
    for (name, cells) in &contest.basins {
        let mut shifts: Vec<f64> = cells.iter().map(|cell| cell.shift_mm).collect();
        shifts.truncate(cells.partition_point(|c| c.angle_deg <= cells[0].angle_deg));
        let _ = write!(page, "\n| {name} |");
        for shift in &shifts {
            let _ = write!(page, " {shift} mm |");
        }
        let _ = write!(page, "\n|---|{}", "---|".repeat(shifts.len()));
        for row in cells.chunk_by(|a, b| a.angle_deg.to_bits() == b.angle_deg.to_bits()) {
            let _ = write!(page, "\n| {} deg |", row[0].angle_deg);
            for cell in row {
                let _ = write!(page, " {} |", 100 * cell.found / cell.starts.max(1));
            }
        }
        page.push('\n');
    }
    page
}

fn poses(contest: &Contest) -> String {
    let mut page = String::from(
        "\n## Nine touches from how far off\n\nA paraboloid, R = 480 mm, Φ100, tilted by up to 10 \
         mrad, 1 µm of noise, nothing known of its sides; starts off by up to ±5 mm in each \
         coordinate and ±10 mrad in each tilt, times the factor. Starts that led to a pose which \
         the touches cannot tell from the true one (Σ(e/σ)² < 40 of nine), in %, and the median \
         time of a search. Ceres minimises the same distance with derivatives by Jets.\n\n",
    );
    let factors = contest.poses.first().map_or(&[][..], |(_, cells)| cells);
    page.push_str("| program |");
    for cell in factors {
        let _ = write!(page, " × {} | µs |", cell.size);
    }
    let _ = write!(page, "\n|---|{}", "---|---|".repeat(factors.len()));
    for (name, cells) in &contest.poses {
        let _ = write!(page, "\n| {name} |");
        for cell in cells {
            #[expect(clippy::cast_precision_loss, reason = "a few thousand starts")]
            let share = 100.0 * cell.found as f64 / cell.starts.max(1) as f64;
            let _ = write!(page, " {share:.2} | {:.1} |", cell.median_us);
        }
    }
    page.push('\n');
    page
}
