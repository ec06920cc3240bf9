//! The presses as a model for the loop.

mod discrepancy;

use model_discrepancy::{
    Covariate, Declared, Group, Layout, Quantity, Role, Row, Shown, Sought, State,
};
use nalgebra::DVector;

use crate::missing::parameter::parameter;
use crate::missing::press_design::{Design, PressPoint, REFERENCE_C, Standard};
use crate::missing::press_doubts::lost_spin;
use crate::missing::press_drag::drags;
use crate::missing::press_effects::{Catalogue, PressEffect};
use crate::missing::press_load::loads_n;
use crate::missing::sensor_errors::Reading;
use crate::press_noise::center_covariances;
use crate::{
    Contact, FtCenterError, LocateOptions, Located, PressRole, SensorFrame, SolvedPress, locate,
};

/// Presses, their planar frame, and what the frame leaves out.
///
/// Two rows per press of role `Frame` or `Check`: the solved centre mapped to the machine −
/// the machine's position, in mm. Effects act on the mean wrench of the press and on where the
/// machine says it is, not on the result.
///
/// Rows are weighed by the noise of the records, axis by axis in the machine frame, and by the
/// scatter from press to press that the loop finds beside it; the correlation of x and y within
/// a press, which only the noise of `Fz` makes, is left out.
#[derive(Clone, Debug)]
pub struct PressModel {
    pub(crate) declared: Declared,
    pub(crate) design: Design,
    /// One per observation of the layout that is a press.
    pub(crate) points: Vec<PressPoint>,
    pub(crate) standards: Vec<Standard>,
    /// Frame of the declared model.
    pub(crate) frame: SensorFrame,
    /// All presses given.
    pub(crate) presses: Vec<SolvedPress>,
    /// One per press given.
    pub(crate) all_points: Vec<PressPoint>,
    /// The last effects of the catalogue.
    shown: Shown,
    observed: Vec<usize>,
}

