//! Where cameras are evaluated: the synthetic cameras of scenario files.

use std::path::PathBuf;

use lodestone_config::model::{Camera, DriverKind, Synthetic, World};
use lodestone_config::{Config, ConfigErrors, DYNAMIC_SCENARIO, LoadError, STATIC_SCENARIOS};

/// A camera in its surroundings.
#[derive(Clone, Debug)]
pub struct Place {
    /// The camera's name, which names the place.
    pub name: String,
    /// The scenario it comes from: a file, or the name of an embedded one.
    pub source: String,
    /// The camera; its driver is `synthetic`.
    pub camera: Camera,
    /// Where on earth it is.
    pub world: World,
}

/// Why a scenario cannot be used. All of them are wrong configuration.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read, or is no configuration.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// An embedded scenario is no configuration.
    #[error(transparent)]
    Embedded(#[from] ConfigErrors),
    /// The camera is not simulated.
    #[error(
        "{scenario}: camera \"{camera}\" has another driver; allowed: driver = \"synthetic\", \
         because only there the truth is known"
    )]
    NotSynthetic {
        /// The scenario.
        scenario: String,
        /// The camera.
        camera: String,
    },
    /// The recording would never end.
    #[error(
        "{scenario}: camera.synthetic.duration_s of camera \"{camera}\" is 0, which never ends; \
         allowed: seconds above 0"
    )]
    Endless {
        /// The scenario.
        scenario: String,
        /// The camera.
        camera: String,
    },
    /// Two places have one name.
    #[error(
        "{scenario}: camera \"{camera}\" is also in another scenario; allowed: different names"
    )]
    Twice {
        /// The scenario.
        scenario: String,
        /// The camera.
        camera: String,
    },
}

impl Place {
    /// Its synthetic settings; the defaults where the configuration has none.
    pub fn synthetic(&self) -> Synthetic {
        self.camera.synthetic.clone().unwrap_or_default()
    }
}

/// The places of scenario files; without files, the embedded ones: the paper's six.
///
/// # Errors
/// [`ScenarioError`] names what is wrong with the first unusable scenario.
pub fn places(files: &[PathBuf]) -> Result<Vec<Place>, ScenarioError> {
    let mut places: Vec<Place> = Vec::new();
    if files.is_empty() {
        for (name, text) in STATIC_SCENARIOS {
            add(&mut places, name, Config::from_toml(name, text)?)?;
        }
    }
    for file in files {
        add(&mut places, &file.display().to_string(), Config::load(file)?.config)?;
    }
    Ok(places)
}

/// The embedded scenes of the dynamic evaluation: at rest, carried through a room, on stairs.
///
/// # Errors
/// [`ScenarioError`] never in a build whose tests pass.
pub fn dynamic_scenes() -> Result<Vec<Place>, ScenarioError> {
    let (name, text) = DYNAMIC_SCENARIO;
    let mut scenes = Vec::new();
    add(&mut scenes, name, Config::from_toml(name, text)?)?;
    Ok(scenes)
}

fn add(places: &mut Vec<Place>, scenario: &str, config: Config) -> Result<(), ScenarioError> {
    for camera in config.camera {
        let (scenario, name) = (scenario.to_owned(), camera.name.clone());
        let endless = camera.synthetic.as_ref().is_none_or(|s| s.duration_s == 0.0);
        if camera.driver != DriverKind::Synthetic {
            return Err(ScenarioError::NotSynthetic { scenario, camera: name });
        }
        if endless {
            return Err(ScenarioError::Endless { scenario, camera: name });
        }
        if places.iter().any(|place| place.name == name) {
            return Err(ScenarioError::Twice { scenario, camera: name });
        }
        places.push(Place { name, source: scenario, camera, world: config.world.clone() });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_places_are_the_papers_in_its_order() {
        let names: Vec<String> = places(&[]).unwrap().into_iter().map(|p| p.name).collect();
        let paper = crate::evaluation::paper::STABILITY.map(|(name, _)| name.to_owned());
        assert_eq!(names, paper);
    }

    #[test]
    fn what_cannot_be_evaluated_is_refused_by_name() {
        let refused = |text: &str| {
            let config = Config::from_toml("s.toml", text).unwrap();
            add(&mut Vec::new(), "s.toml", config).unwrap_err().to_string()
        };
        let endless = refused("[[camera]]\nname = \"cellar\"\ndriver = \"synthetic\"\n");
        assert!(endless.contains("s.toml") && endless.contains("duration_s"), "{endless}");
        let real = refused("[[camera]]\nname = \"cellar\"\nserial = 7\n");
        assert!(real.contains("cellar") && real.contains("synthetic"), "{real}");
    }
}
