use std::collections::{BTreeMap, HashMap};

use nalgebra::{Point2, Point3, Unit, Vector3};
use probe_comp::{BallTouch, Nominal};

use super::settings::{MICRO, QUALIFICATION, TOUCHES};
use crate::Error;
use crate::case::{
    ColumnKinds, Columns, Document, Folder, Location, LoopSettings, NumberColumn, Problem, Table,
    group_names, nearest, quote,
};

pub(super) const XYZ: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
pub(super) const APPROACH: [&str; 3] = ["nx", "ny", "nz"];
pub(super) const GUIDE: [&str; 2] = ["guide_x_mm", "guide_y_mm"];
pub(super) const SPINDLE: &str = "spindle_deg";
const NEEDED: &[&str] = &["touch", XYZ[0], XYZ[1], XYZ[2]];
pub(super) const KNOWN: &[&str] = &[
    "touch",
    XYZ[0],
    XYZ[1],
    XYZ[2],
    APPROACH[0],
    APPROACH[1],
    APPROACH[2],
    GUIDE[0],
    GUIDE[1],
    SPINDLE,
    "use",
];
const KNOWN_ARTEFACT: &[&str] =
    &["touch", XYZ[0], XYZ[1], XYZ[2], APPROACH[0], APPROACH[1], APPROACH[2], SPINDLE];
const KNOWN_MICRO: &[&str] = &["touch", "k", XYZ[0], XYZ[1], XYZ[2]];
/// How far the length of a direction may be from 1: two decimals of each component.
pub(super) const UNIT_TOL: f64 = 0.01;

/// `touches.csv` and `micro.csv` as read.
#[derive(Clone, Debug)]
pub(super) struct Touches {
    pub(super) file: Location,
    /// Line of each touch.
    pub(super) lines: Vec<usize>,
    pub(super) names: Vec<String>,
    /// With an uncertainty of 1 mm.
    pub(super) balls: Vec<BallTouch>,
    /// Whether a touch is only judged.
    pub(super) is_check: Vec<bool>,
    pub(super) have_approach: bool,
    pub(super) have_spindle: bool,
    pub(super) covariates: Vec<NumberColumn>,
    pub(super) groups: Option<Vec<String>>,
    pub(super) group_column: Option<String>,
    pub(super) warnings: Vec<String>,
}

impl Touches {
    pub(super) fn read(
        folder: &Folder,
        document: &Document,
        closure: &LoopSettings,
    ) -> Result<Self, Error> {
        let table = folder.table(TOUCHES, NEEDED)?;
        let mut columns = Columns::new(&table, KNOWN);
        let names: Vec<String> = columns.ids("touch")?.into_iter().map(str::to_owned).collect();
        let centers_mm = coordinates(&mut columns)?;
        let approaches = approaches(&mut columns, &table)?;
        let guides = guides(&mut columns)?;
        let spindle_deg = if columns.has(SPINDLE) { Some(columns.numbers(SPINDLE)?) } else { None };
        let is_check = columns.words("use", &[("fit", false), ("check", true)], Some(false))?;
        let extras = columns.rest(&closure.columns)?;
        let mut warnings = extras.warnings;
        let mut micro =
            if folder.has(MICRO) { micro(folder, &names, &mut warnings)? } else { BTreeMap::new() };
        let ball = |(row, center_mm): (usize, &Point3<f64>)| BallTouch {
            approach: approaches.as_ref().map(|a| a[row]),
            guide_mm: guides.as_ref().map(|g| g[row]),
            micro_mm: micro.remove(&row).unwrap_or_default(),
            spindle_rad: spindle_deg.as_ref().map_or(0.0, |s| s[row].to_radians()),
            ..BallTouch::new(*center_mm, 1.0)
        };
        let balls: Vec<BallTouch> = centers_mm.iter().enumerate().map(ball).collect();
        Ok(Self {
            file: table.at_file(),
            lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
            names,
            have_approach: approaches.is_some(),
            have_spindle: spindle_deg.is_some(),
            balls,
            is_check,
            covariates: extras.covariates,
            groups: group_names(closure.group.as_ref(), &table, document)?,
            group_column: closure.group.as_ref().map(|g| g.get_ref().clone()),
            warnings,
        })
    }

    /// Whether the ball was on the other side of the surface than its normal: as the approaches
    /// say, or as most of the centres do.
    pub(super) fn are_behind(&self, nominal: &Nominal, tip_radius_mm: f64) -> bool {
        let mut votes = 0_i64;
        for ball in &self.balls {
            let Ok(foot) = nominal.foot(&ball.center_mm) else { continue };
            let side = match ball.approach {
                Some(approach) => -approach.dot(&foot.normal),
                None if tip_radius_mm > 0.0 => foot.distance_mm,
                None => continue,
            };
            votes += if side < 0.0 { 1 } else { -1 };
        }
        votes > 0
    }
}

/// Touches of an artefact as read.
pub(super) struct ArtefactTouches {
    pub(super) file: Location,
    /// Line of each touch.
    pub(super) lines: Vec<usize>,
    /// With an uncertainty of 1 mm.
    pub(super) balls: Vec<BallTouch>,
}