impl PressModel {
    /// Builds the model of a case of presses, in the order measured.
    ///
    /// `covariates` have one value per *observation*: per press of role `Frame` or `Check`, in
    /// input order; see [`PressModel::observed`]. A column whose name ends in `_c` becomes a
    /// `temperature` effect.
    ///
    /// # Errors
    ///
    /// As [`locate`](crate::locate), and [`FtCenterError::CovariateLength`].
    pub fn new(
        presses: &[SolvedPress],
        contact: &Contact,
        options: &LocateOptions,
        covariates: &[Covariate],
    ) -> Result<Self, FtCenterError> {
        let Located { frame, .. } = locate(presses, contact, options)?;
        let covariances_mm2 = center_covariances(presses, contact.z0_mm, options.noise)?;
        let observed: Vec<_> =
            (0..presses.len()).filter(|&i| presses[i].role != PressRole::Locate).collect();
        let warm: Vec<_> =
            covariates.iter().filter(|c| c.quantity == Quantity::Temperature).collect();
        if let Some(wrong) = covariates.iter().find(|c| c.values.len() != observed.len()) {
            let (got, needed) = (wrong.values.len(), observed.len());
            return Err(FtCenterError::CovariateLength { name: wrong.name.clone(), got, needed });
        }
        let elapsed = elapsed(presses);
        let drags_n = drags(presses, &covariances_mm2, contact.z0_mm);
        let point = |i: usize| {
            let observation = observed.iter().position(|&o| o == i);
            let warmth = |o: usize| warm.iter().map(|c| c.values[o] - REFERENCE_C).collect();
            PressPoint {
                machine_mm: presses[i].machine_mm,
                reading: Reading {
                    wrench: presses[i].orbit.mean_wrench,
                    drag_n: drags_n[i],
                    elapsed_ratio: elapsed[i],
                },
                covariance_mm2: covariances_mm2[i],
                warmth_k: observation.map_or_else(Vec::new, warmth),
                come: Vec::new(),
                observation,
            }
        };
        let all_points: Vec<_> = (0..presses.len()).map(point).collect();
        let fitted: Vec<_> = (observed.iter().enumerate())
            .filter(|(_, i)| presses[**i].role == PressRole::Frame)
            .map(|(observation, &i)| (observation, presses[i].name.clone()))
            .collect();
        let columns: Vec<_> = warm.iter().map(|c| c.name.clone()).collect();
        let role = |i: usize| match presses[i].role {
            PressRole::Frame => Role::Fit,
            PressRole::Check | PressRole::Locate => Role::Check,
        };
        let groups =
            observed.iter().map(|&i| Group { name: presses[i].name.clone(), role: role(i) });
        let (catalogue, effects) = Catalogue::new(&columns, &fitted);
        let pivot = frame.sensor_from_machine().apply(&frame.pivot_mm);
        let declared = Declared {
            layout: Layout {
                groups: groups.collect(),
                unit: "mm".to_owned(),
                sigma_declared: options.noise.is_some(),
                ..Layout::default()
            },
            base: vec![
                parameter("frame angle", "deg", 1f64.to_degrees()),
                parameter("frame translation x", "mm", 1.0),
                parameter("frame translation y", "mm", 1.0),
            ],
            start: DVector::from_column_slice(&[frame.angle_rad, pivot.x, pivot.y]),
            effects,
            findings: lost_spin(presses).into_iter().collect(),
            // A head seats anew on every press, which no record shows.
            between_variance: true,
            ..Declared::default()
        };
        let mut model = Self {
            declared,
            design: Design {
                z0_mm: contact.z0_mm,
                handedness: frame.handedness,
                pivot_mm: frame.pivot_mm,
                catalogue,
            },
            points: observed.iter().map(|&i| all_points[i].clone()).collect(),
            standards: Vec::new(),
            frame,
            presses: presses.to_vec(),
            all_points,
            shown: Shown::default(),
            observed,
        };
        model.lay_out();
        let elapsed = model.elapsed();
        let shown = Shown::of(&model, &State::start(&model), &model.sought(&elapsed));
        Ok(model.with_shown(shown))
    }

    /// What goes on evenly, as far as it is looked for along other courses.
    fn drifts(&self) -> Vec<usize> {
        let effects = self.design.catalogue.effects.iter().enumerate();
        let is_drift = |e: &PressEffect| matches!(e, PressEffect::Drift | PressEffect::MomentDrift);
        effects.filter(|(_, effect)| is_drift(effect)).map(|(index, _)| index).collect()
    }

