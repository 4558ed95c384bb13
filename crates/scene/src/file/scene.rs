//! A whole scene: reading, checking and writing it.

use super::scene_files::SceneFiles;
use super::sections::{
    ContactLine, Domain, Expect, Liquid, Names, Numerics, Output, Quality, Solid, Tensions, WALLS, Wall,
    Wetting,
};
use super::text::{Document, Source};
use super::validator::{Validator, Warning};
use crate::error::{ErrorKind, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A whole scene file.
// In memory all numbers are in SI units, vectors have `domain.dimension` entries, and paths are absolute.
// `ensure_runnable` checks that this version can run it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Version of the grammar: 1.
    pub format: u32,
    /// Name of the scene and of its output folder: letters, digits, `-`, `_` and `.`, at most 100, not starting
    /// with `.`.
    pub name: String,
    /// Source of the scene, such as a figure of the paper.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub based_on: Option<String>,
    /// Description of the scene in one or two lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Approximate cost of a run, as free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cost: Option<String>,
    /// The simulated box and its grid.
    pub domain: Domain,
    /// The liquid and its state at the start.
    pub liquid: Liquid,
    /// The solids.
    #[serde(default, rename = "solid", skip_serializing_if = "Vec::is_empty")]
    pub solids: Vec<Solid>,
    /// Surface tension of the liquid, and tensions or contact angles of the solids.
    pub tension: Tensions,
    /// Properties of the contact line.
    #[serde(default)]
    pub contact_line: ContactLine,
    /// Parameters of the discretisation.
    #[serde(default)]
    pub numerics: Numerics,
    /// Duration of the run, and the files that it writes.
    pub output: Output,
    /// Expected results, checked at the end of the run.
    #[serde(default)]
    pub expect: Expect,
    /// Warnings; not part of equality.
    #[serde(skip)]
    pub warnings: Warnings,
    /// Source positions for errors; not part of equality.
    #[serde(skip)]
    pub source: Source,
    /// The files that the scene names; not part of equality.
    #[serde(skip)]
    pub files: SceneFiles,
}

/// Warnings: suspicious values that do not prevent a run.
#[derive(Clone, Debug, Default)]
pub struct Warnings(pub Vec<Warning>);

impl PartialEq for Warnings {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// How a scene is loaded.
#[derive(Clone, Debug, Default)]
pub struct LoadOptions {
    /// Overrides `path=value`, applied in order.
    pub sets: Vec<String>,
    /// Resolution.
    pub quality: Quality,
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`SceneError`]: of kind `Io` if the file cannot be read, otherwise with message and position.
    pub fn load(path: &Path, options: &LoadOptions) -> Result<Self, SceneError> {
        let name = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|e| SceneError::io(&name, format!("cannot read the scene `{name}`: {e}")))?;
        Self::from_text(&name, &text, path.parent().unwrap_or(Path::new("")), options)
    }

    /// Reads a scene from text; paths of meshes and images are relative to `base`.
    ///
    /// # Errors
    /// [`SceneError`] with message and position.
    pub fn from_text(name: &str, text: &str, base: &Path, options: &LoadOptions) -> Result<Self, SceneError> {
        let mut document = Document::parse(name, text)?;
        for set in &options.sets {
            document.apply_set(set)?;
        }
        let source = document.source();
        // The grid comes first, since lengths may count cells. What is wrong with it is reported with all the rest below.
        let mut grid = Validator::new(source.clone(), base);
        let domain = document.table::<Domain>("domain");
        let _ = domain.map(|mut domain| domain.validate(options.quality, &mut grid));
        let mut scene: Self = document.read(grid.dx)?;
        let mut v = Validator::new(source, base);
        scene.validate(options.quality, &mut v)?;
        (scene.warnings, scene.source) = (Warnings(v.warnings), v.source);
        Ok(scene)
    }

    /// Checks the scene, and makes defaults explicit that depend on other keys.
    fn validate(&mut self, quality: Quality, v: &mut Validator) -> Result<(), SceneError> {
        if self.format != 1 {
            let message = format!("format {} is not a known version of the scene format", self.format);
            return Err(v.error("format", message, "this version reads `format = 1`"));
        }
        v.check_file_name("name", &self.name)?;
        self.domain.validate(quality, v)?;
        self.liquid.validate(v)?;
        Solid::validate_all(&mut self.solids, v)?;
        self.tension.validate(&self.solids, v)?;
        let solids: Vec<&str> = self.solids.iter().map(|s| s.name.as_str()).collect();
        self.contact_line.validate(&solids, v)?;
        self.tension.check_hysteresis(&self.contact_line, &self.domain, v)?;
        let soft: Vec<&str> =
            self.solids.iter().filter(|s| s.material.deforms()).map(|s| s.name.as_str()).collect();
        self.numerics.validate(self.solids.iter().any(|s| s.material.is_moved_by_forces()), v)?;
        self.output.validate(v)?;
        let mut expect = self.expect.clone();
        expect.validate(&Names { solids, soft, angles: self.young_angles() }, v)?;
        self.expect = expect;
        Ok(())
    }

    /// Young's angle, rad, of every solid and of wetting walls, by name; 0 for total wetting, π for total dewetting, `None` where
    /// the angle varies.
    fn young_angles(&self) -> Vec<(&str, Option<f64>)> {
        let young = |solid: &'_ Solid| {
            let given = self.tension.solids.iter().find(|t| t.0 == solid.name).map(|t| &t.1);
            let angle = given.map_or(std::f64::consts::FRAC_PI_2, |w| w.young_angle(self.tension.liquid_air));
            given.is_none_or(Wetting::is_uniform).then_some(angle)
        };
        let walls = self.has_wetting_walls().then_some((WALLS, Some(self.domain.wall_contact_angle)));
        self.solids.iter().map(|solid| (solid.name.as_str(), young(solid))).chain(walls).collect()
    }

    /// The scene as run: SI, defaults and overrides filled in. Reading it again gives an identical scene.
    ///
    /// # Errors
    /// [`SceneError`] if the text cannot be written; this does not happen for a valid scene.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        let mut scene = self.clone();
        scene.solids.iter_mut().for_each(Solid::omit_unused);
        let body = toml::to_string(&scene).map_err(|e| SceneError {
            kind: ErrorKind::Io,
            ..SceneError::new(format!("the scene cannot be written: {e}"))
        })?;
        Ok(format!("# As run: every default and override filled in, SI units.\n{body}"))
    }

    /// Whether the contact angle at the closed sides differs from 90 degrees and the contact line is enabled.
    pub fn has_wetting_walls(&self) -> bool {
        self.domain.walls_are_wetting() && self.contact_line.enabled
    }

    /// Number of cells of the grid, including the margins beyond open and wetting sides.
    pub fn grid_cells(&self) -> f64 {
        let beyond = |w: &Wall| match w {
            Wall::Open => meniscus_sim::OPEN_SIDE_MARGIN_CELLS,
            Wall::Slip if self.has_wetting_walls() => meniscus_sim::WETTING_WALL_MARGIN_CELLS,
            Wall::Slip => 0,
        };
        let along = |(n, sides): (&usize, &[Wall; 2])| (n + sides.iter().map(beyond).sum::<usize>()) as f64;
        self.domain.cells.iter().zip(&self.domain.walls).map(along).product()
    }
}
