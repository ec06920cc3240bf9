use model_discrepancy::{
    Course, Covariate, Declared, Effect, Group, Layout, Quantity, Role, Row, Shown, Sought, State,
    resolution_of,
};
mod discrepancy;

use nalgebra::{DMatrix, Point3, Unit, Vector3};

use super::catalogue::{self, Entry, Setting};
use super::columns::as_f64;
use super::form::{Form, FormScale};
use super::measured::MeasuredTouch;
use super::probe::Probe;
use super::term::{Situation, Term, combined};
use crate::foot::foot_of_ball;
use crate::nominal::{FormFrame, NominalFoot};
use crate::{Nominal, NormalSource, ProbeError, ProbeUncertainty, compensate};

/// What is declared of the measurement.
#[derive(Clone, Debug)]
pub struct ProbeSetup {
    /// The part as drawn.
    pub nominal: Nominal,
    /// Radius of the ball.
    pub tip_radius_mm: f64,
    /// Axis of the stylus, workpiece frame.
    pub stylus: Unit<Vector3<f64>>,
    /// Normals along which the balls are compensated.
    pub source: NormalSource,
    /// Whether the touches' standard uncertainties are declared, or only weigh them.
    pub sigma_declared: bool,
    /// What the qualification with which the touches were corrected leaves uncertain; `None` where the
    /// probe is taken for known.
    pub qualification: Option<ProbeUncertainty>,
}

/// Touches of a part of known surface, and the effects that their compensation leaves out.
///
/// Residual: how far the compensated contact is above the nominal surface along its normal, in
/// mm; one row per touch. Part, ball and frame are as stated: the declared model has no parameter, but
/// for what a qualification leaves uncertain of the probe, with rows of prior knowledge.
#[derive(Clone, Debug)]
pub struct ProbeModel {
    pub(crate) setup: ProbeSetup,
    pub(crate) touches: Vec<MeasuredTouch>,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) standards: Vec<Standard>,
    /// Nominal points as declared.
    pub(crate) feet: Vec<NominalFoot>,
    /// Balls' centres on the nominal part.
    centers_mm: Vec<Vector3<f64>>,
    approaches: Vec<Unit<Vector3<f64>>>,
    /// What the compensation adds to the distance of the ball's centre.
    compensation_mm: Vec<f64>,
    /// Effects of the catalogue that the residual shows, the last in it.
    pub(crate) shown: Shown,
    pub(super) declared: Declared,
    pub(super) terms: Vec<Term>,
    pub(super) probe: Option<Probe>,
}

/// One amplitude measured by other means, as a proposal may have it.
#[derive(Clone, Debug)]
pub(crate) struct Standard {
    pub(crate) effect: &'static str,
    pub(crate) subject: Option<&'static str>,
    pub(crate) parameter: &'static str,
    pub(crate) sigma: f64,
}

/// Distance of the part's origin from the middle of what was touched, over half of its width, from
/// which on forms count from the middle.
const WELL_WITHIN: f64 = 0.5;

/// What touches along the normals of a part do not tell from a patch of it.
const WORN: &str = "; a ball that is worn, or dirty, on the side that touches there reads the same";

impl ProbeModel {
    /// Model of `touches`, in the order measured.
    ///
    /// `covariates` are the columns recorded beside the touches, one value per touch: `time_s`
    /// drives the drift, `feed_mm_per_min` (or `_s`) the latency, every column ending in `_c` a
    /// thermal effect.
    ///
    /// # Errors
    ///
    /// As [`compensate`], and [`ProbeError::InvalidCovariate`].
    pub fn new(
        setup: ProbeSetup,
        touches: Vec<MeasuredTouch>,
        covariates: &[Covariate],
    ) -> Result<Self, ProbeError> {
        for covariate in covariates {
            let finite = covariate.values.iter().all(|v| v.is_finite());
            if !finite || covariate.values.len() != touches.len() {
                let (covariate, needed) = (covariate.name.clone(), touches.len());
                return Err(ProbeError::InvalidCovariate { covariate, needed });
            }
        }
        let model = Self::with_standards(setup, touches, covariates.to_vec(), Vec::new())?;
        let places_mm = model.places_mm();
        let shown = Shown::of(&model, &State::start(&model), &model.sought(&places_mm));
        Ok(model.with_shown(shown))
    }

