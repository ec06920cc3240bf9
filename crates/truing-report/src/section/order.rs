//! The residual over measured order: one strip per component.

use super::{Context, MOST_COMPONENTS, for_both};
use crate::axis::{Range, Tick, drawable};
use crate::layer::{Layer, MarkStyle};
use crate::markup::{Markup, text_width};
use crate::number::{count, real, significant};
use crate::panel::{Axis, Panel};
use crate::reading::Reading;
use crate::svg::FONT;
use crate::trend;

/// Readings of one component drawn one by one; more are drawn as their spread.
const MOST_MARKS: usize = 600;
/// Stretches of which the spread is drawn.
const MOST_STRETCHES: usize = 240;
/// Readings that are named one by one, when pointed at and on the axis.
const NAMED: usize = 150;
/// Up to this many readings hang on stems.
const STEMMED: usize = 60;
/// Groups told apart by the background.
const MOST_GROUPS: usize = 100;

pub(super) fn order_figure(
    out: &mut Markup,
    context: &Context,
    readings: &[Reading],
    range: Range,
    model: &str,
) {
    out.open("figure", &[]);
    let components = context.components.len().min(MOST_COMPONENTS);
    for component in 0..components {
        let own: Vec<Reading> =
            readings.iter().filter(|r| r.component == component).copied().collect();
        let last = component + 1 == components;
        let strip = Strip { context, own, range, model, component, last };
        for_both(out, |width, class| strip.panel(width).draw(class));
    }
    out.element("figcaption", &[], &caption(context, readings));
    out.close("figure");
}

/// The residual of one component.
struct Strip<'a> {
    context: &'a Context<'a>,
    own: Vec<Reading>,
    range: Range,
    model: &'a str,
    component: usize,
    /// Whether it stands at the bottom and carries the labels of the common axis.
    last: bool,
}

impl Strip<'_> {
    fn panel(&self, width: f64) -> Panel {
        let context = self.context;
        let n = context.input.layout.observations.len();
        let mut x = Axis::new(Range { low: 0.3, high: real(n.max(1)) + 0.7 }, "");
        x.labelled = self.last;
        x.names = names_on_axis(context, width);
        x.title = order_title(context, x.names.is_some());
        let height = if context.components.len() == 1 { 230.0 } else { 150.0 };
        Panel {
            size: (width, if self.last { height + 28.0 } else { height }),
            x,
            y: Axis::new(self.range, self.y_title()),
            layers: self.layers(),
            alternative: self.alternative(),
        }
    }

    fn layers(&self) -> Vec<Layer> {
        let colour = self.component;
        let points: Vec<[f64; 2]> = self.own.iter().map(|r| [place(r), r.value]).collect();
        let mut layers = background(self.context, &self.own);
        if points.len() > MOST_MARKS {
            let spreads = trend::spreads(&points, MOST_STRETCHES);
            let all = spreads.iter().map(|s| [s.x, s.all[0], s.all[1]]);
            layers.push(Layer::Band { points: all.collect(), colour });
            let most = spreads.iter().map(|s| [s.x, s.two_thirds[0], s.two_thirds[1]]);
            layers.push(Layer::Band { points: most.collect(), colour });
        } else {
            if points.len() <= STEMMED {
                layers.push(Layer::Stems { points: points.clone(), colour });
            }
            layers.extend(mark_layers(&self.own, place, colour));
        }
        layers.push(Layer::Line { points: trend::means(&points), colour, trend: true });
        if points.len() <= NAMED {
            layers.push(Layer::Names { points: named(self.context, &self.own) });
        }
        layers
    }

    fn y_title(&self) -> String {
        if self.context.components.len() == 1 && self.context.input.components.is_empty() {
            self.context.shown.title("residual")
        } else {
            self.context.shown.title(&self.context.components[self.component])
        }
    }

    fn alternative(&self) -> String {
        let values = || self.own.iter().map(|r| r.value);
        format!(
            "Residual, {}, {}, over measured order: {} readings from {} to {} {}",
            self.context.components[self.component],
            self.model,
            count(self.own.len()),
            significant(values().fold(f64::INFINITY, f64::min), 3),
            significant(values().fold(f64::NEG_INFINITY, f64::max), 3),
            self.context.shown.unit
        )
    }
}

