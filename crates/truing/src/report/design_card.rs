//! The design card of a force loop as a page.

use super::markup::Markup;
use super::number::{NONE, percent, significant};
use super::page::document;
use super::region::Region;
use super::section::{Cell, Kind, facts, table};
use crate::design::{ContactDesign, ForceDesign, ForceDesignInput};

/// Widths of the picture on a wide and on a narrow page; the style sheet shows one of the two.
const WIDTHS: [(f64, &str); 2] = [(900.0, "plot wide"), (352.0, "plot narrow")];
const TITLE: &str = "Design card of a force loop";

/// One self-contained page.
pub(crate) fn render_design(
    input: &ForceDesignInput,
    design: &ForceDesign,
    region: &Region,
) -> String {
    let mut body = Markup::new();
    body.open("header", &[]);
    body.element("h1", &[], TITLE);
    body.element("p", &[("class", &"lede")], &settles(design));
    body.close("header");
    body.open("section", &[]);
    body.element("h2", &[], "Impedance and loop");
    facts(&mut body, known(input, design));
    body.close("section");
    body.open("section", &[]);
    body.element("h2", &[], "Stable region");
    body.element("p", &[], REGION);
    legend(&mut body);
    for (width, class) in WIDTHS {
        body.append(&region.draw(width, class));
    }
    body.close("section");
    body.open("section", &[]);
    body.element("h2", &[], "Contacts");
    contacts(&mut body, &design.contacts);
    body.close("section");
    document(TITLE, "page", &body)
}

const REGION: &str = "Damping over the stiffness of the contact, the mass kept in proportion to \
                      the damping. The dashed line is the damping of this card.";

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

fn known(input: &ForceDesignInput, design: &ForceDesign) -> Vec<(String, String)> {
    let how = if design.recommended { "recommended" } else { "given" };
    let counted = match input.mode {
        force_impedance::ReferenceMode::Rebased => "where the tool stands",
        force_impedance::ReferenceMode::Absolute => "the programmed path",
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
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

fn legend(out: &mut Markup) {
    out.open("p", &[("class", &"legend")]);
    for (class, text) in
        [("comfortable", "margins of 6 dB and 45°"), ("stable", "stable, with less")]
    {
        out.open("span", &[]);
        let mut sign = super::svg::open_sign(22.0);
        super::svg::rectangle(&mut sign, &format!("region {class}"), (1.0, 2.0), (21.0, 12.0));
        sign.close("svg");
        out.append(&sign);
        out.text(" ");
        out.text(text);
        out.close("span");
    }
    out.element("span", &[], "empty: unstable");
    out.close("p");
}

fn contacts(out: &mut Markup, contacts: &[ContactDesign]) {
    let columns = [
        ("contact, N/mm", Kind::Number),
        ("stable", Kind::Unit),
        ("gain margin", Kind::Number),
        ("phase margin, °", Kind::Number),
        ("delay margin, ms", Kind::Number),
        ("steady error", Kind::Number),
        ("overshoot", Kind::Number),
        ("settling, s", Kind::Number),
    ];
    let number = |value: Option<f64>| match value {
        Some(value) => Cell::number(significant(value, 3), value),
        None => Cell::new(NONE),
    };
    let share = |value: Option<f64>| match value {
        Some(value) => Cell::number(percent(value), value),
        None => Cell::new(NONE),
    };
    let row = |c: &ContactDesign| {
        vec![
            number(Some(c.contact_n_per_mm)),
            Cell::new(if c.stable { "yes" } else { "no" }),
            number(c.gain_margin_ratio),
            number(c.phase_margin_deg),
            number(c.delay_margin_s.map(|s| 1e3 * s)),
            share(Some(c.steady_error_ratio)),
            share(c.overshoot_ratio),
            number(c.settling_s),
        ]
    };
    table(out, "Margins and response on each contact", &columns, contacts.iter().map(row));
}