    pub(crate) fn with_standards(
        setup: ProbeSetup,
        touches: Vec<MeasuredTouch>,
        covariates: Vec<Covariate>,
        standards: Vec<Standard>,
    ) -> Result<Self, ProbeError> {
        let balls: Vec<_> = touches.iter().map(|t| t.touch.clone()).collect();
        let contacts = compensate(&setup.nominal, setup.tip_radius_mm, &balls, setup.source)?;
        let foot = |(index, ball): (usize, &crate::BallTouch)| {
            foot_of_ball(&setup.nominal, setup.tip_radius_mm, index, &ball.center_mm)
        };
        let feet = balls.iter().enumerate().map(foot).collect::<Result<Vec<_>, _>>()?;
        let compensation_mm = (contacts.iter().zip(&feet))
            .map(|(contact, foot)| contact.deviation_mm - foot.distance_mm)
            .collect();
        let nominal_center = |foot: &NominalFoot| {
            foot.point_mm.coords + foot.normal.into_inner() * setup.tip_radius_mm
        };
        let centers_mm: Vec<_> = feet.iter().map(nominal_center).collect();
        let approaches: Vec<_> = (balls.iter().zip(&feet))
            .map(|(ball, foot)| ball.approach.unwrap_or(-foot.normal))
            .collect();
        let setting = setting(&setup, (&touches, &centers_mm, &approaches), &covariates, &feet);
        let (effects, terms) = catalogue::catalogue(&setting)
            .into_iter()
            .map(|Entry { effect, term }| (effect, term))
            .unzip();
        let probe = setup.qualification.clone().map(Probe::new).transpose()?;
        let base = probe.as_ref().map_or_else(Vec::new, Probe::parameters);
        let mut layout = layout(&touches, &standards, setup.sigma_declared);
        if !base.is_empty() {
            layout.groups.push(Group { name: "qualification".to_owned(), role: Role::Prior });
            let group = layout.groups.len() - 1;
            for _ in &base {
                push(&mut layout, group, 1.0, false);
            }
        }
        let mut normals: Vec<_> = feet.iter().map(|foot| foot.normal.into_inner()).collect();
        // What was measured by other means looks nowhere.
        normals.resize(layout.observations.len(), Vector3::zeros());
        let measured = touches.iter().flat_map(|t| t.touch.center_mm.iter().copied());
        let declared = Declared {
            directions: Some(normals),
            resolution: resolution_of(measured),
            ..Declared::new(layout, base, effects)
        };
        Ok(Self {
            setup,
            touches,
            covariates,
            standards,
            feet,
            centers_mm,
            approaches,
            compensation_mm,
            shown: Shown::default(),
            declared,
            terms,
            probe,
        })
    }

    /// Where each row lies; prior knowledge has no place.
    fn places_mm(&self) -> Vec<Option<Point3<f64>>> {
        let mut places: Vec<_> = self.feet.iter().map(|foot| Some(foot.point_mm)).collect();
        places.resize(self.declared.layout.rows.len(), None);
        places
    }

    /// What is looked for in the residual.
    fn sought<'a>(&'a self, places_mm: &'a [Option<Point3<f64>>]) -> Sought<'a> {
        let of_the_catalogue = self.terms.len() - self.shown.effects();
        let terms = self.terms[..of_the_catalogue].iter().enumerate();
        let drifts = terms.filter_map(|(effect, term)| Some((effect, term.elapsed()?)));
        Sought { places: places_mm, has_surface: true, ..Sought::of_drifts(drifts) }
    }

