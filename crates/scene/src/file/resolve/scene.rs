//! Resolves a scene file to a scene: defaults, grid, SI units, checks. Errors point at the value.

use super::resolver::Resolver;
use crate::error::SceneError;
use crate::file::document::Document;
use crate::file::grammar::{
    Angle, DomainFile, Format, LiquidFile, NumericsFile, OutputFile, SceneFile, Time, Wall, WallsFile, short,
};
use crate::file::resolved::{
    Body, Bounds, ContactLine, Domain, Liquid, Numerics, Output, Scene, ShapeSpec, Tensions, WALLS, Warnings,
    Wetting,
};
use crate::file::scene_files::SceneFiles;
use crate::file::source::Source;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;

/// Largest number of cells along a side.
const MAX_CELLS: u32 = 16_384;

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
        let (file, source) = document.read()?;
        resolve(file, source, base, options.quality)
    }
}

fn resolve(file: SceneFile, source: Source, base: &Path, quality: Quality) -> Result<Scene, SceneError> {
    let base = base.to_path_buf();
    let mut r = Resolver { source, base, dim: 0, dx: 0.0, size: Vec::new(), warnings: Vec::new() };
    if file.format != 1 {
        let message = format!("format {} is not a known version of the scene format", file.format);
        return Err(r.error("format", message, "this version reads `format = 1`"));
    }
    r.check_file_name("name", &file.name)?;
    let domain = r.domain(&file.domain, quality)?;
    let liquid = r.liquid(&file.liquid)?;
    let solids = r.solids(&file.solid)?;
    let names: Vec<&str> = solids.iter().map(|s| s.name.as_str()).collect();
    let tension = r.tension(&file.tension, &solids)?;
    let contact_line = r.contact_line(&file.contact_line.unwrap_or_default(), &names)?;
    r.check_hysteresis_range(&tension, &contact_line, &domain)?;
    let numerics = r.numerics(&file.numerics, solids.iter().any(|s| s.material.deforms()))?;
    let output = r.output(&file.output)?;
    let angles = young_angles(&names, &tension, &domain, &contact_line);
    let soft: Vec<&str> = solids.iter().filter(|s| s.material.deforms()).map(|s| s.name.as_str()).collect();
    let expect = r.expect(&file.expect.unwrap_or_default(), &names, &angles, &soft)?;
    Ok(Scene {
        name: file.name,
        based_on: file.based_on,
        description: file.description,
        cost: file.cost,
        domain,
        liquid,
        solids,
        tension,
        contact_line,
        numerics,
        output,
        expect,
        warnings: Warnings(r.warnings),
        source: r.source,
        files: SceneFiles::default(),
    })
}

/// Young's angle, rad, of every solid and of wetting walls, by name; 0 for total wetting, π for total dewetting, `None` where
/// the angle varies.
fn young_angles<'a>(
    names: &[&'a str],
    tension: &Tensions,
    domain: &Domain,
    line: &ContactLine,
) -> Vec<(&'a str, Option<f64>)> {
    let young = |name: &&'a str| {
        let given = tension.solids.iter().find(|t| t.0 == **name).map(|t| &t.1);
        let even = given.is_none_or(Wetting::is_uniform);
        let cosine = given.map_or(0.0, |w| w.tension.young_cosine(tension.liquid_air));
        (*name, even.then(|| cosine.clamp(-1.0, 1.0).acos()))
    };
    let walls =
        (domain.walls_are_wetting() && line.enabled).then_some((WALLS, Some(domain.wall_contact_angle)));
    names.iter().map(young).chain(walls).collect()
}

impl Resolver {
    fn domain(&mut self, d: &DomainFile, quality: Quality) -> Result<Domain, SceneError> {
        if !(2..=3).contains(&d.dimension) {
            let message = format!("a domain of {} dimensions cannot be simulated", d.dimension);
            return Err(self.error("domain.dimension", message, "accepted: 2, 3"));
        }
        self.dim = d.dimension as usize;
        self.check_dimension("domain.size", d.size.len())?;
        for (i, l) in d.size.iter().enumerate() {
            let path = format!("domain.size.{i}");
            if l.in_cells {
                let help = "give it in m, cm, mm or um";
                return Err(self.error(&path, "the size of the domain cannot be given in cells (dx)", help));
            }
            self.size.push(self.positive(&path, "the size of the domain", l.value)?);
        }
        let cells = self.grid(d, quality)?;
        let angle = d.wall_contact_angle.map_or(FRAC_PI_2, |a| a.0);
        self.angle("domain.wall_contact_angle", Angle(angle))?;
        let walls = self.walls(&d.walls)?;
        let size = self.size.clone();
        Ok(Domain { dimension: self.dim, size, cells, dx: self.dx, walls, wall_contact_angle: angle })
    }

