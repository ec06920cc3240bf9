use std::fmt;

use force_impedance::{
    Discretisation, ForceImpedanceError, ImpedanceParameters, LoopSettings, ReferenceMode,
    design_point, recommend,
};
use serde::Serialize;
use truing_report::Stability;

use crate::Header;
use crate::text_table::TextTable;

/// Contacts on the card, evenly in logarithm over the range.
const N_CONTACTS: u32 = 7;
/// Dampings in the picture of the stable region, four to a decade, and contacts.
const N_DAMPINGS: u32 = 17;
const N_COLUMNS: u32 = 41;

/// What the design card of a force loop is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceDesignInput {
    /// Softest and stiffest contact.
    pub contact_n_per_mm: [f64; 2],
    /// Impedance; `None` takes the recommended one.
    pub parameters: Option<ImpedanceParameters>,
    /// Sampling interval.
    pub interval_s: f64,
    /// Time from a sample to the moment when its command begins to act.
    pub delay_s: f64,
    /// Time constant with which the legs follow their command.
    pub lag_s: f64,
    /// Settling time wanted.
    pub settling_s: f64,
    /// What the correction is counted from.
    pub mode: ReferenceMode,
}

/// The card; serialises as its JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForceDesign {
    /// Form, program, inputs and provenance.
    #[serde(flatten)]
    pub header: Header,
    /// `M`.
    pub mass_kg: f64,
    /// `D`.
    pub damping_ns_per_mm: f64,
    /// `K`.
    pub stiffness_n_per_mm: f64,
    /// Whether these are the recommended ones.
    pub recommended: bool,
    /// Settling time wanted.
    pub settling_s: f64,
    /// Stiffness from which on the recommended parameters settle in that time; `None` where not
    /// even the stiffest contact does.
    pub met_from_n_per_mm: Option<f64>,
    /// From the softest to the stiffest.
    pub contacts: Vec<ContactDesign>,
    /// Which dampings are stable on which contact, the mass kept in proportion.
    pub region: StableRegion,
}

/// One contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactDesign {
    /// Its stiffness.
    pub contact_n_per_mm: f64,
    /// Whether the loop is stable.
    pub stable: bool,
    /// Factor by which the contact may be stiffer; `None` where it may be anything.
    pub gain_margin_ratio: Option<f64>,
    /// Phase that may be lost.
    pub phase_margin_deg: Option<f64>,
    /// Dead time that may be added.
    pub delay_margin_s: Option<f64>,
    /// Share of an error of the programmed path that stays.
    pub steady_error_ratio: f64,
    /// How far a step of the reference is overshot.
    pub overshoot_ratio: Option<f64>,
    /// Time to within 2 %.
    pub settling_s: Option<f64>,
}

/// Stability over damping and stiffness of the contact.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StableRegion {
    /// Rows, from the largest.
    pub damping_ns_per_mm: Vec<f64>,
    /// Columns, from the softest.
    pub contact_n_per_mm: Vec<f64>,
    /// One text per row: `#` margins of 6 dB and 45°, `+` stable, `·` unstable.
    pub rows: Vec<String>,
}

/// The card for an impedance, or for the one it recommends.
///
/// # Errors
///
/// [`ForceImpedanceError::InvalidSetting`], [`ForceImpedanceError::TooFastForSampling`].
pub fn design_force(input: &ForceDesignInput) -> Result<ForceDesign, ForceImpedanceError> {
    let settings = input.settings();
    let advice = recommend(&settings, input.contact_n_per_mm, input.settling_s)?;
    let p = input.parameters.unwrap_or(advice.parameters);
    let contacts = spaced(input.contact_n_per_mm, N_CONTACTS)
        .into_iter()
        .map(|contact| point(p, &settings, contact))
        .collect::<Result<_, _>>()?;
    Ok(ForceDesign {
        header: Header::without_case("truing/design-force/1", Vec::new()),
        mass_kg: p.mass_kg,
        damping_ns_per_mm: p.damping_ns_per_mm,
        stiffness_n_per_mm: p.stiffness_n_per_mm,
        recommended: input.parameters.is_none(),
        settling_s: input.settling_s,
        met_from_n_per_mm: advice.met_from_n_per_mm,
        contacts,
        region: region(p, &settings, input.contact_n_per_mm),
    })
}

/// Numbers evenly in logarithm, both ends included.
pub(super) fn spaced([low, high]: [f64; 2], n: u32) -> Vec<f64> {
    let share = |i: u32| f64::from(i) / f64::from(n - 1);
    let mut all: Vec<f64> = (0..n).map(|i| low * (high / low).powf(share(i))).collect();
    // Not the power's last digit.
    if let Some(last) = all.last_mut() {
        *last = high;
    }
    all
}

