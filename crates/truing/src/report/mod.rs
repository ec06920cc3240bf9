//! Renders what was measured, found and left as one self-contained HTML page.
//!
//! [`render`] is a pure function from plain data to a page: inline SVG, inline CSS, no network,
//! complete without JavaScript. [`IndexEntry::from_page`] reads a page's summary back
//! and [`render_index`] links many of them from one page, with their error before → after.
//!
//! Residuals and errors are in the unit of [`model_discrepancy::Layout::unit`] and are shown in
//! one unit chosen for the page (µm where mm would need too many zeros). Every «±» on a page is
//! an expanded uncertainty with coverage factor k = 2.

mod input;

mod markup;
pub(crate) mod number;
mod unit;

mod axis;
mod deviation_map;
mod even_axes;
mod heatmap;
mod interval;
mod layer;
mod panel;
mod region;
mod score_chart;
mod svg;
mod vector_map;

mod reading;
mod thin;
mod trend;

mod section;
mod summary;

mod design_card;
mod index;
mod page;

#[cfg(test)]
mod tests;

pub(crate) use design_card::render_design;
pub(crate) use region::{Region, Stability};

pub use index::{IndexEntry, ReadPageError, render_index};
pub use input::{
    Arrow, Curve, CurvePlot, DeviationMap, Evidence, ExtraPlot, Facet, Fact, Mistake, ParameterRow,
    Published, ReportInput, Story, VectorMap,
};
pub use page::render;
pub use summary::{Rms, Summary};
