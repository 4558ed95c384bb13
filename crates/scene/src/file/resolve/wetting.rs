//! Resolves tensions, patterns of the contact angle and hysteresis to SI units.

use super::resolver::Resolver;
use crate::error::SceneError;
use crate::file::grammar::{
    Angle, AngleAtFile, HysteresisFile, Length, PatchFile, SolidTensionFile, TensionFile, WettingImageFile,
};
use crate::file::resolved::{
    Bounds, ContactLine, Domain, Hysteresis, ShapeSpec, Solid, SolidTension, Tensions, WALLS, Wetting,
    WettingImage,
};
use std::f64::consts::PI;
use std::path::PathBuf;

impl Resolver {
    pub fn tension(&mut self, t: &TensionFile, all: &[Solid]) -> Result<Tensions, SceneError> {
        let liquid_air = self.positive("tension.liquid_air", "the surface tension", t.liquid_air.0)?;
        let names: Vec<&str> = all.iter().map(|s| s.name.as_str()).collect();
        let mut solids = Vec::new();
        for (name, s) in &t.solids {
            let path = format!("tension.{name}");
            self.check_known_solid(&path, true, name, &names)?;
            let bounds = all.iter().find(|s| s.name == *name).and_then(|s| s.shape.bounds(self.dim));
            let image = s.image.as_ref();
            let wetting = Wetting {
                tension: self.solid_tension(&path, s)?,
                image: image.map(|i| self.image(&format!("{path}.image"), i, bounds.as_ref())).transpose()?,
                patches: self.patches(&format!("{path}.patches"), &s.patches, bounds.as_ref())?,
            };
            let cosine = wetting.tension.young_cosine(liquid_air);
            if cosine.abs() > 1.0 {
                let state =
                    if cosine > 0.0 { "wets the solid totally" } else { "does not wet the solid at all" };
                self.warn(
                    &path,
                    format!("there is no Young angle (its cosine would be {cosine:.3}): the liquid {state}"),
                );
            }
            solids.push((name.clone(), wetting));
        }
        solids.sort_by(|a, b| a.0.cmp(&b.0));
        Ok(Tensions { liquid_air, solids })
    }

