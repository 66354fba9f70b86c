//! The demo's picture.

use glam::{DQuat, DVec3};
use lodestone_config::model::Config;

use super::outcome::{Cloud, Outcome};
use super::result::{MeanPose, Seen, SeenCamera, Variant};
use super::setup::CAMERAS;
use crate::picture::{Canvas, Dot, Page, Panel, Viewer};

/// Voxels with fewer points are strays of the noise, which would veil the picture.
const DRAWN_FROM: u32 = 3;
/// Edge of a drawn point, that of a voxel, m.
const DOT_M: f64 = 0.04;

/// Views from above, from left to right.
const PANELS: [(Variant, &str); 3] = [
    (Variant::WithoutMagnetometer, "Without the magnetometer"),
    (Variant::Lodestone, "Lodestone"),
    (Variant::Refined, "Refined by ICP"),
];

/// Draws it; `None` if there is nothing to draw.
pub fn draw(config: &Config, seen: &Seen, clouds: &[Cloud], outcome: &Outcome) -> Option<Canvas> {
    let dots = PANELS.map(|(variant, _)| dots_of(clouds, variant));
    let panels = PANELS.iter().zip(&dots).map(|((variant, caption), dots)| Panel {
        caption: (*caption).into(),
        notes: notes(outcome, *variant),
        dots,
        viewers: viewers(config, seen, *variant),
    });
    let page = Page {
        title: "Do the clouds of two cameras lie on each other?".into(),
        subtitle: format!(
            "Two ZED 2 in a room, simulated, that look in different directions; {} s of clouds, seed {}. \
             Seen from above, without the ceiling.",
            outcome.merged_s, outcome.seed
        ),
        panels: panels.collect(),
        perspective_caption:
            "The cloud of both cameras after ICP, in the colours they saw. Ceiling and near walls \
                              are cut away."
                .into(),
        cameras: CAMERAS.map(String::from).into(),
        dot_m: DOT_M,
    };
    page.draw()
}

fn dots_of(clouds: &[Cloud], variant: Variant) -> Vec<Dot> {
    let cloud = clouds.iter().find(|cloud| cloud.variant == variant);
    let voxels = cloud.into_iter().flat_map(|cloud| &cloud.voxels);
    voxels
        .filter(|voxel| voxel.points >= DRAWN_FROM)
        .map(|voxel| Dot {
            position_m: voxel.position_m,
            colour: voxel.colour,
            seen_by: voxel.cameras,
        })
        .collect()
}

fn notes(outcome: &Outcome, variant: Variant) -> Vec<String> {
    let fit = outcome.score(variant).zip(outcome.ratio(variant)).map(|(score, ratio)| {
        format!("{:.3} m from the truth (RMSE), {ratio:.2} × perfect poses", score.in_world.rmse_m)
    });
    let error = outcome.relative.and_then(|errors| match variant {
        Variant::WithoutMagnetometer => errors.without_magnetometer,
        Variant::Refined => errors.refined,
        _ => Some(errors.own),
    });
    let heading = error.map(|error| {
        format!(
            "headings disagree by {:.2}°, places by {:.3} m",
            error.heading_deg.abs(),
            error.place_m
        )
    });
    let unknown = || "unknown".to_owned();
    vec![fit.unwrap_or_else(unknown), heading.unwrap_or_else(unknown)]
}

/// The cameras as a merge placed them.
fn viewers(config: &Config, seen: &Seen, variant: Variant) -> Vec<Viewer> {
    let pose = |camera: &SeenCamera| match variant {
        Variant::WithoutMagnetometer => camera.without_magnetometer,
        Variant::Refined => camera.refined,
        _ => Some(camera.own),
    };
    let each = seen.cameras.iter().filter_map(|camera| Some((camera, pose(camera)?)));
    each.map(|(camera, pose)| viewer(config, camera, &pose)).collect()
}

fn viewer(config: &Config, camera: &SeenCamera, pose: &MeanPose) -> Viewer {
    let configured = config.camera.iter().find(|c| c.name == camera.name);
    let depth = configured.and_then(|camera| camera.depth).unwrap_or_default();
    Viewer {
        name: camera.name.clone(),
        position_m: pose.position_m.into(),
        forward: DQuat::from_array(pose.orientation) * DVec3::X,
        half_view_rad: depth.field_of_view_deg.to_radians() / 2.0,
    }
}