/// Measured order, from 1.
fn place(reading: &Reading) -> f64 {
    real(reading.observation + 1)
}

fn order_title(context: &Context, named: bool) -> String {
    let noun = if named { context.input.group_noun } else { "observation" };
    format!("{noun}, in the order measured")
}

/// Names of the groups under the axis, where each is one observation and the names fit.
fn names_on_axis(context: &Context, width: f64) -> Option<Vec<Tick>> {
    let layout = context.input.layout;
    let n = layout.observations.len();
    if n > NAMED || n != layout.groups.len() {
        return None;
    }
    let names = layout.observations.iter().enumerate().map(|(i, group)| {
        Some(Tick { at: real(i + 1), label: layout.groups.get(*group)?.name.clone() })
    });
    let names: Vec<Tick> = names.collect::<Option<_>>()?;
    let room = (width - 90.0) / real(n.max(1));
    names.iter().all(|t| text_width(&t.label, FONT) + 8.0 <= room).then_some(names)
}

/// Every second group as a stretch of background, and the band of declared noise.
fn background(context: &Context, own: &[Reading]) -> Vec<Layer> {
    let layout = context.input.layout;
    let mut layers = Vec::new();
    let runs: Vec<&[usize]> = layout.observations.chunk_by(|a, b| a == b).collect();
    if runs.len() < layout.observations.len() && (2..=MOST_GROUPS).contains(&runs.len()) {
        let mut at = 0.5;
        for (i, run) in runs.iter().enumerate() {
            let to = at + real(run.len());
            if i % 2 == 1 {
                layers.push(Layer::Stretch { from: at, to });
            }
            at = to;
        }
    }
    layers.extend(noise_strip(context, own));
    layers
}

/// ± two declared sigma, where one sigma holds for all.
fn noise_strip(context: &Context, own: &[Reading]) -> Option<Layer> {
    let first = own.first()?.sigma;
    let same = own.iter().all(|r| (r.sigma - first).abs() <= 1e-9 * first);
    let known = context.input.layout.sigma_declared && same && drawable(first);
    known.then_some(Layer::Strip { from: -2.0 * first, to: 2.0 * first })
}

/// Fitted readings filled, judged ones hollow.
pub(super) fn mark_layers(
    readings: &[Reading],
    x: impl Fn(&Reading) -> f64,
    colour: usize,
) -> Vec<Layer> {
    let many = readings.len() > NAMED;
    let of = |check: bool| -> Vec<[f64; 2]> {
        readings.iter().filter(|r| r.check == check).map(|r| [x(r), r.value]).collect()
    };
    let layer =
        |hollow| Layer::Marks { points: of(hollow), colour, style: MarkStyle { hollow, many } };
    vec![layer(false), layer(true)]
}

fn named(context: &Context, own: &[Reading]) -> Vec<([f64; 2], String)> {
    let layout = context.input.layout;
    let name = |r: &Reading| {
        let group = layout.observations.get(r.observation).and_then(|g| layout.groups.get(*g));
        let name = group.map_or("", |g| g.name.as_str());
        format!("{name}: {} {}", significant(r.value, 3), context.shown.unit)
    };
    own.iter().map(|r| ([place(r), r.value], name(r))).collect()
}

fn caption(context: &Context, readings: &[Reading]) -> String {
    let components = context.components.len();
    let per_component = readings.len() / components.max(1);
    let mut parts = vec![if per_component > MOST_MARKS {
        format!(
            "{} readings a component. Pale: all of them. Darker: what two thirds of \
             neighbouring readings lie between. Line: their mean.",
            count(per_component)
        )
    } else if components > 1 {
        "One mark per observation and component.".to_string()
    } else {
        "One mark per observation.".to_string()
    }];
    if per_component <= MOST_MARKS {
        if readings.iter().any(|r| r.check) {
            parts.push("Hollow: set aside to judge, never fitted.".to_string());
        }
        if per_component >= trend::LEAST {
            parts.push("Line: mean of neighbouring readings.".to_string());
        }
    }
    if noise_strip(context, readings).is_some() {
        parts.push("Shaded: ± two declared standard uncertainties.".to_string());
    }
    if components > MOST_COMPONENTS {
        parts.push(format!("The first {MOST_COMPONENTS} components are drawn."));
    }
    parts.join(" ")
}