    fn solid_tension(&self, path: &str, s: &SolidTensionFile) -> Result<SolidTension, SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        Ok(match (s.liquid_solid, s.solid_air, s.contact_angle, &s.gradient) {
            (Some(ls), Some(sa), None, None) => SolidTension::Energies {
                liquid_solid: self.not_negative(&at("liquid_solid"), "the tension", ls.0)?,
                solid_air: self.not_negative(&at("solid_air"), "the tension", sa.0)?,
            },
            (None, None, Some(a), None) => SolidTension::Angle(self.angle(&at("contact_angle"), a)?),
            (None, None, None, Some(g)) => {
                let end = |key: &str, end: &AngleAtFile| {
                    let point = self.point(&format!("{path}.gradient.{key}.point"), &end.point)?;
                    let angle = format!("{path}.gradient.{key}.contact_angle");
                    Ok((point, self.angle(&angle, end.contact_angle)?))
                };
                let (from, to) = (end("from", &g.from)?, end("to", &g.to)?);
                if from.0 == to.0 {
                    let help = "give two different points";
                    let path = at("gradient.to.point");
                    return Err(self.error(&path, "the two points of the gradient are the same", help));
                }
                SolidTension::Gradient { from, to }
            }
            _ => {
                return Err(self.tension_error(path, s));
            }
        })
    }

    /// The error for missing or conflicting tensions.
    fn tension_error(&self, path: &str, s: &SolidTensionFile) -> SceneError {
        let keys = [
            ("liquid_solid", s.liquid_solid.is_some()),
            ("solid_air", s.solid_air.is_some()),
            ("contact_angle", s.contact_angle.is_some()),
            ("gradient", s.gradient.is_some()),
        ];
        let given: Vec<&str> = keys.iter().filter(|key| key.1).map(|key| key.0).collect();
        let one_of = "give `liquid_solid` and `solid_air`, or `contact_angle`, or `gradient`";
        let energies = given.iter().filter(|key| ["liquid_solid", "solid_air"].contains(key)).count();
        if given.is_empty() {
            return self.error(path, "no tension is given for this solid", one_of);
        }
        if given.len() == energies {
            let missing = if given == ["liquid_solid"] { "solid_air" } else { "liquid_solid" };
            return self.error(path, format!("the tension `{missing}` is missing"), one_of);
        }
        let message = format!("{} exclude each other", given.join(" and "));
        let help = format!(
            "keep one; on the command line set the whole table: --set '{path}={{contact_angle=\"60 deg\"}}'"
        );
        self.error(path, message, help)
    }

    /// `bounds`: bounds of the solid.
    fn patches(
        &mut self,
        path: &str,
        list: &[PatchFile],
        bounds: Option<&Bounds>,
    ) -> Result<Vec<(ShapeSpec, f64)>, SceneError> {
        let mut out = Vec::new();
        for (i, patch) in list.iter().enumerate() {
            let p = format!("{path}.{i}.shape");
            let shape = self.shape(&p, &patch.shape)?;
            let own = shape.bounds(self.dim);
            if bounds.zip(own.as_ref()).is_some_and(|(solid, own)| self.are_bounds_apart(solid, own)) {
                let help = "place the patch on the solid as it is at the start";
                let p = self.source.first_inside(&p);
                return Err(self.error(&p, "the patch does not reach the solid", help));
            }
            let angle = self.angle(&format!("{path}.{i}.contact_angle"), patch.contact_angle)?;
            out.push((shape, angle));
        }
        Ok(out)
    }

    /// Whether two boxes are disjoint along any axis that both have.
    fn are_bounds_apart(&self, one: &Bounds, other: &Bounds) -> bool {
        let slack = 1e-6 * self.dx;
        let along = |(low, high): (&f64, &f64)| low > &(high + slack);
        one.lower.iter().zip(&other.upper).any(along) || other.lower.iter().zip(&one.upper).any(along)
    }

    /// `bounds`: bounds of the solid.
    fn image(
        &self,
        path: &str,
        i: &WettingImageFile,
        bounds: Option<&Bounds>,
    ) -> Result<WettingImage, SceneError> {
        let at = |key: &str| format!("{path}.{key}");
        let file = self.image_file(&at("file"), &i.file)?;
        let corner = |key: &str, value: &[Length]| {
            let wanted = self.dim - 1;
            if value.len() != wanted {
                let message = format!("found {} entries in this corner of the image", value.len());
                let help = format!("give {wanted}: the image is projected along the vertical axis");
                return Err(self.error(&at(key), message, help));
            }
            Ok(value.iter().map(|l| l.resolve(self.dx)).collect::<Vec<f64>>())
        };
        let (lower, upper) = (corner("lower", &i.lower)?, corner("upper", &i.upper)?);
        for (a, (low, high)) in lower.iter().zip(&upper).enumerate() {
            if low >= high {
                let message = format!("`upper` ({high} m) is not above `lower` ({low} m)");
                let help = "every entry of `upper` must be larger than that of `lower`";
                return Err(self.error(&at(&format!("upper.{a}")), message, help));
            }
        }
        let own = Bounds { lower, upper };
        if bounds.is_some_and(|solid| self.are_bounds_apart(solid, &own)) {
            let help = "place the image on the solid as it is at the start";
            return Err(self.error(&at("lower"), "the image does not reach the solid", help));
        }
        let black = self.angle(&at("black"), i.black)?;
        let white = self.angle(&at("white"), i.white)?;
        let Bounds { lower, upper } = own;
        Ok(WettingImage { path: file, lower, upper, black, white })
    }

    fn image_file(&self, path: &str, name: &str) -> Result<PathBuf, SceneError> {
        let file = self.base.join(name);
        if !file.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            let message = format!("`{}` is not a supported image file", name.escape_debug());
            return Err(self.error(path, message, "accepted: .png"));
        }
        match std::fs::canonicalize(&file) {
            Ok(f) if f.is_file() => Ok(f),
            _ => {
                let message = format!("there is no image `{}`", name.escape_debug());
                let help = "the path is relative to the folder of the scene file";
                Err(self.error(path, message, help))
            }
        }
    }

    pub fn hysteresis(&self, h: &HysteresisFile) -> Result<Hysteresis, SceneError> {
        let path = "contact_line.hysteresis";
        let within = |key: &str, what: &str, value: Angle, high: f64| {
            self.within(&format!("{path}.{key}"), what, value.0, 0.0, high)
        };
        match (h.advancing, h.receding, h.above, h.below) {
            (Some(advancing), Some(receding), None, None) => {
                let advancing = within("advancing", "the advancing angle (rad)", advancing, PI)?;
                let receding = within("receding", "the receding angle (rad)", receding, advancing)?;
                Ok(Hysteresis::Between { advancing, receding })
            }
            (None, None, Some(above), Some(below)) => Ok(Hysteresis::Around {
                above: within("above", "the angle (rad)", above, PI)?,
                below: within("below", "the angle (rad)", below, PI)?,
            }),
            _ => {
                let help =
                    "give `advancing` and `receding`, or `above` and `below` (relative to Young's angle)";
                Err(self.error(path, "these keys do not define the hysteresis", help))
            }
        }
    }

    /// Checks that Young's angle is uniform and lies between the receding and the advancing angle where both are given.
    pub fn check_hysteresis_range(
        &self,
        tension: &Tensions,
        line: &ContactLine,
        domain: &Domain,
    ) -> Result<(), SceneError> {
        let Some(Hysteresis::Between { advancing, receding }) = line.hysteresis else { return Ok(()) };
        let refuse = |message: String, help| Err(self.error("contact_line.hysteresis", message, help));
        let mut all =
            Vec::from_iter(domain.walls_are_wetting().then_some((WALLS, domain.wall_contact_angle)));
        for (name, solid) in &tension.solids {
            if !solid.is_uniform() {
                let message = format!(
                    "the contact angle of `{name}` varies, but the advancing and receding angles do not"
                );
                return refuse(
                    message,
                    "give them relative to Young's angle: { above = \"10 deg\", below = \"10 deg\" }",
                );
            }
            all.push((name, solid.tension.young_cosine(tension.liquid_air).clamp(-1.0, 1.0).acos()));
        }
        for (name, angle) in all {
            if !(receding - 1e-9..=advancing + 1e-9).contains(&angle) {
                let [young, advancing, receding] = [angle, advancing, receding].map(f64::to_degrees);
                let message = format!(
                    "the contact angle of `{name}`, {young:.1} deg, is not between the receding angle, {receding:.1} deg, \
                     and the advancing angle, {advancing:.1} deg"
                );
                let help =
                    "change `contact_line.hysteresis`, the solid's tensions or `domain.wall_contact_angle`";
                return refuse(message, help);
            }
        }
        Ok(())
    }
}
