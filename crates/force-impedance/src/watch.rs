//! Which cycles may be believed.

use nalgebra::Vector3;

use crate::scalar::{is_finite, norm};
use crate::{Cells, ControllerSettings, Fault, Head, HeadPose, Measurement};

/// Steps towards the measured lengths at most; from 5 mm away three reach 0.1 µm.
const MAX_STEPS: usize = 3;
/// A step below this leaves an error of its square over a leg of some 70 mm, about 1 nm.
const LAST_STEP_MM: f64 = 0.01;
/// Squared length of a normal with six good digits.
const UNIT_TOL: f64 = 1e-5;
/// Shortest and longest believable interval, in nominal ones.
const INTERVAL_RANGE: [f64; 2] = [0.5, 10.0];
/// A reading that last changed by less than this was at rest: no converter has such a digit.
const ALIVE_N: f64 = 1e-6;
/// Cosine of 15°: nearer to the axis, a quarter of the contact force at most is across the tool,
/// where friction hides it.
const ALONG_COSINE: f64 = 0.966;
/// Cosine of 84°: farther no head leans, whatever its lengths are.
const LYING_COSINE: f64 = 0.1;
/// A head that is not found is looked for anew from straight after this many cycles; from there
/// eight steps reach the far end of a workspace.
const SEARCH_CYCLES: u32 = 6;

/// A cycle that is not believed, and the cells' readings where those are.
pub(crate) struct Refusal {
    pub(crate) fault: Fault,
    pub(crate) cells_n: Option<[f64; 4]>,
}

/// Memory of the input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Watch {
    cells: [Cell; 4],
    /// Way towards the workpiece since the axial cell last changed.
    blind_mm: f64,
    /// Cycles since the head was last found.
    lost_cycles: u32,
    /// Where the head was last seen.
    pub(crate) pose: HeadPose,
}

/// Memory of one cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Cell {
    read_n: f64,
    /// Its last change.
    change_n: f64,
    /// Cycles without a change since, and changes before.
    unchanged_cycles: u32,
    changes: u32,
}

impl Cell {
    #[inline]
    fn read(&mut self, now_n: f64) {
        if now_n.to_bits() == self.read_n.to_bits() {
            self.unchanged_cycles = self.unchanged_cycles.saturating_add(1);
        } else {
            self.change_n = now_n - self.read_n;
            self.unchanged_cycles = 0;
            self.changes = self.changes.saturating_add(1);
        }
        self.read_n = now_n;
    }

    /// Alive for some time, and at a stroke no more.
    fn is_stuck(&self, cycles: u32) -> bool {
        self.unchanged_cycles >= cycles && self.changes >= cycles && self.change_n.abs() > ALIVE_N
    }
}

impl Watch {
    pub(crate) fn new(pose: HeadPose) -> Self {
        Self { cells: [Cell::default(); 4], blind_mm: 0.0, lost_cycles: 0, pose }
    }

    /// Everything that can be wrong, in the order of the fault table; the cells' readings where
    /// nothing is, with the head's place in `pose`. `inward_mm` is the last step towards the
    /// workpiece.
    #[inline]
    #[expect(clippy::too_many_arguments, reason = "the state of a controller, part by part")]
    pub(crate) fn judge(
        &mut self,
        head: &Head,
        settings: &ControllerSettings,
        normal_cosine: f64,
        commanded: &HeadPose,
        inward_mm: f64,
        seen: &Measurement,
        dt_s: f64,
    ) -> Result<[f64; 4], Refusal> {
        let [shortest, longest] = INTERVAL_RANGE;
        let in_time =
            dt_s >= shortest * settings.interval_s && dt_s <= longest * settings.interval_s;
        let read = self.read(settings, seen.cells_n, inward_mm);
        let refuse = |fault| Err(Refusal { fault, cells_n: read.ok() });
        if !in_time {
            return refuse(Fault::Interval);
        }
        let cells_n = match read {
            Ok(cells_n) => cells_n,
            Err(fault) => return refuse(fault),
        };
        let Some(lengths_mm) = seen.lengths_mm else {
            return refuse(Fault::NoSample);
        };
        if !lengths_mm.iter().all(|l| l.is_finite()) {
            return refuse(Fault::NotFinite);
        }
        if !self.find(head, settings.max_consistency_mm, commanded, &lengths_mm) {
            return refuse(Fault::Lengths);
        }
        let cosine = -seen.normal.dot(&self.pose.axis);
        if !(is_unit(&seen.normal) && cosine >= normal_cosine) {
            return refuse(Fault::Normal);
        }
        if self.blind_mm > settings.max_blind_mm && self.is_blind(settings, cosine) {
            return Err(Refusal { fault: Fault::CellStuck(Cells::one(3)), cells_n: None });
        }
        Ok(cells_n)
    }

