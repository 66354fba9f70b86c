//! `lodestone transforms`: the tree of frames.

use lodestone_client::FrameEdge;
use serde::Serialize;

use super::failure::Failure;
use super::json::numbers;
use super::output::Output;
use super::session::Session;
use super::world::patiently;

/// One edge; `null` stands for what is unknown, or moves.
#[derive(Debug, Serialize)]
struct EdgeLine<'a> {
    parent: &'a str,
    child: &'a str,
    moving: bool,
    translation_m: Option<[f64; 3]>,
    rotation_xyzw: Option<[f64; 4]>,
}

pub(super) fn run(session: &Session) -> Result<(), Failure> {
    session.cameras()?;
    let mut stream = session.client.transforms();
    let edges = patiently(session, || stream.tree())?;
    let mut output = Output::new();
    if session.json {
        return edges.iter().try_for_each(|edge| output.json(&EdgeLine::new(edge)));
    }
    output.line("world  (x east, y north, z up)")?;
    branches(&edges, "world", 1, &mut output)
}

/// The children of a frame, each with its own below it.
fn branches(
    edges: &[FrameEdge],
    parent: &str,
    depth: usize,
    output: &mut Output,
) -> Result<(), Failure> {
    // A tree is no deeper than it has edges; what runs in a circle is none.
    if depth > edges.len() {
        return Ok(());
    }
    for edge in edges.iter().filter(|edge| edge.parent() == parent) {
        output.line(&format!("{}{}  {}", "  ".repeat(depth), edge.child(), place(edge)))?;
        branches(edges, edge.child(), depth + 1, output)?;
    }
    Ok(())
}

fn place(edge: &FrameEdge) -> String {
    let Some(rotation) = edge.rotation() else { return "moves: see its pose".into() };
    let translation = edge.translation_m().map(|t| t.to_array());
    let at = match &translation {
        Some(_) => format!("at {} m", numbers(translation.as_ref(), 3)),
        None => "at a place that is not configured".into(),
    };
    format!("{at}, {} xyzw", numbers(Some(&rotation.to_array()), 4))
}

impl<'a> EdgeLine<'a> {
    fn new(edge: &'a FrameEdge) -> Self {
        Self {
            parent: edge.parent(),
            child: edge.child(),
            moving: edge.is_moving(),
            translation_m: edge.translation_m().map(|t| t.to_array()),
            rotation_xyzw: edge.rotation().map(|r| r.to_array()),
        }
    }
}