    /// Number of cells along each axis; sets `dx` and rounds the size to whole cells.
    fn grid(&mut self, d: &DomainFile, quality: Quality) -> Result<Vec<usize>, SceneError> {
        let longest = self.size.iter().copied().fold(0.0, f64::max);
        let stated = match (d.resolution, d.dx) {
            (Some(n), None) => f64::from(n),
            (None, Some(dx)) if dx.in_cells => {
                return Err(self.error(
                    "domain.dx",
                    "the cell size cannot be given in cells (dx)",
                    "give a length such as \"0.5 mm\"",
                ));
            }
            (None, Some(dx)) => (longest / self.positive("domain.dx", "the cell size", dx.value)?).round(),
            (Some(_), Some(_)) => {
                let message = "both `resolution` and `dx` are given";
                return Err(self.error(
                    "domain.dx",
                    message,
                    "remove one of them: each determines the other",
                ));
            }
            (None, None) => {
                let help = "add `resolution = 64` (cells along the longest side) or `dx = \"0.5 mm\"`";
                return Err(self.error("domain", "neither `resolution` nor `dx` is given", help));
            }
        };
        let table = d.quality.clone().unwrap_or_default();
        let wanted = match quality {
            Quality::Normal => stated,
            Quality::Draft => table.draft.map_or((stated / 2.0).ceil(), f64::from),
            Quality::Paper => table.paper.map(f64::from).ok_or_else(|| {
                let help = "add `quality = { paper = 192 }` to [domain], or run it with another quality";
                self.error("domain", "the scene has no resolution for quality `paper`", help)
            })?,
        };
        let path = if d.dx.is_some() { "domain.dx" } else { "domain.resolution" };
        let count =
            self.within(path, "the number of cells along the longest side", wanted, 4.0, MAX_CELLS.into())?;
        self.fit_cells(d, longest, count)
    }

    fn fit_cells(&mut self, d: &DomainFile, longest: f64, count: f64) -> Result<Vec<usize>, SceneError> {
        let given = d.dx.map(|l| l.value).filter(|dx| (count * dx - longest).abs() < 0.5 * dx);
        let fit = given.map_or(longest, |dx| count * dx);
        let fit = if (fit - longest).abs() <= 1e-6 * longest / count { longest } else { fit };
        self.dx = fit / count;
        let mut cells = Vec::new();
        for i in 0..self.dim {
            let path = format!("domain.size.{i}");
            let n = (self.size[i] / self.dx).round();
            if n < 2.0 {
                let help = "at least 2 are needed: make the domain larger or the cells smaller";
                return Err(self.error(&path, format!("this side of the domain has only {n} cells"), help));
            }
            let size = if n >= count { fit } else { n * self.dx };
            if (size - self.size[i]).abs() > 1e-6 * self.dx {
                let old = self.size[i];
                let used = short(size);
                self.warn(&path, format!("{old} m is not a whole number of cells; {used} m is used instead"));
                self.size[i] = size;
            }
            cells.push(n as usize);
        }
        Ok(cells)
    }

    fn walls(&self, w: &WallsFile) -> Result<Vec<[Wall; 2]>, SceneError> {
        let all = w.all.unwrap_or(Wall::Slip);
        let side = |x: Option<Wall>| x.unwrap_or(all);
        let mut out = vec![[side(w.left), side(w.right)]];
        if self.dim == 3 {
            out.push([side(w.front), side(w.back)]);
        } else if let Some(name) =
            ["front", "back"].iter().find(|n| self.source.has(&format!("domain.walls.{n}")))
        {
            let path = format!("domain.walls.{name}");
            let error = SceneError::new(format!("a scene of 2 dimensions has no side `{name}`"));
            return Err(self
                .source
                .at_key(error.with_help("accepted: all, left, right, bottom, top"), &path));
        }
        out.push([side(w.bottom), side(w.top)]);
        Ok(out)
    }

    fn liquid(&mut self, l: &LiquidFile) -> Result<Liquid, SceneError> {
        let density = self.positive("liquid.density", "the density", l.density.0)?;
        let kinematic_viscosity = match (l.kinematic_viscosity, l.dynamic_viscosity) {
            (Some(v), None) => self.not_negative("liquid.kinematic_viscosity", "the viscosity", v.0)?,
            (None, Some(v)) => self.not_negative("liquid.dynamic_viscosity", "the viscosity", v.0)? / density,
            (Some(_), Some(_)) => {
                let message = "both `kinematic_viscosity` and `dynamic_viscosity` are given";
                return Err(self.error("liquid.dynamic_viscosity", message, "remove one of them"));
            }
            (None, None) => {
                let help = "add `kinematic_viscosity = \"1 mm^2/s\"` (0 for an inviscid liquid)";
                return Err(self.error("liquid", "the viscosity is missing", help));
            }
        };
        let gravity = match &l.gravity {
            Some(g) => {
                self.check_dimension("liquid.gravity", g.len())?;
                g.iter().map(|a| a.0).collect()
            }
            None => vec![0.0; self.dim],
        };
        if l.body.is_empty() {
            return Err(self.error(
                "liquid",
                "the scene has no liquid body",
                "add a [[liquid.body]] with a shape",
            ));
        }
        let mut bodies = Vec::new();
        for (i, b) in l.body.iter().enumerate() {
            let path = format!("liquid.body.{i}");
            let velocity = self.velocity(&format!("{path}.velocity"), b.velocity.as_ref())?;
            let shape = self.shape(&format!("{path}.shape"), &b.shape)?;
            self.check_liquid_inside(&format!("{path}.shape"), &shape)?;
            bodies.push(Body { shape, velocity, displaced: b.displaced.unwrap_or(false) });
        }
        Ok(Liquid { density, kinematic_viscosity, gravity, bodies })
    }

