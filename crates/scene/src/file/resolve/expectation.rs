//! Defaults and checks of `[expect]`: what is checked at the end of a run.

use super::resolver::Resolver;
use crate::error::SceneError;
use crate::file::grammar::{Angle, ExpectFile, Length, MaxFile, Side};
use crate::file::resolved::Expectation;

impl Resolver {
    /// The expectations. `names`: all solids; `angles`: solids and walls with a contact angle, with Young's angle (rad); `soft`:
    /// deformable solids.
    pub fn expect(
        &mut self,
        e: &ExpectFile,
        names: &[&str],
        angles: &[(&str, Option<f64>)],
        soft: &[&str],
    ) -> Result<Vec<Expectation>, SceneError> {
        let bound = |key: &str, m: MaxFile| self.not_negative(&format!("expect.{key}.max"), "a bound", m.max);
        let mut out = Vec::new();
        if let Some(m) = e.volume_drift {
            out.push(Expectation::VolumeDrift { max: bound("volume_drift", m)? });
        }
        if let Some(m) = e.momentum_error {
            out.push(Expectation::MomentumError { max: bound("momentum_error", m)? });
        }
        if let Some(m) = e.energy_growth {
            out.push(Expectation::EnergyGrowth { max: bound("energy_growth", m)? });
        }
        if let Some(m) = e.max_speed {
            out.push(Expectation::MaxSpeed {
                max: self.not_negative("expect.max_speed.max", "a bound", m.max.0)?,
            });
        }
        if let Some(p) = e.period {
            let value = self.positive("expect.period.value", "the period", p.value.0)?;
            let tolerance = self.positive("expect.period.tolerance", "the tolerance", p.tolerance)?;
            out.push(Expectation::Period { mode: p.mode, value, tolerance });
        }
        if let Some(p) = e.frequency {
            let value = self.positive("expect.frequency.value", "the frequency", p.value.0)?;
            let tolerance = self.positive("expect.frequency.tolerance", "the tolerance", p.tolerance)?;
            out.push(Expectation::Frequency { mode: p.mode, value, tolerance });
        }
        self.expect_repairs(e, &mut out)?;
        self.expect_liquid(e, &mut out)?;
        self.expect_angles(e, angles, &mut out)?;
        self.expect_solids(e, names, &mut out)?;
        self.expect_deflections(e, names, soft, &mut out)?;
        Ok(out)
    }

    fn expect_liquid(&self, e: &ExpectFile, out: &mut Vec<Expectation>) -> Result<(), SceneError> {
        if let Some(d) = e.drops {
            let (min, max) = match (d.count, d.min, d.max) {
                (Some(n), None, None) => (n, n),
                (None, min, max) if min.is_some() || max.is_some() => {
                    (min.unwrap_or(0), max.unwrap_or(u32::MAX))
                }
                _ => {
                    let help = "give `count`, or `min` and/or `max`";
                    return Err(self.error(
                        "expect.drops",
                        "the expected number of drops is not given",
                        help,
                    ));
                }
            };
            if min > max {
                let message = format!("`max` ({max}) is below `min` ({min})");
                return Err(self.error("expect.drops.max", message, "swap them"));
            }
            out.push(Expectation::Drops { min, max });
        }
        for (i, r) in e.reach.iter().enumerate() {
            let p = if e.reach.len() == 1 { "expect.reach".to_owned() } else { format!("expect.reach.{i}") };
            if self.dim == 2 && matches!(r.side, Side::Front | Side::Back) {
                let help = "accepted: left, right, bottom, top";
                return Err(self.error(
                    &format!("{p}.side"),
                    "a scene of 2 dimensions has no such side",
                    help,
                ));
            }
            let tolerance = self.positive_length(&format!("{p}.tolerance"), "the tolerance", r.tolerance)?;
            out.push(Expectation::Reach { side: r.side, value: r.value.resolve(self.dx), tolerance });
        }
        Ok(())
    }