    /// The cells' readings, where they can be believed.
    #[inline]
    fn read(
        &mut self,
        settings: &ControllerSettings,
        cells_n: Option<[f64; 4]>,
        inward_mm: f64,
    ) -> Result<[f64; 4], Fault> {
        let cells_n = cells_n.ok_or(Fault::NoSample)?;
        for (cell, now_n) in self.cells.iter_mut().zip(cells_n) {
            cell.read(now_n);
        }
        let [a, b, c, axial] = &self.cells;
        let unchanged = [a, b, c, axial].map(|cell| cell.unchanged_cycles);
        self.blind_mm = if unchanged[3] == 0 { 0.0 } else { self.blind_mm + inward_mm.max(0.0) };
        if !cells_n.iter().all(|f| f.abs() < settings.max_cell_n) {
            let finite = cells_n.iter().all(|v| v.is_finite());
            return Err(if finite { Fault::CellRange } else { Fault::NotFinite });
        }
        let [a, b, c, d] = unchanged;
        if a.min(b).min(c).min(d) >= settings.frozen_cycles {
            return Err(Fault::Frozen);
        }
        if a.max(b).max(c).max(d) >= settings.suspect_cycles {
            let stuck = self.stuck(settings.suspect_cycles);
            if stuck != Cells::default() {
                return Err(Fault::CellStuck(stuck));
            }
        }
        Ok(cells_n)
    }

    /// Cells that have stopped changing while another goes on.
    fn stuck(&self, cycles: u32) -> Cells {
        if self.cells.iter().all(|cell| cell.unchanged_cycles >= cycles) {
            return Cells::default();
        }
        let mut stuck = Cells::default();
        for (i, cell) in self.cells.iter().enumerate() {
            if cell.is_stuck(cycles) {
                stuck = stuck.and(Cells::one(i));
            }
        }
        stuck
    }

    /// Whether nothing but an axial cell that does not change would tell of a contact.
    #[cold]
    fn is_blind(&self, settings: &ControllerSettings, cosine: f64) -> bool {
        let [legs @ .., axial] = &self.cells;
        let still = |cell: &Cell| cell.unchanged_cycles >= settings.suspect_cycles;
        still(axial) && !legs.iter().all(still) && cosine >= ALONG_COSINE
    }

    /// Finds the pose of the lengths; false where there is none.
    ///
    /// It is looked for from where it was last seen. A head that was lost is looked for from where
    /// it was sent, and from where the search has come to.
    #[inline]
    fn find(
        &mut self,
        head: &Head,
        max_mm: f64,
        commanded: &HeadPose,
        lengths_mm: &[f64; 4],
    ) -> bool {
        if self.lost_cycles > 0 {
            return self.find_again(head, max_mm, commanded, lengths_mm);
        }
        search(head, max_mm, &mut self.pose, lengths_mm) == Search::Found
            || self.search_on(head, max_mm, lengths_mm)
    }

    #[cold]
    fn find_again(
        &mut self,
        head: &Head,
        max_mm: f64,
        commanded: &HeadPose,
        lengths_mm: &[f64; 4],
    ) -> bool {
        let mut pose = *commanded;
        if search(head, max_mm, &mut pose, lengths_mm) == Search::Found {
            self.pose = pose;
            self.lost_cycles = 0;
            return true;
        }
        self.search_on(head, max_mm, lengths_mm)
    }

    #[cold]
    fn search_on(&mut self, head: &Head, max_mm: f64, lengths_mm: &[f64; 4]) -> bool {
        let straight = straight_at(head, lengths_mm[3]);
        if self.lost_cycles.is_multiple_of(SEARCH_CYCLES) {
            self.pose = straight;
        }
        self.lost_cycles = self.lost_cycles.saturating_add(1);
        let found = search(head, max_mm, &mut self.pose, lengths_mm);
        match found {
            Search::Found => self.lost_cycles = 0,
            Search::Going => {}
            Search::Nowhere => self.pose = straight,
        }
        found == Search::Found
    }
}

#[derive(PartialEq)]
enum Search {
    Found,
    /// Not there, but on a way.
    Going,
    Nowhere,
}

/// Some steps towards the lengths; a head outside its limits is found as well.
#[inline]
fn search(head: &Head, max_mm: f64, pose: &mut HeadPose, lengths_mm: &[f64; 4]) -> Search {
    for _ in 0..MAX_STEPS {
        let tip_mm = head.forward_step(pose, lengths_mm);
        let step_mm = norm(&(tip_mm - pose.tip_mm));
        *pose = HeadPose::of(head, &tip_mm.coords);
        // Negated, so that NaN is nowhere.
        let stands = -pose.axis.y >= LYING_COSINE && pose.lengths_mm[3] > 0.0;
        if !stands {
            return Search::Nowhere;
        }
        if step_mm <= LAST_STEP_MM {
            break;
        }
    }
    let ([a, b, c, d], [e, f, g, h]) = (pose.lengths_mm, lengths_mm);
    let agrees = |found_mm: f64, read_mm: &f64| (found_mm - read_mm).abs() <= max_mm;
    if agrees(a, e) && agrees(b, f) && agrees(c, g) && agrees(d, h) {
        Search::Found
    } else {
        Search::Going
    }
}

/// The straight head at an axial length within its limits.
fn straight_at(head: &Head, axial_mm: f64) -> HeadPose {
    let [low, high] = head.limits.axial_mm;
    let reach_mm = axial_mm.max(low).min(high) + head.geometry.tip_to_plane_mm;
    HeadPose::of(head, &Vector3::new(0.0, -reach_mm, 0.0))
}

#[inline]
fn is_unit(normal: &Vector3<f64>) -> bool {
    let squared = normal.dot(normal);
    is_finite(normal) && (squared - 1.0).abs() <= UNIT_TOL
}