    /// Refuses a body outside the domain. Walls may cut a body; a cut round shape gets a warning, since boxes, cylinders and the
    /// like are often extended beyond walls on purpose.
    fn check_liquid_inside(&mut self, path: &str, shape: &ShapeSpec) -> Result<(), SceneError> {
        let Some(Bounds { lower, upper }) = shape.bounds(self.dim) else { return Ok(()) };
        let mut cut = false;
        for i in 0..self.dim {
            if upper[i] <= 0.0 || lower[i] >= self.size[i] {
                let (axis, end) = (["x", "y", "z"][i], self.size[i]);
                let message = format!(
                    "the liquid is outside the domain: it reaches from {axis} = {} m to {} m",
                    short(lower[i]),
                    short(upper[i])
                );
                let help = format!("the domain reaches from {axis} = 0 m to {} m", short(end));
                return Err(self.error(&self.source.first_inside(path), message, help));
            }
            let slack = 1e-6 * self.dx;
            cut |= (lower[i].is_finite() && lower[i] < -slack)
                || (upper[i].is_finite() && upper[i] > self.size[i] + slack);
        }
        let round = matches!(
            shape,
            ShapeSpec::Ball { .. } | ShapeSpec::PerturbedBall { .. } | ShapeSpec::Ellipsoid { .. }
        );
        if cut && round {
            self.warn(path, "the liquid body extends outside the domain; the part outside is removed");
        }
        Ok(())
    }

    fn numerics(&mut self, n: &NumericsFile, soft: bool) -> Result<Numerics, SceneError> {
        let time = |r: &Self, key: &str, t: Option<Time>| {
            t.map(|t| r.positive(&format!("numerics.{key}"), "a time step", t.0)).transpose()
        };
        let max_step = time(self, "max_step", n.max_step)?.unwrap_or(f64::INFINITY);
        let fixed_step = time(self, "fixed_step", n.fixed_step)?;
        let threads = n
            .threads
            .map(|t| self.within("numerics.threads", "the number of threads", t.into(), 1.0, 1024.0));
        let iterations = f64::from(n.max_iterations.unwrap_or(1000));
        Ok(Numerics {
            scheme: n.scheme.unwrap_or_default(),
            cfl: self.within("numerics.cfl", "the CFL number", n.cfl.unwrap_or(0.7), 0.01, 10.0)?,
            max_step,
            tolerance: self.within(
                "numerics.tolerance",
                "the tolerance",
                n.tolerance.unwrap_or(1e-6),
                1e-14,
                0.1,
            )?,
            max_iterations: self.within(
                "numerics.max_iterations",
                "the number of iterations",
                iterations,
                1.0,
                1e6,
            )? as usize,
            capillary_step: self.within(
                "numerics.capillary_step",
                "the multiple of the explicit capillary limit",
                n.capillary_step.unwrap_or(5.0),
                0.01,
                1000.0,
            )?,
            newton_iterations: self.newton(n.newton_iterations.unwrap_or(0), soft)?,
            fixed_step,
            restore_momentum: n.restore_momentum.unwrap_or(true),
            threads: threads.transpose()?.map(|t| t as usize),
        })
    }

    fn newton(&mut self, iterations: u32, soft: bool) -> Result<u32, SceneError> {
        let key = "numerics.newton_iterations";
        self.within(key, "the number of Newton iterations", iterations.into(), 0.0, 20.0)?;
        if iterations > 0 && !soft {
            self.warn(key, "`newton_iterations` has no effect: no solid deforms");
        }
        Ok(iterations)
    }

    fn output(&mut self, o: &OutputFile) -> Result<Output, SceneError> {
        let duration = self.positive("output.duration", "the duration", o.duration.0)?;
        let path = "output.frame_interval";
        let interval = o.frame_interval.map_or(duration / 100.0, |t| t.0);
        let frame_interval = self.positive(path, "the time between frames", interval)?;
        if duration / frame_interval > 1e6 {
            return Err(self.error(
                path,
                "this interval gives more than a million frames",
                "use a longer interval",
            ));
        }
        if frame_interval > duration {
            self.warn(
                path,
                "the frame interval exceeds the duration: only the first and the last frame are written",
            );
        }
        let mut formats = o.formats.clone().unwrap_or_else(|| vec![Format::Ply, Format::Page]);
        formats.push(Format::Ply);
        formats.sort_unstable();
        formats.dedup();
        let checkpoint_every = o.checkpoint_every.unwrap_or(20) as usize;
        if checkpoint_every == 0 {
            let help = "give a number of frames of at least 1";
            return Err(self.error(
                "output.checkpoint_every",
                "the number of frames between checkpoints is 0",
                help,
            ));
        }
        Ok(Output { duration, frame_interval, formats, checkpoint_every })
    }
}
