//! `[domain]`: the simulated box and its grid.

use crate::error::SceneError;
use crate::file::text::{Angle, Length, Si, short};
use crate::file::validator::Validator;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::f64::consts::FRAC_PI_2;

/// Largest number of cells along a side.
const MAX_CELLS: u32 = 16_384;

/// `[domain]`: the simulated box and its grid.
// After the validation the size is `cells` times `dx`; the box reaches from the origin to it.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Domain {
    /// Number of dimensions, 2 or 3. The last axis points up; the lower corner of the domain is the origin.
    pub dimension: usize,
    /// Length along each axis, above 0. It is rounded to a whole number of cells.
    #[serde(with = "Si::<Vec<Length>>")]
    pub size: Vec<f64>,
    /// Number of cells along the longest side, 4 to 16384; given instead of `dx`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    resolution: Option<usize>,
    /// Cell size, above 0; given instead of `resolution`.
    #[serde(default, rename = "dx", skip_serializing, with = "Si::<Option<Length>>")]
    stated_dx: Option<f64>,
    /// Number of cells along the longest side for `--quality draft` and `--quality paper`.
    #[serde(default, skip_serializing)]
    quality: QualityCells,
    /// Type of each side of the domain.
    #[serde(default = "closed", with = "walls_form")]
    #[schemars(with = "walls_form::Walls")]
    pub walls: Vec<[Wall; 2]>,
    /// Contact angle at the closed sides, through the liquid: 0 to 180 degrees, 90 degrees by default. At 90
    /// degrees the closed sides are planes of symmetry: no contact line is written on them, and contact-line
    /// friction and hysteresis do not act there.
    #[serde(default = "right_angle", with = "Si::<Angle>")]
    pub wall_contact_angle: f64,
    /// Number of cells along each axis.
    #[serde(skip)]
    pub cells: Vec<usize>,
    /// Cell size, m.
    #[serde(skip)]
    pub dx: f64,
}

identity_text!(Domain, d => dimension: d.dimension, size: d.size, cells: d.cells, dx: d.dx, walls: d.walls,
    wall_contact_angle: d.wall_contact_angle);

/// Number of cells along the longest side for qualities other than `normal`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct QualityCells {
    /// For `--quality draft`; half of the scene's resolution by default.
    #[serde(default)]
    draft: Option<u32>,
    /// For `--quality paper`, which the scene does not have without this key.
    #[serde(default)]
    paper: Option<u32>,
}

/// Resolution at which a scene is run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// The resolution of `domain.quality.draft`, or half the stated one.
    Draft,
    /// The resolution stated in the scene.
    #[default]
    Normal,
    /// The resolution of `domain.quality.paper`.
    Paper,
    /// So many cells along the longest side.
    Cells(u32),
}

/// Type of a side of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Wall {
    /// Closed side: impermeable, without friction.
    Slip,
    /// Open side: beyond it is air. Liquid leaves through it, and none enters.
    Open,
}

/// The types of the sides by axis, in three dimensions until the scene is validated.
mod walls_form {
    use super::{Deserialize, Deserializer, JsonSchema, Serialize, Serializer, Wall};

    /// `walls`: types of the sides of the domain.
    #[derive(Default, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Walls {
        /// Type of all sides that are not named; `slip` by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        all: Option<Wall>,
        /// Lower end of x.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        left: Option<Wall>,
        /// Upper end of x.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        right: Option<Wall>,
        /// Lower end of y (3D only).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        front: Option<Wall>,
        /// Upper end of y (3D only).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        back: Option<Wall>,
        /// Lower end of the last axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bottom: Option<Wall>,
        /// Upper end of the last axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        top: Option<Wall>,
    }

    pub fn serialize<S: Serializer>(walls: &[[Wall; 2]], s: S) -> Result<S::Ok, S::Error> {
        let side = |axis: Option<&[Wall; 2]>, end: usize| axis.map(|ends| ends[end]);
        let (x, y, z) = (walls.first(), walls.get(1).filter(|_| walls.len() > 2), walls.last());
        let (left, right, front, back) = (side(x, 0), side(x, 1), side(y, 0), side(y, 1));
        Walls { all: None, left, right, front, back, bottom: side(z, 0), top: side(z, 1) }.serialize(s)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<Vec<[Wall; 2]>, D::Error> {
        let w = Walls::deserialize(d)?;
        let side = |of: Option<Wall>| of.or(w.all).unwrap_or(Wall::Slip);
        let ends = [(w.left, w.right), (w.front, w.back), (w.bottom, w.top)];
        Ok(ends.map(|(low, high)| [side(low), side(high)]).to_vec())
    }
}

fn closed() -> Vec<[Wall; 2]> {
    vec![[Wall::Slip; 2]; 3]
}

fn right_angle() -> f64 {
    FRAC_PI_2
}

impl Domain {
    /// Number of cells.
    pub fn cell_count(&self) -> f64 {
        self.cells.iter().map(|&n| n as f64).product()
    }