    /// What is looked for in the residual. Presses are in the order made, as their records have times:
    /// a session need not lie among the others.
    fn sought<'a>(&self, elapsed: &'a [f64]) -> Sought<'a> {
        Sought { drifts: self.drifts(), elapsed, ..Sought::default() }
    }

    /// At each press, as a share of the session.
    fn elapsed(&self) -> Vec<f64> {
        self.points.iter().map(|p| p.reading.elapsed_ratio).collect()
    }

    /// The model with what its residual shows in the catalogue.
    fn with_shown(mut self, shown: Shown) -> Self {
        for (index, (drift, course)) in shown.courses.iter().enumerate() {
            let (of, reported) = match self.design.catalogue.effects[*drift] {
                PressEffect::MomentDrift => (PressEffect::MomentCourse(index), ("N·mm", 1.0)),
                _ => (PressEffect::Course(index), ("µm", 1e3)),
            };
            let effect = course.effect(&self, *drift, &self.elapsed(), "of the session", reported);
            self.declared.effects.push(effect);
            self.design.catalogue.effects.push(of);
        }
        self.shown = shown;
        for at in 0..self.points.len() {
            self.points[at].come = self.come(self.points[at].reading.elapsed_ratio);
        }
        for at in 0..self.all_points.len() {
            self.all_points[at].come = self.come(self.all_points[at].reading.elapsed_ratio);
        }
        self
    }

    /// The model with the courses of its drift that the residual shows beside what was found; `None`
    /// where these are the ones that it has.
    #[must_use]
    pub fn about_found(&self, found: &State) -> Option<Self> {
        let shown = self.shown.beside(self, found, &self.sought(&self.elapsed()));
        if shown == self.shown {
            return None;
        }
        Some(self.clone().without_shown().with_shown(shown))
    }

    /// The same after its rows have changed.
    pub(crate) fn shown_anew(self) -> Self {
        let shown = self.shown.clone();
        self.without_shown().with_shown(shown)
    }

    fn without_shown(mut self) -> Self {
        let terms = &mut self.design.catalogue.effects;
        std::mem::take(&mut self.shown).take_off(&mut self.declared, terms);
        self
    }

    /// How far a drift has come along each of its courses, at a share of the session.
    pub(crate) fn come(&self, elapsed_ratio: f64) -> Vec<f64> {
        self.shown.courses.iter().map(|(_, course)| course.come(&[elapsed_ratio])[0]).collect()
    }

    /// Index into the presses given of each observation of the layout.
    #[must_use]
    pub fn observed(&self) -> &[usize] {
        &self.observed
    }

    /// Position in the machine and mean load of each observation, as covariates for the loop: one load for all presses
    /// that differ by no more than noise.
    #[must_use]
    pub fn covariates(&self) -> Vec<Covariate> {
        let place = |name: &str, value: fn(&PressPoint) -> f64| {
            Covariate::coordinate(name, Quantity::Position, self.points.iter().map(value).collect())
        };
        vec![
            place("machine_x_mm", |p| p.machine_mm.x),
            place("machine_y_mm", |p| p.machine_mm.y),
            Covariate::coordinate("fz_n", Quantity::Other, loads_n(&self.design, &self.points)),
        ]
    }

    /// Adds a press as data to be fitted, as a design: its residual is of no meaning.
    pub(crate) fn add_point(&mut self, point: PressPoint) {
        let name = format!("proposed {}", self.points.len() + 1);
        self.declared.layout.groups.insert(self.points.len(), Group { name, role: Role::Fit });
        self.points.push(PressPoint { observation: None, ..point });
        self.lay_out();
    }

    /// Adds knowledge from outside, always fitted and never reported.
    pub(crate) fn add_standard(&mut self, standard: Standard) {
        self.declared.layout.groups.push(Group { name: "standard".to_owned(), role: Role::Prior });
        self.standards.push(standard);
        self.lay_out();
    }

    fn lay_out(&mut self) {
        let mut rows = Vec::new();
        let linear = self.frame.machine_from_sensor().linear;
        for (observation, point) in self.points.iter().enumerate() {
            let covariance = linear * point.covariance_mm2 * linear.transpose();
            for component in 0..2 {
                let sigma = covariance[(component, component)].sqrt();
                rows.push(Row { observation, component, sigma, reported: true });
            }
        }
        for (i, standard) in self.standards.iter().enumerate() {
            let observation = self.points.len() + i;
            for component in 0..standard.rows() {
                let sigma = standard.sigma();
                rows.push(Row { observation, component, sigma, reported: false });
            }
        }
        self.declared.layout.rows = rows;
        self.declared.layout.observations = (0..self.points.len() + self.standards.len()).collect();
    }
}

/// Share of the session that had passed at each press: by the clock where the records' times
/// follow each other, else by order.
fn elapsed(presses: &[SolvedPress]) -> Vec<f64> {
    let middle = |p: &SolvedPress| 0.5 * (p.orbit.span_s[0] + p.orbit.span_s[1]);
    let clocked = presses.windows(2).all(|w| w[0].orbit.span_s[1] < w[1].orbit.span_s[0]);
    let times: Vec<_> = (presses.iter().enumerate())
        .map(|(i, p)| if clocked { middle(p) } else { crate::count(i) })
        .collect();
    let (first, last) = (times[0], times[times.len() - 1]);
    let length = if last > first { last - first } else { 1.0 };
    times.iter().map(|t| (t - first) / length).collect()
}