fn point(
    p: ImpedanceParameters,
    settings: &LoopSettings,
    contact_n_per_mm: f64,
) -> Result<ContactDesign, ForceImpedanceError> {
    let found = design_point(p, settings, contact_n_per_mm)?;
    Ok(ContactDesign {
        contact_n_per_mm,
        stable: found.stable,
        gain_margin_ratio: Some(found.gain_margin_ratio).filter(|m| m.is_finite()),
        phase_margin_deg: found.phase_margin_rad.map(f64::to_degrees),
        delay_margin_s: found.delay_margin_s.filter(|_| found.stable),
        steady_error_ratio: found.steady_error_ratio,
        overshoot_ratio: found.overshoot_ratio,
        settling_s: found.settling_s,
    })
}

impl ForceDesignInput {
    pub(super) fn settings(&self) -> LoopSettings {
        LoopSettings {
            interval_s: self.interval_s,
            delay_s: self.delay_s,
            lag_s: self.lag_s,
            discretisation: Discretisation::ExactHold,
            mode: self.mode,
        }
    }
}

/// A hundred times to a hundredth of the card's damping, from the largest.
pub(super) fn dampings(p: ImpedanceParameters, n: u32) -> Vec<f64> {
    let mut dampings = spaced([1e-2 * p.damping_ns_per_mm, 1e2 * p.damping_ns_per_mm], n);
    dampings.reverse();
    dampings
}

/// What the loop is at each damping on each contact, the mass in proportion to the damping.
pub(super) fn cells(
    p: ImpedanceParameters,
    settings: &LoopSettings,
    dampings: &[f64],
    contacts: &[f64],
) -> Vec<Vec<Stability>> {
    let row = |damping: &f64| {
        let scaled = ImpedanceParameters {
            mass_kg: p.mass_kg * damping / p.damping_ns_per_mm,
            damping_ns_per_mm: *damping,
            ..p
        };
        let at = |contact: &f64| match force_impedance::margins_at(scaled, settings, *contact) {
            Ok(m) if m.is_comfortable() => Stability::Comfortable,
            Ok(m) if m.gain_ratio > 1.0 => Stability::Stable,
            _ => Stability::Unstable,
        };
        contacts.iter().map(at).collect()
    };
    dampings.iter().map(row).collect()
}

fn region(p: ImpedanceParameters, settings: &LoopSettings, range: [f64; 2]) -> StableRegion {
    let contacts = spaced(range, N_COLUMNS);
    let dampings = dampings(p, N_DAMPINGS);
    let sign = |at: Stability| match at {
        Stability::Comfortable => '#',
        Stability::Stable => '+',
        Stability::Unstable => '·',
    };
    let cells = cells(p, settings, &dampings, &contacts);
    StableRegion {
        rows: cells.into_iter().map(|row| row.into_iter().map(sign).collect()).collect(),
        damping_ns_per_mm: dampings,
        contact_n_per_mm: contacts,
    }
}

impl fmt::Display for ForceDesign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let how = if self.recommended { "recommended" } else { "given" };
        writeln!(
            f,
            "impedance, {how}: M = {:.4} kg, D = {:.4} N·s/mm, K = {:.4} N/mm",
            self.mass_kg, self.damping_ns_per_mm, self.stiffness_n_per_mm
        )?;
        match self.met_from_n_per_mm {
            Some(from) => writeln!(
                f,
                "the recommended one settles within {} s on contacts from {from:.1} N/mm on",
                self.settling_s
            )?,
            None => writeln!(
                f,
                "no contact of the range settles within {} s with margins of 6 dB and 45°",
                self.settling_s
            )?,
        }
        let columns = [
            "contact N/mm",
            "stable",
            "gain margin",
            "phase margin °",
            "delay margin ms",
            "steady error %",
            "overshoot %",
            "settling s",
        ];
        let mut table = TextTable::new("contacts", &columns);
        for c in &self.contacts {
            table.push(vec![
                c.contact_n_per_mm.into(),
                if c.stable { "yes" } else { "NO" }.to_owned().into(),
                c.gain_margin_ratio.into(),
                c.phase_margin_deg.into(),
                c.delay_margin_s.map(|s| 1e3 * s).into(),
                (100.0 * c.steady_error_ratio).into(),
                c.overshoot_ratio.map(|o| 100.0 * o).into(),
                c.settling_s.into(),
            ]);
        }
        writeln!(f, "\n{table}")?;
        writeln!(f, "damping over contact stiffness: # margins of 6 dB and 45°, + stable, · not")?;
        for (damping, row) in self.region.damping_ns_per_mm.iter().zip(&self.region.rows) {
            writeln!(f, "{damping:>12.4}  {row}")?;
        }
        let (from, to) = (self.contacts.first(), self.contacts.last());
        if let (Some(from), Some(to)) = (from, to) {
            let [from, to] = [from, to].map(|c| format!("{:.0}", c.contact_n_per_mm));
            writeln!(f, "{:>12}  {from}{to:>width$} N/mm", "", width = 41 - from.len())?;
        }
        Ok(())
    }
}
