//! The text of `meniscus check`.

use super::check::{MIN_CAPILLARY_LENGTH_CELLS, PairReport, Report};
use super::memory;
use crate::file::WALLS;
use crate::units::{format_si, format_volume};
use std::fmt::Write as _;

/// A fact: its name and its value.
type Line = (String, String);

fn line(name: impl Into<String>, value: String) -> Line {
    (name.into(), value)
}

/// Formats a duration, s.
fn format_duration(s: f64) -> String {
    match s {
        s if s < 1.0 => "less than a second".to_owned(),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

impl Report {
    /// Volume of the liquid at the start without the part that solids displace, m³ (2D: m²).
    fn remaining_liquid_volume(&self) -> f64 {
        self.displaced.iter().map(|d| d.volume - d.displaced).sum()
    }

    /// The report as plain text, one fact per line.
    pub fn render(&self) -> String {
        let mut out = format!("{} ({}D)\n", self.name, self.dimension);
        let soft = self.soft.iter().flat_map(|s| s.lines(self.dimension));
        let lines = [self.grid_and_liquid(), self.cost(), self.scales(), self.wetting()];
        for (name, value) in lines.into_iter().flatten().chain(soft) {
            let _ = writeln!(out, "  {name:<24}{value}");
        }
        for w in &self.warnings {
            let _ = writeln!(out, "warning: {}: {}", w.path, w.message);
        }
        if let (Some(why), None) = (&self.cannot_run, &self.error) {
            let _ = writeln!(out, "cannot run: {why}");
        }
        out
    }

    /// Cells, and the volume of the liquid.
    fn grid_and_liquid(&self) -> Vec<Line> {
        let cells: Vec<String> = self.cells.iter().map(ToString::to_string).collect();
        let size = format_si(self.dx, "m");
        let cells = format!("{} = {:.0}, dx = {size}", cells.join(" x "), self.cell_count);
        let mut lines = vec![line("cells", cells)];
        if let Some(v) = self.liquid_volume {
            let n = self.liquid_cells.unwrap_or(0.0);
            lines.push(line("liquid", format!("{}, {n:.0} cells", format_volume(v, self.dimension))));
        }
        let [laid, gone] =
            self.displaced.iter().fold([0.0, 0.0], |[v, d], b| [v + b.volume, d + b.displaced]);
        if gone > 0.0 {
            let [laid, left] = [laid, laid - gone].map(|v| format_volume(v, self.dimension));
            let share = 100.0 * gone / (gone + self.remaining_liquid_volume()).max(f64::MIN_POSITIVE);
            let value = format!("{left} of {laid}: the solids displace {share:.1} %");
            lines.push(line("beside the solids", value));
        }
        lines
    }

    /// Memory, steps and time of a run.
    fn cost(&self) -> Vec<Line> {
        let capillary_step = format_si(self.capillary_step, "s");
        vec![
            line("memory", format!("about {}", memory::format_bytes(self.memory_bytes))),
            line("steps", format!("about {:.0} of {}", self.steps, format_si(self.time_step, "s"))),
            line("time", format!("roughly {}, without pictures", format_duration(self.run_seconds))),
            line("capillary step", format!("{capillary_step} (explicit limit)")),
        ]
    }

    /// Lengths in cells, and dimensionless numbers.
    fn scales(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        for b in &self.bodies {
            if let (Some(r), Some(n)) = (b.radius, b.cells_per_radius) {
                let value = format!("radius {}, {n:.1} cells", format_si(r, "m"));
                lines.push(line(format!("body {}", b.index), value));
            }
        }
        if let (Some(c), Some(n)) = (self.capillary_length, self.capillary_length_cells) {
            let hint = if n < MIN_CAPILLARY_LENGTH_CELLS { ", too few to resolve a meniscus" } else { "" };
            lines.push(line("capillary length", format!("{}, {n:.1} cells{hint}", format_si(c, "m"))));
        }
        let numbers = [
            ("Bo = rho g R^2 / gamma", self.bond),
            ("We = rho U^2 D / gamma", self.weber),
            ("Oh = mu/sqrt(rho gamma D)", self.ohnesorge),
            ("La = gamma rho D / mu^2", self.laplace),
            ("Re = U D / nu", self.reynolds),
        ];
        lines.extend(
            numbers.iter().filter_map(|(name, value)| Some(line(*name, format!(" {:.4}", (*value)?)))),
        );
        lines
    }

    /// Contact angles, and a hint where no friction holds contact lines back.
    fn wetting(&self) -> Vec<Line> {
        let of_pair = |p: &PairReport| line(format!("angle on {}", p.solid), p.text());
        let mut lines: Vec<Line> = self.pairs.iter().map(of_pair).collect();
        let free = self.pairs.iter().filter(|p| p.solid != WALLS && p.line_friction == 0.0);
        let free: Vec<&str> = free.map(|p| p.solid.as_str()).collect();
        if !free.is_empty() {
            let hint = "contact lines move at inertial speed (see contact_line.friction; water on a plate: about 0.1 Pa s)";
            lines.push(line("no line friction", format!("on {}: {hint}", free.join(", "))));
        }
        lines
    }
}

impl PairReport {
    /// Angle, kind of wetting and elastocapillary lengths.
    fn text(&self) -> String {
        let mut text = match (self.young_angles, self.young_angle) {
            (Some([low, high]), _) => format!("{low:.2} to {high:.2} deg, "),
            (None, Some(a)) => format!("{a:.2} deg, "),
            (None, None) => String::new(),
        };
        text += self.wetting;
        if let Some(l) = self.elastocapillary_length {
            let _ = write!(text, ", elastocapillary length γ/E = {}", format_si(l, "m"));
        }
        if let Some(l) = self.bending_elastocapillary_length {
            let _ = write!(text, ", bending elastocapillary length √(B/γ) = {}", format_si(l, "m"));
        }
        text
    }
}
