//! The whole picture: views from above side by side, one in perspective below, with what they say.

use glam::Vec3;

use super::canvas::{Canvas, linear};
use super::dot::{Bounds, Dot, Viewer};
use super::lettering::Lettering;
use super::perspective::{self, Direction, Eye};
use super::top_view::{self, Plan, draw_scale_and_north, draw_viewer, light_of};

const WIDTH: usize = 2100;
const MARGIN: usize = 36;
const GAP: usize = 24;
/// Height of the perspective, pixels.
const PERSPECTIVE_HEIGHT: usize = 960;
/// From which side the perspective looks.
const FROM: Direction = Direction { azimuth_rad: 2.80, elevation_rad: 0.75, view_rad: 0.7 };
/// What is closer than this to the cloud's upper end is cut away: the ceiling, m.
const CEILING_M: f64 = 0.35;
/// Walls are as thick as this, m.
const WALL_M: f64 = 0.3;
/// Points that may lie outside the box on each side.
const STRAYS: f64 = 0.002;
/// Length of the line to where a camera looks, in perspective, m.
const MARKER_M: f64 = 0.6;
/// Heights of letters, pixels.
const TITLE: f32 = 34.0;
const CAPTION: f32 = 22.0;
const NOTE: f32 = 15.0;

/// One view from above.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// What it shows.
    pub caption: String,
    /// What was measured of it, a line each.
    pub notes: Vec<String>,
    /// The points.
    pub dots: &'a [Dot],
    /// The cameras, as these points were placed by them.
    pub viewers: Vec<Viewer>,
}

/// All that is in the picture.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    /// Above everything.
    pub title: String,
    /// A line below.
    pub subtitle: String,
    /// Views from above, from left to right. The last one says what room the others are drawn in, and is the one
    /// in perspective.
    pub panels: Vec<Panel<'a>>,
    /// Below the perspective.
    pub perspective_caption: String,
    /// Names of the cameras, in the order of the bits of [`Dot::seen_by`].
    pub cameras: Vec<String>,
    /// How large a point is drawn, m.
    pub dot_m: f64,
}

impl Page<'_> {
    /// Draws it; `None` where the last panel has no points.
    pub fn draw(&self) -> Option<Canvas> {
        let last = self.panels.last()?;
        let room = Bounds::of(last.dots, STRAYS)?;
        let plan = Plan::of(Self::plan_box(room), self.panel_width());
        let notes = self.panels.iter().map(|panel| panel.notes.len()).max().unwrap_or(0);
        let panels_top = MARGIN + (TITLE + 3.4 * NOTE) as usize + GAP;
        let map_top = panels_top + (CAPTION * 1.5 + notes as f32 * NOTE * 1.75 + NOTE) as usize;
        let below = map_top + plan.size()[1] + GAP;
        let height = below + PERSPECTIVE_HEIGHT + (2.8 * NOTE) as usize + MARGIN;

        let mut page = Canvas::new(WIDTH, height, paper());
        self.draw_head(&mut page);
        for (index, panel) in self.panels.iter().enumerate() {
            let left = MARGIN + index * (self.panel_width() + GAP);
            draw_words(&mut page, panel, [left, panels_top]);
            page.paste(&self.map(panel, &plan), left, map_top);
        }
        page.paste(&self.perspective(last, room), MARGIN, below);
        let line = (below + PERSPECTIVE_HEIGHT) as f32 + 2.2 * NOTE;
        Lettering::new(NOTE, grey()).draw(
            &mut page,
            [MARGIN as f32, line],
            &self.perspective_caption,
        );
        Some(page)
    }

    fn panel_width(&self) -> usize {
        let panels = self.panels.len().max(1);
        (WIDTH - 2 * MARGIN - (panels - 1) * GAP) / panels
    }

    /// The room with some space around it, without its ceiling.
    fn plan_box(room: Bounds) -> Bounds {
        let mut wide = room.grown(0.08 * room.size().x.max(room.size().y));
        wide.high.z = room.high.z - CEILING_M;
        wide
    }

    fn map(&self, panel: &Panel<'_>, plan: &Plan) -> Canvas {
        let mut map = top_view::draw(panel.dots, self.dot_m, plan, ground());
        for (camera, viewer) in panel.viewers.iter().enumerate() {
            draw_viewer(&mut map, plan, viewer, light_of(camera), NOTE);
        }
        draw_scale_and_north(&mut map, plan, NOTE);
        map
    }

    fn perspective(&self, panel: &Panel<'_>, room: Bounds) -> Canvas {
        let mut open = room;
        open.high.z -= CEILING_M;
        let eye = Eye::on(open, FROM, [WIDTH - 2 * MARGIN, PERSPECTIVE_HEIGHT]);
        let inner = room.grown(-WALL_M);
        let shown = panel.dots.iter().copied().filter(|dot| {
            dot.position_m.z < open.high.z && !eye.is_behind_wall(inner, dot.position_m)
        });
        let mut view = perspective::draw(shown, self.dot_m * 1.3, &eye, ground());
        for (camera, viewer) in panel.viewers.iter().enumerate() {
            draw_marker(&mut view, &eye, viewer, light_of(camera));
        }
        view
    }

    /// Title, and which light is which camera's.
    fn draw_head(&self, page: &mut Canvas) {
        let (left, line) = (MARGIN as f32, MARGIN as f32 + TITLE);
        Lettering::new(TITLE, Vec3::ONE).bold().draw(page, [left, line], &self.title);
        let note = Lettering::new(NOTE, grey());
        note.draw(page, [left, line + 2.6 * NOTE], &self.subtitle);

        let both = (!self.cameras.is_empty()).then(|| ("both".to_owned(), Vec3::ONE));
        let each = self.cameras.iter().enumerate();
        let lights = each.map(|(n, name)| (name.clone(), light_of(n))).chain(both);
        let mut right = (WIDTH - MARGIN) as f32;
        for (name, colour) in lights.collect::<Vec<_>>().into_iter().rev() {
            right -= note.width(&name);
            note.draw(page, [right, line], &name);
            right -= NOTE * 1.2;
            page.disc([right, line - NOTE / 2.0].into(), NOTE * 0.55, (colour, 1.0));
            right -= NOTE * 2.0;
        }
    }
}