    /// The model with what its residual shows in the catalogue.
    pub(crate) fn with_shown(mut self, shown: Shown) -> Self {
        let places_mm = self.places_mm();
        self.declared.effects.extend(shown.patches.iter().map(|patch| {
            let mut effect = patch.effect(&places_mm);
            effect.description += WORN;
            effect
        }));
        self.terms.extend(shown.patches.iter().copied().map(Term::Patch));
        for (drift, course) in &shown.courses {
            let Some(elapsed) = self.terms[*drift].elapsed() else { continue };
            let is_timed = self.declared.effects[*drift].driver.is_some();
            let unit = if is_timed { "s" } else { "touches" };
            let mut effect = course.effect(&self, *drift, elapsed, unit, ("µm", 1e3));
            let from = effect.subject.as_deref().and_then(|s| s.strip_prefix("trigger, "));
            if let (Course::Session(_), Some(from)) = (course, from) {
                effect.description = format!(
                    "all touches come sooner or later {from}: dirt on the ball, another stylus, or \
                     another trigger"
                );
            }
            let term = self.terms[*drift].clone().gone(course.come(elapsed));
            self.declared.effects.push(effect);
            self.terms.push(term);
        }
        self.shown = shown;
        self
    }

    /// The model with the patches and the courses that the residual shows beside what was found; `None`
    /// where these are the ones that it has.
    #[must_use]
    pub fn about_found(&self, found: &State) -> Option<Self> {
        let shown = self.shown.beside(self, found, &self.sought(&self.places_mm()));
        if shown == self.shown {
            return None;
        }
        let mut plain = self.clone();
        self.shown.take_off(&mut plain.declared, &mut plain.terms);
        Some(plain.with_shown(shown))
    }

    /// The given covariates and the places of the contacts (`part_x_mm`, `part_y_mm`,
    /// `part_z_mm`, and on a graph over xy `part_radius_mm`), one value per observation.
    #[must_use]
    pub fn all_covariates(&self) -> Vec<Covariate> {
        let place = |name: &str, of: &dyn Fn(&NominalFoot) -> f64| {
            Covariate::coordinate(name, Quantity::Position, self.feet.iter().map(of).collect())
        };
        let mut all =
            vec![place("part_x_mm", &|f| f.point_mm.x), place("part_y_mm", &|f| f.point_mm.y)];
        all.push(match self.setup.nominal.form {
            FormFrame::Around { .. } => place("part_z_mm", &|f| f.point_mm.z),
            FormFrame::Over => place("part_radius_mm", &|f| f.point_mm.coords.xy().norm()),
        });
        all.extend(self.covariates.iter().cloned());
        // Prior knowledge has no place: the mean, which no shape turns on.
        for covariate in &mut all {
            let mean = covariate.values.iter().sum::<f64>() / as_f64(covariate.values.len().max(1));
            covariate.values.resize(self.declared.layout.observations.len(), mean);
        }
        all
    }

    /// The ball's centre of a touch without what the effects of a state added to its reading, and
    /// what those that count add to its distance.
    fn corrected(
        &self,
        index: usize,
        at: &State,
        counts: impl Fn(&Term) -> bool,
    ) -> (Point3<f64>, f64) {
        let zero = self.azimuth_zero(index);
        let situation = self.situation(index, &zero);
        let (mut center, mut added_mm) = (self.touches[index].touch.center_mm, 0.0);
        for (term, amplitudes) in self.terms.iter().zip(&at.amplitudes) {
            if amplitudes.iter().all(|a| *a == 0.0) || !counts(term) {
                continue;
            }
            center -= combined(&term.readings(&situation), amplitudes);
            let distances = term.distances(&situation);
            added_mm += distances.iter().zip(amplitudes.iter()).map(|(d, a)| d * a).sum::<f64>();
        }
        (center, added_mm)
    }

    /// Contact, normal and deviation of a touch without what the effects of a state added to it;
    /// errors of the part's own form stay in. `None` where the corrected ball has no foot.
    #[must_use]
    pub(super) fn contact_at(
        &self,
        index: usize,
        at: &State,
    ) -> Option<(Point3<f64>, Unit<Vector3<f64>>, f64)> {
        let (center, added_mm) = self.corrected(index, at, |term| !term.is_of_the_part());
        let (foot, deviation_mm) = self.judged(index, &center, added_mm)?;
        Some((foot.point_mm + foot.normal.into_inner() * deviation_mm, foot.normal, deviation_mm))
    }