    fn expect_angles(
        &self,
        e: &ExpectFile,
        angles: &[(&str, Option<f64>)],
        out: &mut Vec<Expectation>,
    ) -> Result<(), SceneError> {
        let names: Vec<&str> = angles.iter().map(|a| a.0).collect();
        for (i, c) in e.contact_angle.iter().enumerate() {
            let many = e.contact_angle.len() > 1;
            let p =
                if many { format!("expect.contact_angle.{i}") } else { "expect.contact_angle".to_owned() };
            self.check_known_solid(&format!("{p}.solid"), false, &c.solid, &names)?;
            let young = angles.iter().find(|a| a.0 == c.solid).and_then(|a| a.1);
            let Some(value) = c.value.or(young.map(Angle)) else {
                let message =
                    format!("Young's angle varies over `{}`: the expected angle must be given", c.solid);
                return Err(self.error(&p, message, "add `value = \"90 deg\"`"));
            };
            let value = self.angle(&format!("{p}.value"), value)?;
            let tolerance = self.positive(&format!("{p}.tolerance"), "the tolerance", c.tolerance.0)?;
            out.push(Expectation::ContactAngle { solid: c.solid.clone(), value, tolerance });
        }
        Ok(())
    }

    fn expect_solids(
        &self,
        e: &ExpectFile,
        names: &[&str],
        out: &mut Vec<Expectation>,
    ) -> Result<(), SceneError> {
        for (i, name) in e.floats.iter().enumerate() {
            self.check_known_solid(&format!("expect.floats.{i}"), false, name, names)?;
            out.push(Expectation::Floats { solid: name.clone() });
        }
        for (i, name) in e.sinks.iter().enumerate() {
            let path = format!("expect.sinks.{i}");
            self.check_known_solid(&path, false, name, names)?;
            if e.floats.contains(name) {
                let message = format!("`{name}` cannot float and sink");
                return Err(self.error(&path, message, "remove it from `floats` or from `sinks`"));
            }
            out.push(Expectation::Sinks { solid: name.clone() });
        }
        for (i, w) in e.wetted.iter().enumerate() {
            let many = e.wetted.len() > 1;
            let p = if many { format!("expect.wetted.{i}") } else { "expect.wetted".to_owned() };
            self.check_known_solid(&format!("{p}.solid"), false, &w.solid, names)?;
            if w.min.is_none() && w.max.is_none() {
                return Err(self.error(&p, "the wetted share is not bounded", "give `min`, `max` or both"));
            }
            let min = self.within(&format!("{p}.min"), "the share", w.min.unwrap_or(0.0), 0.0, 1.0)?;
            let max = self.within(&format!("{p}.max"), "the share", w.max.unwrap_or(1.0), min, 1.0)?;
            out.push(Expectation::Wetted { solid: w.solid.clone(), min, max });
        }
        for (i, x) in e.position.iter().enumerate() {
            let many = e.position.len() > 1;
            let p = if many { format!("expect.position.{i}") } else { "expect.position".to_owned() };
            self.check_known_solid(&format!("{p}.solid"), false, &x.solid, names)?;
            let value = self.point(&format!("{p}.value"), &x.value)?;
            let tolerance = self.positive_length(&format!("{p}.tolerance"), "the tolerance", x.tolerance)?;
            let direction = |d: &Vec<f64>| self.direction(&format!("{p}.along"), d, self.dim);
            let along = x.along.as_ref().map(direction).transpose()?;
            out.push(Expectation::Position { solid: x.solid.clone(), value, tolerance, along });
        }
        Ok(())
    }

    fn expect_deflections(
        &self,
        e: &ExpectFile,
        names: &[&str],
        soft: &[&str],
        out: &mut Vec<Expectation>,
    ) -> Result<(), SceneError> {
        for (i, d) in e.deflection.iter().enumerate() {
            let many = e.deflection.len() > 1;
            let p = if many { format!("expect.deflection.{i}") } else { "expect.deflection".to_owned() };
            self.check_known_solid(&format!("{p}.solid"), false, &d.solid, names)?;
            if !soft.contains(&d.solid.as_str()) {
                let message = format!("the solid `{}` does not deform", d.solid);
                let help = "use material.neo_hookean, corotated or springs, or expect its `position`";
                return Err(self.error(&format!("{p}.solid"), message, help));
            }
            if d.min.is_none() && d.max.is_none() {
                return Err(self.error(&p, "the deflection is not bounded", "give `min`, `max` or both"));
            }
            let bound = |key: &str, l: Option<Length>, none: f64| {
                let value = l.map(|l| l.resolve(self.dx));
                value.map_or(Ok(none), |v| self.not_negative(&format!("{p}.{key}"), "a deflection", v))
            };
            let (min, max) = (bound("min", d.min, 0.0)?, bound("max", d.max, f64::INFINITY)?);
            if min > max {
                let message = format!("`max` ({max} m) is below `min` ({min} m)");
                return Err(self.error(&format!("{p}.max"), message, "swap them"));
            }
            out.push(Expectation::Deflection { solid: d.solid.clone(), min, max });
        }
        Ok(())
    }
}
