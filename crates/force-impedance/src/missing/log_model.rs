//! A log as a model for the loop.

mod discrepancy;

use std::sync::Arc;

use model_discrepancy::{
    Course, Covariate, Declared, Group, Layout, Quantity, Role, Row, Shown, Sought, State,
    resolution_of,
};

use crate::missing::log_blocks::{Block, Recorded, blocks, groups, ranges};
use crate::missing::log_delay::Record;
use crate::missing::log_effects::LogEffect;
use crate::{ForceFormula, ForceImpedanceError, Head, LogSample, LoggedForce, solve_log};

/// Effects of temperature count from here (ISO 1).
const REFERENCE_C: f64 = 20.0;
/// Fewest blocks from which a group's own error means anything.
const MIN_SAMPLES: usize = 12;

/// A recorded run averaged over blocks, and what the declared head leaves out.
///
/// One row per block: mean of (normal force from the legs − reference), N. Without a reference,
/// the disagreement of the four lengths, mm: forces have no second opinion then. The declared
/// model has no free parameters. Blocks keep the number of rows below some hundreds. Declared noise
/// is that of a sample, and the samples themselves are held against it: that of samples a
/// millisecond apart may depend on each other, and then their means scatter more than
/// independent ones.
#[derive(Clone, Debug)]
pub struct LogModel {
    pub(crate) declared: Declared,
    pub(crate) catalogue: Vec<LogEffect>,
    pub(crate) blocks: Vec<Block>,
    /// One per segment, in order; empty without a reference.
    pub(crate) records: Vec<Record>,
    /// Record of each block.
    pub(crate) record_of: Vec<usize>,
    pub(crate) has_reference: bool,
    pub(crate) log: Arc<Recorded>,
    /// Standard uncertainty of one force reading, where declared.
    pub(crate) sigma_n: Option<f64>,
    /// The last effects of the catalogue.
    pub(crate) shown: Shown,
}

/// Settings of a [`LogModel`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogOptions {
    /// How the normal force is had from the readings.
    pub formula: ForceFormula,
    /// Standard uncertainty of one force reading, cells and reference alike, where declared.
    pub sigma_n: Option<f64>,
    /// Name of each segment.
    pub segments: Vec<String>,
}

impl LogModel {
    /// Averages a log; `covariates` have one value per sample, columns that end in `_c` become
    /// `temperature` effects.
    ///
    /// # Errors
    ///
    /// As [`solve_log`], [`ForceImpedanceError::CovariateLength`], and
    /// [`ForceImpedanceError::TooFewSamples`] below twelve samples.
    pub fn new(
        head: &Head,
        samples: &[LogSample],
        options: &LogOptions,
        covariates: &[Covariate],
    ) -> Result<Self, ForceImpedanceError> {
        let solved = solve_log(head, samples, options.formula)?;
        if samples.len() < MIN_SAMPLES {
            let (got, needed) = (samples.len(), MIN_SAMPLES);
            return Err(ForceImpedanceError::TooFewSamples { got, needed });
        }
        if let Some(wrong) = covariates.iter().find(|c| c.values.len() != samples.len()) {
            let (got, needed) = (wrong.values.len(), samples.len());
            return Err(ForceImpedanceError::CovariateLength {
                name: wrong.name.clone(),
                got,
                needed,
            });
        }
        let warm: Vec<&Covariate> =
            covariates.iter().filter(|c| c.quantity == Quantity::Temperature).collect();
        let warmth_k: Vec<Vec<f64>> =
            warm.iter().map(|c| c.values.iter().map(|v| v - REFERENCE_C).collect()).collect();
        let names: Vec<String> = warm.iter().map(|c| c.name.clone()).collect();
        let published = options.formula == ForceFormula::Published;
        let is_placed = head.geometry().weight_n > 0.0;
        let catalogue = LogEffect::catalogue(published, is_placed, warm.len());
        let log = Recorded {
            head: *head,
            samples: samples.to_vec(),
            solved,
            formula: options.formula,
            warmth_k,
        };
        let blocks = blocks(&log, ranges(samples));
        let (records, record_of) = records(samples, &log.solved, &blocks);
        // The residual is a force where a reference was read, else a length.
        let read = |s: &LogSample| if s.reference_n.is_some() { s.cells_n } else { s.lengths_mm };
        let averaged = crate::count(samples.len()) / crate::count(blocks.len());
        let mut model = Self {
            declared: Declared {
                effects: catalogue.iter().map(|e| e.description(&names)).collect(),
                // Cells and reference read on from segment to segment.
                records: Some(vec![0; blocks.len()]),
                resolution: resolution_of(samples.iter().flat_map(read)) / averaged.sqrt(),
                ..Declared::default()
            },
            catalogue,
            has_reference: samples[0].reference_n.is_some(),
            blocks,
            records,
            record_of,
            log: Arc::new(log),
            sigma_n: options.sigma_n,
            shown: Shown::default(),
        };
        model.lay_out(options);
        let elapsed = model.elapsed();
        let shown = Shown::of(&model, &State::start(&model), &model.sought(&elapsed));
        Ok(model.with_shown(of_the_force(shown)))
    }