    fn judged(
        &self,
        index: usize,
        center_mm: &Point3<f64>,
        added_mm: f64,
    ) -> Option<(NominalFoot, f64)> {
        let foot = self.setup.nominal.foot(center_mm).ok()?;
        Some((foot, foot.distance_mm + self.compensation_mm[index] - added_mm))
    }

    pub(super) fn azimuth_zero(&self, index: usize) -> Unit<Vector3<f64>> {
        let stylus = &self.setup.stylus;
        // The machine's x, unless the stylus lies along it.
        let x = if stylus.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
        let across = x - stylus.into_inner() * stylus.dot(&x);
        let angle = self.touches[index].touch.spindle_rad;
        nalgebra::Rotation3::from_axis_angle(stylus, angle) * Unit::new_normalize(across)
    }

    pub(super) fn situation<'a>(
        &'a self,
        index: usize,
        zero: &'a Unit<Vector3<f64>>,
    ) -> Situation<'a> {
        Situation {
            observation: index,
            center_mm: &self.centers_mm[index],
            contact_mm: &self.feet[index].point_mm,
            normal: &self.feet[index].normal,
            approach: &self.approaches[index],
            stylus: &self.setup.stylus,
            zero,
        }
    }

    /// `∂ residual / ∂ parameter` of what a qualification leaves uncertain.
    pub(super) fn by_base(&self) -> DMatrix<f64> {
        let (rows, n) = (self.declared.layout.rows.len(), self.declared.base.len());
        let mut jacobian = DMatrix::zeros(rows, n);
        let Some(probe) = &self.probe else { return jacobian };
        for (index, touch) in self.touches.iter().enumerate() {
            let zero = self.azimuth_zero(index);
            let row = probe.row(&self.situation(index, &zero), &touch.touch);
            jacobian.row_mut(index).copy_from_slice(&row);
        }
        jacobian.rows_mut(rows - n, n).copy_from(probe.prior());
        jacobian
    }

    /// Effects and columns of the amplitude that a standard knows: the same cause may have effects that differ by what
    /// goes along.
    fn amplitudes_of(&self, standard: &Standard) -> impl Iterator<Item = (usize, usize)> {
        let of_effect = move |(e, effect): (usize, &Effect)| {
            let column = effect.parameters.iter().position(|p| p.name == standard.parameter)?;
            let same = effect.id == standard.effect
                && standard.subject.is_none_or(|s| effect.subject.as_deref() == Some(s));
            same.then_some((e, column))
        };
        self.declared.effects.iter().enumerate().filter_map(of_effect)
    }

    /// `∂ residual / ∂ amplitude` of one touch.
    fn row(&self, at: &State, effect: usize, index: usize) -> Vec<f64> {
        let zero = self.azimuth_zero(index);
        let situation = self.situation(index, &zero);
        let term = &self.terms[effect];
        let mut values = vec![0.0; self.declared.effects[effect].parameters.len()];
        let readings = term.readings(&situation);
        if !readings.is_empty() {
            let (center, _) = self.corrected(index, at, |_| true);
            let normal = (self.setup.nominal.foot(&center))
                .map_or_else(|_| Vector3::repeat(f64::NAN), |foot| foot.normal.into_inner());
            for (value, reading) in values.iter_mut().zip(&readings) {
                *value -= normal.dot(reading);
            }
        }
        for (value, distance) in values.iter_mut().zip(term.distances(&situation)) {
            *value -= distance;
        }
        values
    }
}

/// Touches, with the ball's place and approach at each.
type Touched<'a> = (&'a [MeasuredTouch], &'a [Vector3<f64>], &'a [Unit<Vector3<f64>>]);