    /// Whether the contact angle at the closed sides differs from 90 degrees, the angle of a mirror.
    pub fn walls_are_wetting(&self) -> bool {
        (self.wall_contact_angle - FRAC_PI_2).abs() > 1e-9
    }

    /// Checks the section of a scene, and fits the grid to it. The validator knows it from then on.
    ///
    /// # Errors
    /// [`SceneError`] at the value.
    pub(in crate::file) fn validate(
        &mut self,
        quality: Quality,
        v: &mut Validator,
    ) -> Result<(), SceneError> {
        if !(2..=3).contains(&self.dimension) {
            let message = format!("a domain of {} dimensions cannot be simulated", self.dimension);
            return Err(v.error("domain.dimension", message, "accepted: 2, 3"));
        }
        v.dim = self.dimension;
        v.dimension("domain.size", &self.size)?;
        for (i, length) in self.size.iter().enumerate() {
            let path = format!("domain.size.{i}");
            if length.is_nan() {
                let help = "give it in m, cm, mm or um";
                return Err(v.error(&path, "the size of the domain cannot be given in cells (dx)", help));
            }
            v.positive(&path, "the size of the domain", *length)?;
        }
        let count = self.cells_along_longest_side(quality, v)?;
        self.fit_cells(count, v)?;
        (v.dx, v.size) = (self.dx, self.size.clone());
        self.resolution = self.cells.iter().max().copied();
        (self.stated_dx, self.quality) = (None, QualityCells::default());
        v.angle("domain.wall_contact_angle", self.wall_contact_angle)?;
        self.validate_walls(v)
    }

    fn longest_side(&self) -> f64 {
        self.size.iter().copied().fold(0.0, f64::max)
    }

    fn cells_along_longest_side(&self, quality: Quality, v: &Validator) -> Result<f64, SceneError> {
        let stated = match (self.resolution, self.stated_dx) {
            (Some(n), None) => n as f64,
            (None, Some(dx)) if dx.is_nan() => {
                let help = "give a length such as \"0.5 mm\"";
                return Err(v.error("domain.dx", "the cell size cannot be given in cells (dx)", help));
            }
            (None, Some(dx)) => {
                v.positive("domain.dx", "the cell size", dx)?;
                (self.longest_side() / dx).round()
            }
            (Some(_), Some(_)) => {
                let help = "remove one of them: each determines the other";
                return Err(v.error("domain.dx", "both `resolution` and `dx` are given", help));
            }
            (None, None) => {
                let help = "add `resolution = 64` (cells along the longest side) or `dx = \"0.5 mm\"`";
                return Err(v.error("domain", "neither `resolution` nor `dx` is given", help));
            }
        };
        let wanted = match quality {
            Quality::Normal => stated,
            Quality::Draft => self.quality.draft.map_or((stated / 2.0).ceil(), f64::from),
            Quality::Paper => self.quality.paper.map(f64::from).ok_or_else(|| {
                let help = "add `quality = { paper = 192 }` to [domain], or run it with another quality";
                v.error("domain", "the scene has no resolution for quality `paper`", help)
            })?,
            Quality::Cells(n) => f64::from(n),
        };
        let path = if self.stated_dx.is_some() { "domain.dx" } else { "domain.resolution" };
        v.within(path, "the number of cells along the longest side", wanted, [4.0, MAX_CELLS.into()])?;
        Ok(wanted)
    }

    /// Finds the cell size and the number of cells along each axis; rounds the size to whole cells.
    fn fit_cells(&mut self, count: f64, v: &mut Validator) -> Result<(), SceneError> {
        let longest = self.longest_side();
        let given = self.stated_dx.filter(|dx| (count * dx - longest).abs() < 0.5 * dx);
        let fit = given.map_or(longest, |dx| count * dx);
        let fit = if (fit - longest).abs() <= 1e-6 * longest / count { longest } else { fit };
        self.dx = fit / count;
        self.cells.clear();
        for (i, side) in self.size.iter_mut().enumerate() {
            let path = format!("domain.size.{i}");
            let n = (*side / self.dx).round();
            if n < 2.0 {
                let help = "at least 2 are needed: make the domain larger or the cells smaller";
                return Err(v.error(&path, format!("this side of the domain has only {n} cells"), help));
            }
            let size = if n >= count { fit } else { n * self.dx };
            if (size - *side).abs() > 1e-6 * self.dx {
                let used = short(size);
                v.warn(&path, format!("{side} m is not a whole number of cells; {used} m is used instead"));
                *side = size;
            }
            self.cells.push(n as usize);
        }
        Ok(())
    }

    fn validate_walls(&mut self, v: &Validator) -> Result<(), SceneError> {
        if self.dimension == 3 {
            return Ok(());
        }
        self.walls.remove(1);
        let path = |name: &&str| format!("domain.walls.{name}");
        let Some(name) = ["front", "back"].iter().find(|name| v.source.has(&path(name))) else {
            return Ok(());
        };
        let error = SceneError::new(format!("a scene of 2 dimensions has no side `{name}`"));
        Err(v.source.at_key(error.with_help("accepted: all, left, right, bottom, top"), &path(name)))
    }
}
