use nalgebra::Point3;
use pose_icp::Touch;

use super::settings::{EDGE, POINTS};
use crate::Error;
use crate::case::{
    Columns, Document, Folder, Location, LoopSettings, NumberColumn, Problem, group_names,
};

pub(super) const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
pub(super) const KNOWN: &[&str] = &["point", XYZ[0], XYZ[1], XYZ[2], "use"];
/// Four side touches and the centre.
const EDGE_ROWS: usize = 5;

/// `points.csv` as read.
#[derive(Clone, Debug)]
pub(super) struct Points {
    pub(super) file: Location,
    /// Line of each point.
    pub(super) lines: Vec<usize>,
    pub(super) names: Vec<String>,
    pub(super) centers_mm: Vec<Point3<f64>>,
    /// Whether a point is only judged.
    pub(super) is_check: Vec<bool>,
    pub(super) covariates: Vec<NumberColumn>,
    pub(super) groups: Option<Vec<String>>,
    pub(super) group_column: Option<String>,
    pub(super) warnings: Vec<String>,
}

impl Points {
    pub(super) fn read(
        folder: &Folder,
        document: &Document,
        closure: &LoopSettings,
    ) -> Result<Self, Error> {
        let table = folder.table(POINTS, &["point", XYZ[0], XYZ[1], XYZ[2]])?;
        let mut columns = Columns::new(&table, KNOWN);
        let names = columns.ids("point")?.into_iter().map(str::to_owned).collect();
        let centers_mm = coordinates(&mut columns)?;
        let is_check = columns.words("use", &[("fit", false), ("check", true)], Some(false))?;
        let extras = columns.rest(&closure.columns)?;
        Ok(Self {
            file: table.at_file(),
            lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
            names,
            centers_mm,
            is_check,
            covariates: extras.covariates,
            groups: group_names(closure.group.as_ref(), &table, document)?,
            group_column: closure.group.as_ref().map(|g| g.get_ref().clone()),
            warnings: extras.warnings,
        })
    }

    /// Rows to be fitted.
    pub(super) fn fitted(&self) -> Vec<usize> {
        (0..self.names.len()).filter(|row| !self.is_check[*row]).collect()
    }

    /// Touches to be fitted.
    pub(super) fn touches(&self, sigma_mm: f64) -> Vec<Touch> {
        self.fitted().into_iter().map(|row| Touch::new(self.centers_mm[row], sigma_mm)).collect()
    }
}

/// The five rows of `edge.csv`.
pub(super) fn edge(folder: &Folder) -> Result<(Location, [Point3<f64>; EDGE_ROWS]), Error> {
    let table = folder.table(EDGE, &["point", XYZ[0], XYZ[1], XYZ[2]])?;
    let mut columns = Columns::new(&table, &["point", XYZ[0], XYZ[1], XYZ[2]]);
    columns.ids("point")?;
    let points = coordinates(&mut columns)?;
    let found = points.len();
    points.try_into().map(|points| (table.at_file(), points)).map_err(|_| {
        let message = format!(
            "expected {EDGE_ROWS} rows, four side touches (−y, +x, +y, −x, or the other way \
             round) and the centre; found {found}"
        );
        Error::case(table.at_file(), Problem::WrongValue { message })
    })
}

fn coordinates(columns: &mut Columns<'_>) -> Result<Vec<Point3<f64>>, Error> {
    let [x, y, z] = [columns.numbers(XYZ[0])?, columns.numbers(XYZ[1])?, columns.numbers(XYZ[2])?];
    Ok((0..x.len()).map(|row| Point3::new(x[row], y[row], z[row])).collect())
}