/// Where a camera is, and a line to where it looks.
fn draw_marker(view: &mut Canvas, eye: &Eye, viewer: &Viewer, colour: Vec3) {
    let ahead = viewer.position_m + viewer.forward * MARKER_M;
    let ends = [viewer.position_m, ahead].map(|end| eye.project(end).map(|(at, _)| at));
    let [Some(at), Some(ahead)] = ends else { return };
    view.line([at, ahead], 5.0, (Vec3::ZERO, 0.6));
    view.line([at, ahead], 3.0, (colour, 1.0));
    view.disc(at, NOTE * 0.60, (Vec3::ONE, 1.0));
    view.disc(at, NOTE * 0.42, (colour, 1.0));
    let name = Lettering::new(NOTE, Vec3::ONE).bold();
    name.draw_centred(view, [at.x, at.y - NOTE], &viewer.name);
}

fn draw_words(page: &mut Canvas, panel: &Panel<'_>, [left, top]: [usize; 2]) {
    let (left, mut line) = (left as f32, top as f32 + CAPTION);
    Lettering::new(CAPTION, Vec3::ONE).bold().draw(page, [left, line], &panel.caption);
    line += CAPTION * 0.5;
    for note in &panel.notes {
        line += NOTE * 1.75;
        Lettering::new(NOTE, grey()).draw(page, [left, line], note);
    }
}

/// Behind everything.
fn paper() -> Vec3 {
    linear([24, 27, 33])
}

/// Behind points.
fn ground() -> Vec3 {
    linear([9, 11, 14])
}

fn grey() -> Vec3 {
    linear([196, 202, 210])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn room() -> Vec<Dot> {
        let wall = |n: u32| {
            let (i, j) = (f64::from(n % 100) / 100.0, f64::from(n / 100 % 50) / 20.0);
            let position_m = match n / 5000 {
                0 => DVec3::new(8.0 * i, 0.0, j),
                1 => DVec3::new(8.0 * i, 6.0, j),
                2 => DVec3::new(0.0, 6.0 * i, j),
                _ => DVec3::new(8.0, 6.0 * i, j),
            };
            Dot { position_m, colour: [200, 180, 160], seen_by: 1 + n % 2 }
        };
        (0..20_000).map(wall).collect()
    }

    fn page(dots: &[Dot]) -> Page<'_> {
        let panel = |caption: &str| Panel {
            caption: caption.into(),
            notes: vec!["RMSE 0.031 m".into()],
            dots,
            viewers: Vec::new(),
        };
        Page {
            title: "Clouds that fit".into(),
            subtitle: String::new(),
            panels: vec![panel("before"), panel("after")],
            perspective_caption: String::new(),
            cameras: vec!["front".into(), "rear".into()],
            dot_m: 0.05,
        }
    }

    #[test]
    fn the_page_is_as_large_as_its_parts_and_shows_the_cloud_in_each() {
        let dots = room();
        let drawn = page(&dots).draw().unwrap();
        assert_eq!(drawn.width(), WIDTH);
        let lit = |x: std::ops::Range<usize>, y: std::ops::Range<usize>| {
            let bright = |(x, y): &(usize, usize)| drawn.at(*x, *y).max_element() > 0.3;
            y.flat_map(|y| x.clone().map(move |x| (x, y))).filter(bright).count()
        };
        let map_height = drawn.height() - PERSPECTIVE_HEIGHT;
        assert!(lit(MARGIN..WIDTH / 2, 200..map_height) > 3000, "the first view from above");
        assert!(lit(WIDTH / 2..WIDTH, 200..map_height) > 3000, "the second");
        assert!(lit(0..WIDTH, map_height..drawn.height()) > 100_000, "the perspective");
    }

    #[test]
    fn without_points_there_is_no_picture() {
        assert!(page(&[]).draw().is_none());
    }
}
