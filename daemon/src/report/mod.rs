//! Reports that people look at: one self-contained HTML file, charts as inline SVG.
//!
//! ```text
//! figures ─> scale ─> plot (axes, marks) ─> page (sections, tables, style) ─> report.html
//! ```
//!
//! No script, nothing loaded from anywhere. Colours are CSS custom properties, so that one chart
//! serves light and dark. Axes have the paper's colours: roll (about forward) red, pitch (about left)
//! green, yaw (about up) blue.

pub mod dynamic_report;
pub mod evaluation;
pub mod page;
pub mod plot;
pub mod scale;
pub mod static_report;
pub mod svg;
