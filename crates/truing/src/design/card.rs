//! The design card of a force loop as a page.

use force_impedance::{ImpedanceParameters, ReferenceMode};
use truing_report::{
    DesignCard, Fact, Figure, FigureTable, Region, RegionFigure, render_design, significant,
};

use super::force::{cells, dampings, spaced};
use super::{ContactDesign, ForceDesign, ForceDesignInput};

/// Dampings and contacts of the picture, as fine as its lines.
const N_DAMPINGS: u32 = 61;
const N_COLUMNS: u32 = 81;

const CAPTION: &str = "Damping over the stiffness of the contact, the mass kept in proportion to \
                       the damping. The dashed line is the damping of this card.";

const COLUMNS: [&str; 8] = [
    "contact, N/mm",
    "stable",
    "gain margin",
    "phase margin, °",
    "delay margin, ms",
    "steady error",
    "overshoot",
    "settling, s",
];

/// The card as one self-contained HTML page, the stable region as a picture.
#[must_use]
pub fn force_report(input: &ForceDesignInput, design: &ForceDesign) -> String {
    let rows: Vec<Vec<Figure>> = design.contacts.iter().map(figures).collect();
    render_design(&DesignCard {
        title: "Design card of a force loop",
        lede: &settles(design),
        facts: ("Impedance and loop", &known(input, design)),
        region: RegionFigure {
            heading: "Stable region",
            caption: CAPTION,
            region: &region(input, design),
            legend: ["margins of 6 dB and 45°", "stable, with less", "unstable"],
        },
        figures: FigureTable {
            heading: "Contacts",
            caption: "Margins and response on each contact",
            columns: &COLUMNS,
            rows: &rows,
        },
    })
}

fn region(input: &ForceDesignInput, design: &ForceDesign) -> Region {
    let parameters = ImpedanceParameters {
        mass_kg: design.mass_kg,
        damping_ns_per_mm: design.damping_ns_per_mm,
        stiffness_n_per_mm: design.stiffness_n_per_mm,
    };
    let contacts = spaced(input.contact_n_per_mm, N_COLUMNS);
    let dampings = dampings(parameters, N_DAMPINGS);
    let unstable = design.contacts.iter().filter(|c| !c.stable).count();
    Region {
        alternative: format!(
            "Stable region: damping over contact stiffness; at the damping of the card {} of {} \
             contacts are stable.",
            design.contacts.len() - unstable,
            design.contacts.len()
        ),
        x_title: "contact stiffness, N/mm".to_owned(),
        y_title: "damping, N·s/mm".to_owned(),
        cells: cells(parameters, &input.settings(), &dampings, &contacts),
        x: contacts,
        y: dampings,
        chosen: design.damping_ns_per_mm,
    }
}

fn settles(design: &ForceDesign) -> String {
    let wanted = significant(design.settling_s, 3);
    match design.met_from_n_per_mm {
        Some(from) => format!(
            "The recommended impedance settles within {wanted} s on contacts from {} N/mm on.",
            significant(from, 3)
        ),
        None => format!(
            "No contact of the range settles within {wanted} s with margins of 6 dB and 45°."
        ),
    }
}

fn known(input: &ForceDesignInput, design: &ForceDesign) -> Vec<Fact> {
    let how = if design.recommended { "recommended" } else { "given" };
    let counted = match input.mode {
        ReferenceMode::Rebased => "where the tool stands",
        ReferenceMode::Absolute => "the programmed path",
    };
    let number = |value: f64, unit: &str| format!("{} {unit}", significant(value, 4));
    [
        ("impedance", how.to_owned()),
        ("mass M", number(design.mass_kg, "kg")),
        ("damping D", number(design.damping_ns_per_mm, "N·s/mm")),
        ("stiffness K", number(design.stiffness_n_per_mm, "N/mm")),
        ("sampling interval", number(1e3 * input.interval_s, "ms")),
        ("delay", number(1e3 * input.delay_s, "ms")),
        ("lag of the legs", number(1e3 * input.lag_s, "ms")),
        ("correction counted from", counted.to_owned()),
    ]
    .map(|(name, value)| Fact { name: name.to_owned(), value })
    .to_vec()
}

fn figures(c: &ContactDesign) -> Vec<Figure> {
    vec![
        Figure::Number(Some(c.contact_n_per_mm)),
        Figure::Word(if c.stable { "yes" } else { "no" }),
        Figure::Number(c.gain_margin_ratio),
        Figure::Number(c.phase_margin_deg),
        Figure::Number(c.delay_margin_s.map(|s| 1e3 * s)),
        Figure::Share(Some(c.steady_error_ratio)),
        Figure::Share(c.overshoot_ratio),
        Figure::Number(c.settling_s),
    ]
}