    /// What is looked for in the residual, where there is a force to drift.
    fn sought<'a>(&self, elapsed: &'a [f64]) -> Sought<'a> {
        let drifts = self.drift().filter(|_| self.has_reference).into_iter().collect();
        Sought { drifts, elapsed, ..Sought::default() }
    }

    /// At each block, as a share of the log's length.
    fn elapsed(&self) -> Vec<f64> {
        self.blocks.iter().map(|b| b.elapsed_share).collect()
    }

    fn drift(&self) -> Option<usize> {
        self.catalogue.iter().position(|e| *e == LogEffect::Drift)
    }

    /// The model with what its residual shows in the catalogue.
    fn with_shown(mut self, shown: Shown) -> Self {
        for (index, (drift, course)) in shown.courses.iter().enumerate() {
            let (elapsed, reported) = (self.elapsed(), ("N", 1.0));
            let effect = course.effect(&self, *drift, &elapsed, "of the log's length", reported);
            self.declared.effects.push(effect);
            self.catalogue.push(LogEffect::Course(index));
        }
        self.shown = shown;
        self
    }

    /// The model with the courses of its drift that the residual shows beside what was found; `None`
    /// where these are the ones that it has.
    #[must_use]
    pub fn about_found(&self, found: &State) -> Option<Self> {
        let there = self.shown.beside(self, found, &self.sought(&self.elapsed()));
        let shown = of_the_force(there);
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
        std::mem::take(&mut self.shown).take_off(&mut self.declared, &mut self.catalogue);
        self
    }

    /// What each sample says.
    #[must_use]
    pub fn solved(&self) -> &[LoggedForce] {
        &self.log.solved
    }

    /// Samples of a log that each observation of its model averages, known before it is made.
    #[must_use]
    pub fn ranges(samples: &[LogSample]) -> Vec<std::ops::Range<usize>> {
        ranges(samples).into_iter().map(|(_, range)| range).collect()
    }

    /// Samples that each observation of the layout averages.
    pub fn samples(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.blocks.iter().map(|b| b.samples.clone())
    }

    /// Means over the blocks of a column with one value per sample.
    #[must_use]
    pub fn averaged(&self, values: &[f64]) -> Vec<f64> {
        let mean = |b: &Block| {
            values[b.samples.clone()].iter().sum::<f64>() / crate::count(b.samples.len())
        };
        self.blocks.iter().map(mean).collect()
    }

    /// Force, tilt of the surface and length of the axial unit as covariates for the loop.
    #[must_use]
    pub fn covariates(&self, samples: &[LogSample]) -> Vec<Covariate> {
        let axial: Vec<f64> = samples.iter().map(|s| s.lengths_mm[3]).collect();
        // Half legs, half reference: the residual's own noise then does not follow it.
        let force = self
            .blocks
            .iter()
            .map(|b| if self.has_reference { b.normal_n - 0.5 * b.residual } else { b.normal_n });
        let tilt = |b: &Block| b.sensitivity.axial_share.clamp(-1.0, 1.0).acos().to_degrees();
        vec![
            Covariate::coordinate("contact_force_n", Quantity::Other, force.collect()),
            Covariate::coordinate(
                "surface_tilt_deg",
                Quantity::Angle,
                self.blocks.iter().map(tilt).collect(),
            ),
            Covariate::coordinate("l4_mm", Quantity::Position, self.averaged(&axial)),
        ]
    }

    /// What the effects in `at` add to the normal force from the legs, mean over each block, N.
    ///
    /// A delay is of the reference, and adds nothing to it.
    #[must_use]
    pub fn force_corrections_n(&self, at: &State) -> Vec<f64> {
        let of_force: Vec<(usize, &[f64])> = (at.amplitudes.iter().enumerate())
            .map(|(effect, amplitudes)| (effect, amplitudes.as_slice()))
            .filter(|(e, _)| at.has(*e) && self.catalogue[*e] != LogEffect::Delay)
            .collect();
        let of_block =
            |i: usize| of_force.iter().map(|&(e, a)| self.force_effect(e, a, i).0).sum::<f64>();
        (0..self.blocks.len()).map(of_block).collect()
    }

    /// Mean over each block of the normal force from the legs, N.
    #[must_use]
    pub fn forces_n(&self) -> Vec<f64> {
        self.blocks.iter().map(|b| b.normal_n).collect()
    }

    /// When the corrected force holds, and what the reference adds: one sentence per such effect.
    #[must_use]
    pub fn conditions(&self, at: &State) -> Vec<String> {
        let all = self.catalogue.iter().zip(&self.declared.effects).zip(&at.amplitudes);
        all.filter(|(_, amplitude)| amplitude.iter().any(|a| *a != 0.0))
            .map(|((kind, effect), _)| match kind {
                LogEffect::Delay => "the delay is of the reference: it is in the residual of the \
                                     blocks, and not in the corrected force"
                    .to_owned(),
                _ => format!(
                    "what {} adds to the force is in the corrections of the blocks, and taken off \
                     the contact force",
                    effect.id
                ),
            })
            .collect()
    }

    /// Adds blocks of a measurement that could be made, as a design.
    pub(crate) fn add_blocks(&mut self, more: Vec<Block>) {
        let sigma = self.declared.layout.rows.iter().map(|r| r.sigma).sum::<f64>()
            / crate::count(self.declared.layout.rows.len());
        for (i, block) in more.into_iter().enumerate() {
            // As many groups as the log has.
            let group = self.declared.layout.groups.len();
            self.declared
                .layout
                .groups
                .push(Group { name: format!("proposed {}", i + 1), role: Role::Fit });
            let observation = self.declared.layout.observations.len();
            self.declared.layout.observations.push(group);
            self.declared.layout.rows.push(Row {
                observation,
                component: 0,
                sigma,
                reported: true,
            });
            self.declared.records.get_or_insert_default().push(0);
            self.blocks.push(block);
        }
    }

    fn lay_out(&mut self, options: &LogOptions) {
        let (of_block, names) = groups(&self.blocks, &options.segments);
        let sigma_n = options.sigma_n.filter(|_| self.has_reference);
        let sigma = |b: &Block| {
            if self.has_reference { b.noise_gain * sigma_n.unwrap_or(1.0) } else { 1.0 }
        };
        let rows = self.blocks.iter().enumerate().map(|(observation, block)| {
            let share = crate::count(block.samples.len()).sqrt();
            Row { observation, component: 0, sigma: sigma(block) / share, reported: true }
        });
        self.declared.layout = Layout {
            rows: rows.collect(),
            observations: of_block,
            groups: names.into_iter().map(|name| Group { name, role: Role::Fit }).collect(),
            unit: if self.has_reference { "N" } else { "mm" }.to_owned(),
            sigma_declared: sigma_n.is_some(),
        };
    }

    /// What an effect of some amplitudes adds to a block's residual, and the derivatives.
    fn effect(&self, effect: usize, amplitudes: &[f64], i: usize) -> (f64, [f64; 2]) {
        self.effect_on(effect, amplitudes, (&self.blocks[i], self.record_of.get(i)))
    }

    /// [`LogModel::effect`] on a block of a record, or of none.
    pub(crate) fn effect_on(
        &self,
        effect: usize,
        amplitudes: &[f64],
        (block, record): (&Block, Option<&usize>),
    ) -> (f64, [f64; 2]) {
        let kind = self.catalogue[effect];
        if !self.has_reference {
            let slope = kind.consistency_tangent(block);
            return (slope * amplitudes[0], [slope, 0.0]);
        }
        self.force_effect_on(effect, amplitudes, (block, record))
    }

    /// What an effect of some amplitudes adds to the mean of normal force − reference in a block.
    fn force_effect(&self, effect: usize, amplitudes: &[f64], i: usize) -> (f64, [f64; 2]) {
        self.force_effect_on(effect, amplitudes, (&self.blocks[i], self.record_of.get(i)))
    }

    fn force_effect_on(
        &self,
        effect: usize,
        amplitudes: &[f64],
        (block, record): (&Block, Option<&usize>),
    ) -> (f64, [f64; 2]) {
        let kind = self.catalogue[effect];
        let amplitude = amplitudes[0];
        let (value, slope) = match kind {
            LogEffect::Delay => record.map_or((0.0, 0.0), |&record| {
                self.records[record].effect(&block.samples, amplitude)
            }),
            LogEffect::FrictionLeftOut => rubbed(block, amplitude),
            LogEffect::Course(index) => {
                let come = self.shown.courses[index].1.come(&[block.elapsed_share])[0];
                (come * amplitude, come)
            }
            LogEffect::CellGain(cell) => {
                // The cell reads `1 + a` times the force.
                let (read_n, gain) = (block.sensitivity.of_cell_n[cell], 1.0 + amplitude);
                (read_n * amplitude / gain, read_n / (gain * gain))
            }
            _ => {
                let slopes = kind.force_tangent(block);
                let value = amplitudes.iter().zip(slopes).map(|(a, slope)| a * slope).sum();
                return (value, slopes);
            }
        };
        (value, [slope, 0.0])
    }
}

