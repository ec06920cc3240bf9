use geometry::Foot;
mod discrepancy;

use model_discrepancy::{
    Covariate, Declared, Effect, Group, Layout, Parameter, Quantity, Role, Row, Shown, Sought,
    State, resolution_of,
};
use nalgebra::{Matrix3, Point3, Vector3};

use super::effects::{self, ratio};
use super::entry::{Entry, Setting};
use super::measured::MeasuredTouch;
use super::setup::{Setup, reported};
use super::term::{Contact, Distances, Term, combined};
use crate::exact::{Chart, Whitened};
use crate::{Noise, Part, PoseError, PoseOptions, PoseParameter, PoseStart, Touch, fit_pose};

/// Touches of a part of known surface, and the effects that its pose leaves out.
///
/// Residual: distance of the ball's centre from the surface less the ball's radius, along the
/// surface's normal, in mm of the reading; one row per touch. Side touches of the part follow as prior knowledge.
#[derive(Clone, Debug)]
pub struct PoseModel {
    pub(crate) part: Part,
    pub(crate) options: PoseOptions,
    pub(crate) touches: Vec<MeasuredTouch>,
    pub(crate) covariates: Vec<Covariate>,
    pub(crate) setups: Vec<Setup>,
    /// Setup of each touch.
    pub(crate) setup_of: Vec<usize>,
    /// Contacts at the reference pose.
    pub(crate) contacts: Vec<Foot>,
    pub(crate) free: Vec<usize>,
    pub(crate) standards: Vec<Standard>,
    /// Effects of the catalogue that the residual shows, the last in it.
    pub(crate) shown: Shown,
    declared: Declared,
    pub(super) terms: Vec<Term>,
    /// Mean of the readings, machine frame.
    pub(super) center_mm: Vector3<f64>,
}

/// Forms are taken where the touches are to this share of the radius to which they refer: a form of
/// third order is then off by three times as much of its height.
const NEAR: f64 = 0.01;

/// One amplitude measured by other means, as a proposal may have it.
#[derive(Clone, Debug)]
pub(crate) struct Standard {
    pub(crate) effect: &'static str,
    pub(crate) parameter: &'static str,
    pub(crate) sigma: f64,
}

impl PoseModel {
    /// Model of `touches`, in the order measured, starting from `start`.
    ///
    /// `covariates` are the columns recorded beside the touches, one value per touch: `time_s`
    /// drives the drift, every column ending in `_c` a thermal effect.
    ///
    /// # Errors
    ///
    /// As [`fit_pose`] on the touches to be fitted, and [`PoseError::InvalidCovariate`].
    pub fn new(
        part: Part,
        touches: Vec<MeasuredTouch>,
        covariates: &[Covariate],
        start: &PoseStart,
        options: &PoseOptions,
    ) -> Result<Self, PoseError> {
        for covariate in covariates {
            let finite = covariate.values.iter().all(|v| v.is_finite());
            if !finite || covariate.values.len() != touches.len() {
                let (covariate, needed) = (covariate.name.clone(), touches.len());
                return Err(PoseError::InvalidCovariate { covariate, needed });
            }
        }
        let fitted: Vec<Touch> =
            touches.iter().filter(|t| t.role != Role::Check).map(|t| t.touch).collect();
        let fit = fit_pose(&part, &fitted, start, options)?;
        let setup_of = vec![0; touches.len()];
        let starts = vec![fit.pose];
        let covariates = covariates.to_vec();
        let model = Self::about(part, touches, covariates, &starts, setup_of, options, vec![])?;
        Ok(model.with_what_shows())
    }

    /// The model with the patches and the courses of its drift that the residual shows.
    fn with_what_shows(self) -> Self {
        let places_mm = self.places_mm();
        let shown = Shown::of(&self, &State::start(&self), &self.sought(&places_mm));
        self.with_shown(shown)
    }

    /// The model with errors of form taken where the touches are on the part as it was found to lie,
    /// if that is far from where they were taken; else with the patch and the courses that the residual
    /// shows beside what was found. `None` where these are the ones that it has.
    ///
    /// Where the touches hardly show the place, an error of form that is not in the declared model
    /// moves it by a good part of the diameter, and about another place it is another form.
    #[must_use]
    pub fn about_found(&self, at: &State) -> Option<Self> {
        self.about_place(at).or_else(|| self.with_shown_beside(at))
    }

    /// Whether an effect whose term is one of these was found.
    fn has_found(&self, at: &State, is_one: impl Fn(&Term) -> bool) -> bool {
        self.terms.iter().enumerate().any(|(effect, term)| at.has(effect) && is_one(term))
    }

