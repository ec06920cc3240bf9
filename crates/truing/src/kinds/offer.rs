//! Measurements that a machine can make, one row of a table each.

use nalgebra::{Point3, Unit, Vector3};

/// What could be measured next.
#[derive(Debug)]
pub(crate) struct Offer {
    /// Table that the measurements are rows of.
    pub(crate) table: &'static str,
    /// Columns that hold what is read: nominal in a plan, empty in the table handed out.
    pub(crate) readings: Vec<&'static str>,
    /// Columns that the table does not have, with a cell for each of its rows.
    pub(crate) columns: Vec<(String, Vec<String>)>,
    /// In an order in which place and time do not run together.
    pub(crate) offered: Vec<Offered>,
    /// What one of them is called.
    pub(crate) noun: &'static str,
    /// How many of them there are, before those of the plan; `None`: one a row.
    pub(crate) made: Option<usize>,
    /// Whether the rows are a record that a controller writes, and nothing to be filled in by hand.
    pub(crate) is_record: bool,
    /// Whether the loop looks for a shift of all later measurements against the earlier ones: the plan is then
    /// told from one that comes between.
    pub(crate) is_new_session: bool,
    /// Those that are planned beside whatever is chosen, as far as a budget allows: repeats of what was
    /// measured, which tell the plan from another session.
    pub(crate) controls: Vec<usize>,
    /// Keys of `[plan]` that are not declared and would offer more.
    pub(crate) undeclared: Vec<&'static str>,
    /// What one of them takes, where it is declared.
    pub(crate) minutes: Option<f64>,
    /// How the machine goes there, where it is sent by a program.
    pub(crate) reach: Option<Reach>,
}

/// Of keys and whether they are declared, those that are not.
pub(crate) fn undeclared(keys: &[(&'static str, bool)]) -> Vec<&'static str> {
    keys.iter().filter(|(_, is_declared)| !is_declared).map(|(key, _)| *key).collect()
}

/// Cells by column.
pub(crate) type Cells = Vec<(&'static str, String)>;

/// Rows of another table that belong to a measurement.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    pub(crate) table: &'static str,
    pub(crate) rows: Vec<Cells>,
    /// Whether they are what is read, and so no part of what is handed out.
    pub(crate) are_readings: bool,
}

/// One measurement.
#[derive(Clone, Debug)]
pub(crate) struct Offered {
    /// Column that has its name in every table.
    pub(crate) names: &'static str,
    /// Rows of the table, each an observation; readings as the declared model predicts them.
    pub(crate) rows: Vec<Cells>,
    /// Rows of other tables.
    pub(crate) beside: Vec<Beside>,
    /// What is planned and no column holds, as load and lean of a press.
    pub(crate) told: Vec<(&'static str, f64)>,
    /// The touch that it is, where it is one.
    pub(crate) touch: Option<PlannedTouch>,
}

/// A touch to be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlannedTouch {
    /// Nominal contact.
    pub(crate) contact_mm: Point3<f64>,
    /// Unit normal there, towards the ball.
    pub(crate) normal: Unit<Vector3<f64>>,
    /// Centre of the ball at the contact.
    pub(crate) ball_mm: Point3<f64>,
    /// From the ball towards the surface.
    pub(crate) approach: Unit<Vector3<f64>>,
    pub(crate) feed_mm_per_min: f64,
    /// Turn of the probe in its spindle, where it is planned.
    pub(crate) spindle_deg: Option<f64>,
}

/// How a machine goes from touch to touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// Height at which the ball passes over everything.
    pub(crate) safe_z_mm: f64,
    /// Distance from the contact at which a touch begins and to which it goes back.
    pub(crate) approach_mm: f64,
    /// How far beyond the nominal contact the ball looks for the surface.
    pub(crate) overtravel_mm: f64,
    /// Between safe height and the beginning of a touch.
    pub(crate) travel_mm_per_min: f64,
}

impl Offered {
    /// Of one row.
    pub(crate) fn of_row(names: &'static str, cells: Cells) -> Self {
        Self { names, rows: vec![cells], beside: Vec::new(), told: Vec::new(), touch: None }
    }

    /// Cells that are the same in all of its rows.
    pub(crate) fn common(&self) -> impl Iterator<Item = &(&'static str, String)> {
        let first = self.rows.first().into_iter().flatten();
        first.filter(|cell| self.rows.iter().all(|row| row.contains(cell)))
    }
}