fn setting<'a>(
    setup: &ProbeSetup,
    (touches, centers_mm, approaches): Touched<'a>,
    covariates: &'a [Covariate],
    feet: &'a [NominalFoot],
) -> Setting<'a> {
    let n = as_f64(feet.len().max(1));
    let mut normal_squares = Vector3::zeros();
    let mut levers = [[0.0; 3]; 3];
    for (foot, touch) in feet.iter().zip(touches) {
        normal_squares += foot.normal.component_mul(&foot.normal) / n;
        for (i, row) in levers.iter_mut().enumerate() {
            for (j, lever) in row.iter_mut().enumerate() {
                *lever += (foot.normal[i] * touch.touch.center_mm[j]).powi(2) / n;
            }
        }
    }
    let (families, form_scale): (&[Form], _) = match setup.nominal.form {
        FormFrame::Around { center_mm } => {
            let radius = feet.iter().map(|f| (f.point_mm - center_mm).norm()).fold(0.0, f64::max);
            (&Form::AROUND, FormScale { center_mm, radius_mm: radius.max(f64::MIN_POSITIVE) })
        }
        FormFrame::Over => (&Form::OVER, over(feet)),
    };
    let forms = (families.iter())
        .map(|&form| (form, form.seen(&form_scale, feet)))
        .filter(|(_, seen)| !seen.is_empty())
        .collect();
    let levers_mm = levers.map(|row| row.map(f64::sqrt));
    let turn = |foot: &NominalFoot| (foot.point_mm - form_scale.center_mm).cross(&foot.normal);
    let square = feet.iter().map(turn).fold(Vector3::zeros(), |sum, t| sum + t.component_mul(&t));
    let turns_mm = (square / n).map(f64::sqrt);
    Setting {
        touches,
        centers_mm,
        approaches,
        feet,
        covariates,
        forms,
        form_scale,
        normal_squares,
        levers_mm,
        turns_mm,
    }
}

/// Origin of the part's own frame, where it lies well within what was touched, else the middle of that;
/// and how far it reaches. A form about another place is a form and a turn of the frame.
fn over(feet: &[NominalFoot]) -> FormScale {
    let range = |axis: usize| {
        let of = feet.iter().map(|f| f.point_mm[axis]);
        of.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
    };
    let middle = |axis: usize| {
        let (low, high) = range(axis);
        if low.is_finite() { 0.5 * (low + high) } else { 0.0 }
    };
    let middle_mm = Point3::new(middle(0), middle(1), 0.0);
    let half_mm = [0, 1].map(|axis| 0.5 * (range(axis).1 - range(axis).0));
    let is_within = (0..2).all(|k| middle_mm[k].abs() < WELL_WITHIN * half_mm[k]);
    let center_mm = if is_within { Point3::origin() } else { middle_mm };
    let reach = |f: &NominalFoot| (f.point_mm - center_mm).xy().norm();
    let radius_mm = feet.iter().map(reach).fold(f64::MIN_POSITIVE, f64::max);
    FormScale { center_mm, radius_mm }
}

fn layout(touches: &[MeasuredTouch], standards: &[Standard], sigma_declared: bool) -> Layout {
    let mut layout = Layout { unit: "mm".to_owned(), sigma_declared, ..Layout::default() };
    let mut index = std::collections::HashMap::new();
    for touch in touches {
        let check = touch.role == Role::Check;
        let group = *index.entry((touch.group.as_str(), check)).or_insert_with(|| {
            layout.groups.push(Group { name: touch.group.clone(), role: touch.role });
            layout.groups.len() - 1
        });
        push(&mut layout, group, touch.touch.sigma_mm, true);
    }
    for standard in standards {
        layout.groups.push(Group { name: "standard".to_owned(), role: Role::Prior });
        let group = layout.groups.len() - 1;
        push(&mut layout, group, standard.sigma, false);
    }
    layout
}

fn push(layout: &mut Layout, group: usize, sigma: f64, reported: bool) {
    let observation = layout.observations.len();
    layout.observations.push(group);
    layout.rows.push(Row { observation, component: 0, sigma, reported });
}