    /// The model about the place that was found; `None` where that is near the place at which it was
    /// taken, or no error of form was found.
    fn about_place(&self, at: &State) -> Option<Self> {
        // What is held would move with the pose.
        let is_held = self.has_found(at, |term| matches!(term, Term::Pose(_)));
        if is_held || !self.has_found(at, |term| matches!(term, Term::Form(_) | Term::Patch(_))) {
            return None;
        }
        let [setup] = &self.setups[..] else { return None };
        let chart = setup.chart(&self.free, &at.base, &[0.0; 6]);
        let far_mm = NEAR * self.part.form_radius_mm(&self.contacts);
        let away = (0..self.touches.len()).filter_map(|index| {
            let foot = self.foot(&chart, &self.touches[index].touch.center_mm)?;
            Some((foot.point_mm - self.contacts[index].point_mm).norm())
        });
        if away.fold(0.0, f64::max) < far_mm {
            return None;
        }
        let (part, touches) = (self.part.clone(), self.touches.clone());
        let (covariates, standards) = (self.covariates.clone(), self.standards.clone());
        let (starts, setup_of) = (vec![chart.pose()], self.setup_of.clone());
        let options = &self.options;
        Self::about(part, touches, covariates, &starts, setup_of, options, standards)
            .ok()
            .map(Self::with_what_shows)
    }

    /// The model in charts about `starts`; everything else is taken as checked.
    pub(crate) fn about(
        part: Part,
        touches: Vec<MeasuredTouch>,
        covariates: Vec<Covariate>,
        starts: &[PoseStart],
        setup_of: Vec<usize>,
        options: &PoseOptions,
        standards: Vec<Standard>,
    ) -> Result<Self, PoseError> {
        let free: Vec<usize> = (0..PoseParameter::ALL.len())
            .filter(|&i| !options.held.contains(&PoseParameter::ALL[i]))
            .collect();
        let pivot_mm = if free.starts_with(&[0, 1, 2]) { part.pivot_mm() } else { 0.0 };
        let lateral = options.lateral.as_ref().map(Whitened::new).transpose()?;
        let setups: Vec<Setup> = (starts.iter().enumerate())
            .map(|(k, start)| {
                let here = if k == 0 { lateral } else { lateral.map(|l| l.moved_to(start)) };
                Setup::new(start, pivot_mm, here, k * free.len())
            })
            .collect();
        let contacts = contacts(&part, &touches, &setups, &setup_of)?;
        let setting = setting(&part, options, &touches, &covariates, &contacts, &setups, &setup_of);
        let center_mm = setting.center_mm;
        let entries = effects::catalogue(&setting);
        let (effects, terms) =
            entries.into_iter().map(|Entry { effect, term }| (effect, term)).unzip();
        let base: Vec<Parameter> = (0..setups.len())
            .flat_map(|_| free.iter().map(|&i| base_parameter(PoseParameter::ALL[i])))
            .collect();
        let layout = layout(&touches, &setups, &standards, options.noise);
        let measured = touches.iter().flat_map(|t| t.touch.center_mm.iter().copied());
        let declared = Declared {
            resolution: resolution_of(measured),
            ..Declared::new(layout, base, effects)
        };
        let options = options.clone();
        Ok(Self {
            part,
            options,
            touches,
            covariates,
            setups,
            setup_of,
            contacts,
            free,
            standards,
            shown: Shown::default(),
            declared,
            terms,
            center_mm,
        })
    }

    /// Where each row lies; prior knowledge has no place.
    fn places_mm(&self) -> Vec<Option<Point3<f64>>> {
        let mut places: Vec<_> = self.contacts.iter().map(|foot| Some(foot.point_mm)).collect();
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
        self.declared.effects.extend(shown.patches.iter().map(|patch| patch.effect(&places_mm)));
        self.terms.extend(shown.patches.iter().copied().map(Term::Patch));
        for (drift, course) in &shown.courses {
            let Term::Drift { elapsed, axes } = &self.terms[*drift] else { continue };
            let is_timed = self.declared.effects[*drift].driver.is_some();
            let unit = if is_timed { "s" } else { "touches" };
            let effect = course.effect(&self, *drift, elapsed, unit, ("µm", 1e3));
            let term = Term::Drift { elapsed: course.come(elapsed), axes: axes.clone() };
            self.declared.effects.push(effect);
            self.terms.push(term);
        }
        self.shown = shown;
        self
    }

