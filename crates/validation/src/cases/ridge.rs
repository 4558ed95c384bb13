//! The ridge that a contact line lifts on a soft layer.

use crate::measure::{at_most, settle};
use crate::plate::{Held, Setting};
use crate::{Case, Check, Mode};
use meniscus_sim::{LineTracker, StepError};
use std::f64::consts::{FRAC_PI_2, PI};

/// Drops on layers.
pub const CASE: Case = Case {
    name: "wetting-ridge",
    title: "A drop lifts a ridge on a soft layer",
    theory: "2D, no gravity: a drop (area π/2, θ = 90°, γ = ρ = 1, ν = 0.3) on a layer of thickness h = 1 clamped at its bottom. Its \
        lines lift the layer, each spread evenly over w to both sides (`contact_line.radius`), its pressure presses: linear \
        elasticity in plane strain tells how high the layer stands at the lines and how deep under the drop's middle (design, \
        validation §4, 9). E = 50 γ/h: the ridge is 2 to 3 % of h high. 16 cells a unit; quick: 12.",
    quick: true,
    run: |mode| settle("wetting-ridge", ridges(mode)),
};

/// Young's modulus of the layers, γ/h.
const YOUNG: f64 = 50.0;

/// A layer of thickness one, clamped at its bottom, in plane strain.
#[derive(Clone, Copy)]
struct Layer {
    young: f64,
    poisson: f64,
}

impl Layer {
    /// Displacement of its surface under a load `cos kx` (Style and Dufresne 2012).
    fn gives(&self, k: f64) -> f64 {
        let (nu, shear) = (self.poisson, self.young / (2.0 * (1.0 + self.poisson)));
        // Both parts over e^2x, that they stay finite.
        let (near, far) = ((-2.0 * k).exp(), (-4.0 * k).exp());
        let above = (3.0 - 4.0 * nu) * 0.5 * (1.0 - far) - 2.0 * k * near;
        let rest = 2.0 * k * k + 5.0 - 12.0 * nu + 8.0 * nu * nu;
        let below = (3.0 - 4.0 * nu) * 0.5 * (1.0 + far) + rest * near;
        (1.0 - nu) / (shear * k) * above / below
    }

    /// Displacement at `x` under a load whose cosine transform is `load`, to wave numbers where that is nothing.
    fn lifted(&self, x: f64, load: impl Fn(f64) -> f64) -> f64 {
        const STEP: f64 = 5e-3;
        let part = |i: u32| {
            let k = (f64::from(i) + 0.5) * STEP;
            self.gives(k) * load(k) * (k * x).cos()
        };
        (0..400_000).map(part).sum::<f64>() * STEP / PI
    }

    /// Displacement at `x` by a drop of radius one: lines at ±1, each spread over `width` to both sides, and its pressure.
    fn under_drop(&self, x: f64, width: f64) -> f64 {
        self.lifted(x, |k| 2.0 * k.cos() * (k * width).sin() / (k * width) - 2.0 * k.sin() / k)
    }
}

fn ridges(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, rows): (_, &[(f64, f64)]) = match mode {
        Mode::Quick => (12, &[(0.3, 0.2)]),
        Mode::Full => (16, &[(0.3, 0.1), (0.3, 0.2), (0.45, 0.1), (0.45, 0.2)]),
    };
    let mut checks = Vec::new();
    for &(poisson, width) in rows {
        let setting = Setting {
            cells,
            angle: 90.0,
            first: 90.0,
            length: 8.0,
            thickness: 1.0,
            bending: YOUNG / (12.0 * (1.0 - poisson * poisson)),
            poisson,
            density: 1.0,
            damping: 0.7,
            area: FRAC_PI_2,
            place: 0.0,
            viscosity: 0.3,
            held: Held::Bottom,
            heights: [3.2, 0.8],
        };
        let mut plate = setting.start()?;
        plate.sim.model.numerics.line_radius = width;
        let tracker = LineTracker::new(&plate.sim.model, &[plate.sim.model.grid.dx / 1.5]);
        let lines = |p: &crate::plate::Plate| {
            let points = tracker.find(&p.sim).points;
            [points.first(), points.last()].map(|at| at.map_or(f64::NAN, |at| at.at[0] - p.middle[0]))
        };
        let sum = std::cell::RefCell::new([0.0; 2]);
        let high = plate.mean_of(8.0, |p| {
            let half = 0.5 * lines(p).map(f64::abs).iter().sum::<f64>();
            let mut sum = sum.borrow_mut();
            *sum = [sum[0] + half / 20.0, sum[1] + p.lift([0.0; 2], 1.0) / 20.0];
            p.lift(lines(p), 1.0)
        })?;
        let [half, deep] = sum.into_inner();
        let layer = Layer { young: YOUNG, poisson };
        let what = |text: &str| format!("{text}, ν = {poisson}, w = {width} h, {cells} cells/h");
        let name = "wetting-ridge";
        let at = |x: f64| layer.under_drop(x, width);
        checks.extend([
            Check::relative(name, &what("height of the ridge"), high, at(1.0), 0.08, Some(0.03), "h"),
            Check::relative(name, &what("depth under the drop"), deep, at(0.0), 0.08, Some(0.03), "h"),
            at_most(name, &what("half the wetted width less one"), half - 1.0, 0.02, Some(0.01), "h"),
        ]);
    }
    Ok(checks)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_lines_are_those_of_the_table() {
        for (poisson, width, should) in [
            (0.3, 0.025, 2.4114),
            (0.3, 0.1, 1.6095),
            (0.3, 0.2, 1.2121),
            (0.45, 0.1, 1.2691),
            (0.45, 0.2, 0.9217),
        ] {
            let layer = Layer { young: 1.0, poisson };
            let found = layer.lifted(0.0, |k| (k * width).sin() / (k * width));
            assert!((found / should - 1.0).abs() < 1e-3, "{poisson} {width}: {found}");
        }
    }
}