/// `qualification.csv`.
pub(super) fn artefact_touches(folder: &Folder) -> Result<ArtefactTouches, Error> {
    let table = folder.table(QUALIFICATION, NEEDED)?;
    let mut columns = Columns::new(&table, KNOWN_ARTEFACT);
    columns.ids("touch")?;
    let centers_mm = coordinates(&mut columns)?;
    let approaches = approaches(&mut columns, &table)?;
    let spindle_deg = if columns.has(SPINDLE) { Some(columns.numbers(SPINDLE)?) } else { None };
    columns.rest(&ColumnKinds::default())?;
    let ball = |(row, center_mm): (usize, &Point3<f64>)| BallTouch {
        approach: approaches.as_ref().map(|a| a[row]),
        spindle_rad: spindle_deg.as_ref().map_or(0.0, |s| s[row].to_radians()),
        ..BallTouch::new(*center_mm, 1.0)
    };
    Ok(ArtefactTouches {
        file: table.at_file(),
        lines: (0..table.n_rows()).map(|row| table.line(row)).collect(),
        balls: centers_mm.iter().enumerate().map(ball).collect(),
    })
}

fn coordinates(columns: &mut Columns<'_>) -> Result<Vec<Point3<f64>>, Error> {
    let [x, y, z] = [columns.numbers(XYZ[0])?, columns.numbers(XYZ[1])?, columns.numbers(XYZ[2])?];
    Ok((0..x.len()).map(|row| Point3::new(x[row], y[row], z[row])).collect())
}

/// Directions of approach, if there is any column of them.
fn approaches(
    columns: &mut Columns<'_>,
    table: &Table,
) -> Result<Option<Vec<Unit<Vector3<f64>>>>, Error> {
    if !APPROACH.iter().any(|name| columns.has(name)) {
        return Ok(None);
    }
    let [x, y, z] = APPROACH.map(|name| columns.numbers(name));
    let (x, y, z) = (x?, y?, z?);
    let unit = |row: usize| {
        let vector = Vector3::new(x[row], y[row], z[row]);
        let length = vector.norm();
        if (length - 1.0).abs() <= UNIT_TOL {
            return Ok(Unit::new_normalize(vector));
        }
        let column = table.column(APPROACH[0]).unwrap_or_default();
        let message = format!(
            "(nx, ny, nz) has length {length:.4}; expected a unit vector from the ball towards the \
             surface"
        );
        Err(Error::case(table.at_cell(row, column), Problem::WrongValue { message }))
    };
    (0..x.len()).map(unit).collect::<Result<Vec<_>, _>>().map(Some)
}

fn guides(columns: &mut Columns<'_>) -> Result<Option<Vec<Point2<f64>>>, Error> {
    if !GUIDE.iter().any(|name| columns.has(name)) {
        return Ok(None);
    }
    let [x, y] = [columns.numbers(GUIDE[0])?, columns.numbers(GUIDE[1])?];
    Ok(Some(x.into_iter().zip(y).map(|(x, y)| Point2::new(x, y)).collect()))
}

/// Balls' centres around each touch, by its row.
fn micro(
    folder: &Folder,
    names: &[String],
    warnings: &mut Vec<String>,
) -> Result<BTreeMap<usize, Vec<Point3<f64>>>, Error> {
    let table = folder.table(MICRO, KNOWN_MICRO)?;
    let mut columns = Columns::new(&table, KNOWN_MICRO);
    let touches = columns.texts("touch")?;
    let numbers = columns.texts("k")?;
    let centers_mm = coordinates(&mut columns)?;
    warnings.extend(columns.rest(&ColumnKinds::default())?.warnings);
    let index: HashMap<&str, usize> = names.iter().map(String::as_str).zip(0..).collect();
    let mut first_use = HashMap::new();
    let mut all: BTreeMap<usize, Vec<Point3<f64>>> = BTreeMap::new();
    for (row, (touch, k)) in touches.iter().zip(&numbers).enumerate() {
        let at = |column: &str| table.at_cell(row, table.column(column).unwrap_or_default());
        let Some(&of) = index.get(touch) else {
            let nearest = nearest(touch, names.iter().map(String::as_str)).map(str::to_owned);
            let id = (*touch).to_owned();
            let problem = Problem::UnknownId { what: "touch", id, table: TOUCHES, nearest };
            return Err(Error::case(at("touch"), problem));
        };
        let Some(number) = k.parse::<u32>().ok().filter(|k| *k > 0) else {
            let message = format!("expected a number 1, 2, 3, …, found {}", quote(k));
            return Err(Error::case(at("k"), Problem::WrongValue { message }));
        };
        if let Some(first) = first_use.insert((of, number), row) {
            let (id, first) = (format!("{touch} {number}"), table.line(first));
            return Err(Error::case(at("k"), Problem::DuplicateId { what: "k", id, first }));
        }
        all.entry(of).or_default().push(centers_mm[row]);
    }
    if let Some((&of, centers)) = all.iter().find(|(_, centers)| centers.len() < 3) {
        let message = format!(
            "touch {} has {} further touches around it; a plane needs 3",
            quote(&names[of]),
            centers.len()
        );
        return Err(Error::case(table.at_file(), Problem::WrongValue { message }));
    }
    Ok(all)
}
