#![doc = include_str!("../README.md")]

mod budget;
mod fact;
mod form;
mod input;

mod markup;
mod names;
mod number;
mod unit;
mod wording;

mod axis;
mod data_table;
mod deviation_map;
mod error_rms;
mod even_axes;
mod forest;
mod heatmap;
mod interval;
mod layer;
mod panel;
mod region;
mod score_chart;
mod slug;
mod svg;
mod vector_map;

mod reading;
mod thin;
mod trend;

mod section;
mod summary;

mod design_card;
mod index;
mod machine_page;
mod page;

#[cfg(test)]
mod tests;

pub use budget::{Budget, BudgetResult};
pub use design_card::{DesignCard, Figure, FigureTable, RegionFigure, render_design};
pub use error_rms::Rms;
pub use fact::Fact;
pub use form::{COMPENSATED, Form, FormLimit, FormResult};
pub use index::{IndexEntry, ReadPageError, render_index};
pub use input::{
    Arrow, Curve, CurvePlot, DeviationMap, Evidence, ExtraPlot, Facet, Mistake, ParameterRow,
    Published, ReportInput, Story, VectorMap,
};
pub use machine_page::{MachineAmplitude, MachineCase, MachineEffect, MachinePage, render_machine};
pub use model_discrepancy;
pub use names::{MOST_NAMES, shortened};
pub use number::{COVERAGE, significant, with_expanded};
pub use page::render;
pub use region::{Region, Stability};
pub use summary::Summary;
pub use wording::{after_number, by_sign, with_size};