/// What friction left out does to the published force of a block, and its derivative.
fn rubbed(block: &Block, mu: f64) -> (f64, f64) {
    let s = &block.sensitivity;
    let with = s.axial_share + mu * s.rub_share;
    // F_OT = F_n·(cos θ − µ t·u): the published formula reads F_OT/cos θ.
    let true_n = block.normal_n * s.axial_share / with;
    (block.normal_n - true_n, true_n * s.rub_share / with)
}

fn records(
    samples: &[LogSample],
    solved: &[LoggedForce],
    blocks: &[Block],
) -> (Vec<Record>, Vec<usize>) {
    let mut records = Vec::new();
    let mut ends = Vec::new();
    let mut start = 0;
    for run in samples.chunk_by(|a, b| a.segment == b.segment) {
        let forces = &solved[start..start + run.len()];
        let Some(record) = Record::of(run, forces, start) else { return (Vec::new(), Vec::new()) };
        records.push(record);
        start += run.len();
        ends.push(start);
    }
    let of = |b: &Block| ends.partition_point(|end| *end <= b.samples.start);
    (records, blocks.iter().map(of).collect())
}

/// Without what comes to rest with another beside it: that is of a leg, and not of the force.
fn of_the_force(mut shown: Shown) -> Shown {
    shown
        .courses
        .retain(|(_, course)| !matches!(course, Course::Settling(s) if s.leaves_another()));
    shown
}