    /// The model with what its residual shows beside what was found; `None` where nothing would change.
    fn with_shown_beside(&self, found: &State) -> Option<Self> {
        let shown = self.shown.beside(self, found, &self.sought(&self.places_mm()));
        if shown == self.shown {
            return None;
        }
        let mut plain = self.clone();
        self.shown.take_off(&mut plain.declared, &mut plain.terms);
        Some(plain.with_shown(shown))
    }

    /// The given covariates and the places of the contacts (`part_x_mm`, `part_y_mm`,
    /// `part_radius_mm`), one value per observation.
    #[must_use]
    pub fn all_covariates(&self) -> Vec<Covariate> {
        let place = |name: &str, of: fn(&Foot) -> f64| {
            Covariate::coordinate(name, Quantity::Position, self.contacts.iter().map(of).collect())
        };
        let mut all = vec![
            place("part_x_mm", |f| f.point_mm.x),
            place("part_y_mm", |f| f.point_mm.y),
            place("part_radius_mm", |f| f.point_mm.coords.xy().norm()),
        ];
        all.extend(self.covariates.iter().cloned());
        // Prior knowledge has no place: the mean, which no shape turns on.
        for covariate in &mut all {
            let mean = covariate.values.iter().sum::<f64>() / ratio(covariate.values.len().max(1));
            covariate.values.resize(self.declared.layout.observations.len(), mean);
        }
        all
    }

    pub(super) fn chart(&self, setup: usize, at: &State) -> Chart {
        let mut extra = [0.0; 6];
        for (term, amplitudes) in self.terms.iter().zip(&at.amplitudes) {
            if let Term::Pose(parameters) = term {
                for (&parameter, &amplitude) in parameters.iter().zip(amplitudes.iter()) {
                    extra[parameter] += amplitude;
                }
            }
        }
        self.setups[setup].chart(&self.free, &at.base, &extra)
    }

    /// Effect and column of the amplitude that a standard knows.
    fn amplitude_of(&self, standard: &Standard) -> Option<(usize, usize)> {
        let of_effect = |(e, effect): (usize, &Effect)| {
            let column = effect.parameters.iter().position(|p| p.name == standard.parameter)?;
            (effect.id == standard.effect).then_some((e, column))
        };
        self.declared.effects.iter().enumerate().find_map(of_effect)
    }

    fn contact(&self, index: usize) -> Contact<'_> {
        let center_mm = self.touches[index].touch.center_mm.coords;
        Contact { observation: index, center_mm, foot: &self.contacts[index] }
    }

    fn distances(&self) -> Distances<'_> {
        Distances {
            shape: self.part.shape(),
            radius_mm: self.part.form_radius_mm(&self.contacts),
            side: side(&self.options),
        }
    }

    /// The reading less what the effects of the machine added to it, and what the others add to
    /// its distance.
    fn corrected(&self, index: usize, at: &State) -> (Point3<f64>, f64) {
        let contact = self.contact(index);
        let parts = self.distances();
        let (mut center_mm, mut added_mm) = (contact.center_mm, 0.0);
        for (term, amplitudes) in self.terms.iter().zip(&at.amplitudes) {
            if amplitudes.iter().all(|a| *a == 0.0) {
                continue;
            }
            center_mm -= combined(&term.readings(&contact), amplitudes);
            let distances = term.distances(&contact, &parts);
            added_mm += distances.iter().zip(amplitudes.iter()).map(|(d, a)| d * a).sum::<f64>();
        }
        (Point3::from(center_mm), added_mm)
    }

    /// What takes a reading to the place where the axes would be read right: apart from its reference.
    pub(super) fn sound(&self, at: &State) -> Matrix3<f64> {
        Matrix3::identity() - self.machine_errors(at)
    }

    /// `∂ distance / ∂ reading` of a touch, and its length: the noise is one of the readings, whatever the axes are
    /// found to add to them.
    fn read_along(&self, index: usize, chart: &Chart, sound: &Matrix3<f64>) -> (Vector3<f64>, f64) {
        let weights = sound.tr_mul(&chart.direction_to_machine(&self.contacts[index].normal));
        (weights, weights.norm().max(f64::MIN_POSITIVE))
    }

    fn foot(&self, chart: &Chart, center_mm: &Point3<f64>) -> Option<Foot> {
        self.part.surface().closest_point(&chart.in_workpiece(center_mm)).ok()
    }

    fn charts(&self, at: &State) -> Vec<Chart> {
        (0..self.setups.len()).map(|k| self.chart(k, at)).collect()
    }

    /// `∂ residual / ∂ [m α β γ]` of every row but the standards; NaN where there is no foot.
    fn pose_rows(&self, at: &State) -> Vec<(usize, [f64; 6])> {
        let (charts, sound) = (self.charts(at), self.sound(at));
        let mut rows = Vec::with_capacity(self.declared.layout.rows.len());
        for (index, &setup) in self.setup_of.iter().enumerate() {
            let chart = &charts[setup];
            let (center_mm, _) = self.corrected(index, at);
            let row = self.foot(chart, &center_mm).map_or([f64::NAN; 6], |foot| {
                chart.distance_row(&center_mm, &chart.direction_to_machine(&foot.normal))
            });
            let (_, length) = self.read_along(index, chart, &sound);
            rows.push((setup, row.map(|by_parameter| by_parameter / length)));
        }
        for (setup, chart) in charts.iter().enumerate() {
            if let Some(lateral) = &self.setups[setup].lateral {
                rows.extend(lateral.equations(chart).map(|(row, _)| (setup, row)));
            }
        }
        rows
    }
}

