//! Pictures of clouds, drawn by a small renderer of coloured points.
//!
//! ```text
//! Dot, Viewer ─┬─> top_view (Plan) ───┐
//!              └─> perspective (Eye) ─┴─> page ─> Canvas ─> PNG
//! ```
//!
//! Plotting crates draw charts, and engines need a graphics card; a cloud from above and in perspective is a depth
//! buffer and some strokes.

mod canvas;
mod dot;
mod glyphs;
mod lettering;
mod page;
mod perspective;
mod png_file;
mod top_view;

pub use canvas::Canvas;
pub use dot::{Dot, Viewer};
pub use page::{Page, Panel};
pub use png_file::write_png;