/// +1 or −1: the side of the part on which the ball is.
fn side(options: &PoseOptions) -> f64 {
    if options.tip.side == crate::TipSide::Above { 1.0 } else { -1.0 }
}

fn contacts(
    part: &Part,
    touches: &[MeasuredTouch],
    setups: &[Setup],
    setup_of: &[usize],
) -> Result<Vec<Foot>, PoseError> {
    let of = |(index, touch): (usize, &MeasuredTouch)| {
        let chart = setups[setup_of[index]].reference;
        let foot = part.surface().closest_point(&chart.in_workpiece(&touch.touch.center_mm));
        foot.map_err(|source| PoseError::NoFoot { index, source })
    };
    touches.iter().enumerate().map(of).collect()
}

fn setting<'a>(
    part: &'a Part,
    options: &'a PoseOptions,
    touches: &'a [MeasuredTouch],
    covariates: &'a [Covariate],
    contacts: &[Foot],
    setups: &[Setup],
    setup_of: &[usize],
) -> Setting<'a> {
    let n = ratio(touches.len().max(1));
    let sum = touches.iter().fold(Vector3::zeros(), |sum, t| sum + t.touch.center_mm.coords);
    let center_mm: Vector3<f64> = sum / n;
    let (mut normal_squares, mut travel_squares) = (Vector3::zeros(), Vector3::zeros());
    let normals: Vec<_> = (contacts.iter().zip(setup_of))
        .map(|(contact, &setup)| setups[setup].reference.direction_to_machine(&contact.normal))
        .collect();
    for (index, normal) in normals.iter().enumerate() {
        let squares = normal.component_mul(normal) / n;
        normal_squares += squares;
        travel_squares += squares * (touches[index].touch.center_mm.z - center_mm.z).powi(2);
    }
    Setting {
        part,
        held: &options.held,
        known: &options.known,
        machine_axes: options.machine_axes,
        form_radius_mm: part.form_radius_mm(contacts),
        touches,
        covariates,
        gamma_rad: setups[0].reference.angles.gamma_rad,
        center_mm,
        normals,
        side: side(options),
        normal_squares,
        lateral_travel_mm: travel_squares.map(f64::sqrt),
    }
}

fn base_parameter(parameter: PoseParameter) -> Parameter {
    let (unit, report_factor) = reported(parameter);
    Parameter { name: parameter.name().to_owned(), unit: unit.to_owned(), report_factor }
}

fn layout(
    touches: &[MeasuredTouch],
    setups: &[Setup],
    standards: &[Standard],
    noise: Noise,
) -> Layout {
    let mut layout = Layout {
        unit: "mm".to_owned(),
        sigma_declared: noise == Noise::Declared,
        ..Layout::default()
    };
    let mut index = std::collections::HashMap::new();
    for touch in touches {
        let check = touch.role == Role::Check;
        let group = *index.entry((touch.group.as_str(), check)).or_insert_with(|| {
            layout.groups.push(Group { name: touch.group.clone(), role: touch.role });
            layout.groups.len() - 1
        });
        push(&mut layout, group, touch.touch.sigma_mm, true);
    }
    let mut prior = |name: &str, sigma: f64| {
        layout.groups.push(Group { name: name.to_owned(), role: Role::Prior });
        let group = layout.groups.len() - 1;
        push(&mut layout, group, sigma, false);
    };
    for _ in setups.iter().filter(|s| s.lateral.is_some()) {
        // The equations of the side touches come whitened.
        prior("side touches along x", 1.0);
        prior("side touches along y", 1.0);
    }
    for standard in standards {
        prior("standard", standard.sigma);
    }
    layout
}

fn push(layout: &mut Layout, group: usize, sigma: f64, reported: bool) {
    let observation = layout.observations.len();
    layout.observations.push(group);
    layout.rows.push(Row { observation, component: 0, sigma, reported });
}
