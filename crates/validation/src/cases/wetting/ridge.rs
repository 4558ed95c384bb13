//! The wetting ridge of a contact line on a deformable layer.

use crate::measure::{at_least, bars, checks_or_failure, line_tracker};
use crate::plate::{PlateSetup, PlateSupport};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_sim::StepError;
use std::f64::consts::{FRAC_PI_2, PI};

/// Drops on layers.
pub const CASE: Case = Case {
    name: NAME,
    title: "A drop lifts a ridge on a soft layer",
    theory: "2D, no gravity: a drop (area π/2, θ = 90°, γ = ρ = 1, ν = 0.3) on a layer of thickness h = 1 \
        clamped at its bottom and ends. Its lines lift the layer, its pressure presses: linear elasticity in \
        plane strain tells how high the layer stands at the lines, how deep under the drop's middle, and how \
        wide the drop is on it (by Fourier transform; Style and Dufresne 2012). Either each line is spread \
        evenly over w to both sides (`contact_line.radius`; E = 50 γ/h), or the layer has a tension of its \
        own, 4 γ on both sides of the line (`contact_line.neumann`; E = 20 γ/h). The ridge is 2 to 3 % of h \
        high. 16 cells a unit, 24 with own tension: that of the mesh's edges rounds the tip off. Steps of \
        twice the explicit limit; quick: 12.",
    quick: true,
    run: |mode| checks_or_failure(NAME, ridges(mode)),
};

const NAME: &str = "wetting-ridge";

/// A layer of unit thickness, clamped at its bottom, in plane strain, and its line loads; units of γ and h.
#[derive(Clone, Copy)]
struct ElasticLayer {
    young: f64,
    poisson: f64,
    /// Surface tension of the solid.
    tension: f64,
    /// Half-width over which line loads are spread.
    width: f64,
}

/// Layer with spread line loads.
const SPREAD_LINE_LAYER: ElasticLayer = ElasticLayer { young: 50.0, poisson: 0.3, tension: 0.0, width: 0.1 };
/// Layer with a surface tension of its own.
const TENSIONED_LAYER: ElasticLayer = ElasticLayer { young: 20.0, poisson: 0.3, tension: 4.0, width: 0.0 };

impl ElasticLayer {
    /// Surface displacement under a load `cos kx` (Style and Dufresne 2012).
    fn compliance(&self, k: f64) -> f64 {
        let (nu, shear) = (self.poisson, self.young / (2.0 * (1.0 + self.poisson)));
        // Both parts are scaled by e^-2k, so that they stay finite.
        let (near, far) = ((-2.0 * k).exp(), (-4.0 * k).exp());
        let above = (3.0 - 4.0 * nu) * 0.5 * (1.0 - far) - 2.0 * k * near;
        let rest = 2.0 * k * k + 5.0 - 12.0 * nu + 8.0 * nu * nu;
        let below = (3.0 - 4.0 * nu) * 0.5 * (1.0 + far) + rest * near;
        1.0 / (shear * k / (1.0 - nu) * below / above + self.tension * k * k)
    }

    /// `∫ c(k) load(k) dk / π` over all wave numbers, with the compliance c.
    fn integral(&self, load: impl Fn(f64) -> f64) -> f64 {
        const STEP: f64 = 5e-3;
        let place = |i: u32| (f64::from(i) + 0.5) * STEP;
        (0..400_000).map(place).map(|k| self.compliance(k) * load(k)).sum::<f64>() * STEP / PI
    }

    /// The Fourier transform of a line load.
    fn line_load_transform(&self, k: f64) -> f64 {
        if self.width > 0.0 { (k * self.width).sin() / (k * self.width) } else { 1.0 }
    }

    /// Expected values of [`Self::measure`] for a drop of radius one: lines at ±1 and the drop's pressure. The drop is wider due to the
    /// layer's slope at the lines, where the contact angle holds, and due to the volume that sinks in.
    fn expected(&self) -> [f64; 3] {
        let drop = |k: f64| 2.0 * k.cos() * self.line_load_transform(k) - 2.0 * k.sin() / k;
        let [high, deep] = [1.0, 0.0].map(|x: f64| self.integral(|k| drop(k) * (k * x).cos()));
        let slope = self.integral(|k| -drop(k) * k * k.sin());
        let sunk = 2.0 * (high - self.integral(|k| drop(k) * k.sin() / k));
        let (s, c) = (FRAC_PI_2 - slope.atan()).sin_cos();
        let cap = (FRAC_PI_2 - slope.atan() - s * c) / (s * s);
        [((FRAC_PI_2 - sunk) / cap).sqrt(), high, deep]
    }

    /// Half the wetted width, and heights at the lines and under the middle, for a drop at rest.
    fn measure(&self, cells: usize) -> Result<[f64; 3], StepError> {
        let setting = PlateSetup {
            length: 8.0,
            thickness: 1.0,
            bending: self.young / (12.0 * (1.0 - self.poisson * self.poisson)),
            poisson: self.poisson,
            own_tension: self.tension,
            damping: 0.7,
            support: PlateSupport::BottomAndEnds,
            domain_and_plate_height: [3.2, 0.8],
            ..PlateSetup::free(cells, 90.0)
        };
        let mut plate = setting.start()?;
        plate.sim.model.numerics.line_radius = self.width;
        let tracker = line_tracker(&plate.sim);
        plate
            .mean_over_last_fifth(8.0, |p| {
                let points = tracker.extract(&p.sim).points;
                let ends = [points.first(), points.last()]
                    .map(|at| at.map_or(f64::NAN, |at| at.at[0] - p.middle[0]));
                Vector::<3>::new(
                    0.5 * (ends[0] - ends[1]).abs(),
                    p.mean_deflection(ends, 1.0),
                    p.mean_deflection([0.0; 2], 1.0),
                )
            })
            .map(Into::into)
    }
}

fn ridges(mode: Mode) -> Result<Vec<Check>, StepError> {
    if mode == Mode::Quick {
        return Ok(ridge(12, &ElasticLayer { width: 0.2, ..SPREAD_LINE_LAYER })?.0);
    }
    let mut checks = Vec::new();
    for (poisson, width) in [(0.3, 0.1), (0.3, 0.2), (0.45, 0.1), (0.45, 0.2)] {
        checks.extend(ridge(16, &ElasticLayer { poisson, width, ..SPREAD_LINE_LAYER })?.0);
    }
    let (rows, fine) = ridge(24, &ElasticLayer { poisson: 0.3, ..TENSIONED_LAYER })?;
    let (_, coarse) = ridge(12, &ElasticLayer { poisson: 0.3, ..TENSIONED_LAYER })?;
    checks.extend(rows);
    let text = "height of the ridge, ν = 0.3, own tension 4 γ: error of 12 cells/h over that of 24";
    checks.push(at_least(NAME, text, (coarse / fine).abs(), 1.5, 2.0));
    checks.extend(ridge(24, &ElasticLayer { poisson: 0.45, ..TENSIONED_LAYER })?.0);
    Ok(checks)
}

/// The checks of a layer, and the relative error of the ridge's height.
fn ridge(cells: usize, layer: &ElasticLayer) -> Result<(Vec<Check>, f64), StepError> {
    let ([half, high, deep], should) = (layer.measure(cells)?, layer.expected());
    let ElasticLayer { poisson, width, tension, .. } = layer;
    let which = if *width > 0.0 { format!("w = {width} h") } else { format!("own tension {tension} γ") };
    let what = |text: &str| format!("{text}, ν = {poisson}, {which}, {cells} cells/h");
    // The width has the tolerances of a drop's shape on a sheet (`elastica-drop`).
    let checks = vec![
        Check::relative(NAME, what("height of the ridge"), high, should[1], bars(0.08, 0.03)).in_unit("h"),
        Check::relative(NAME, what("depth under the drop"), deep, should[2], bars(0.08, 0.03)).in_unit("h"),
        Check::relative(NAME, what("half the wetted width"), half, should[0], bars(0.05, 0.02)).in_unit("h"),
    ];
    Ok((checks, high / should[1] - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_lines_are_those_of_the_table() {
        let spread = |poisson, width| ElasticLayer { young: 1.0, poisson, width, ..SPREAD_LINE_LAYER };
        // Υs = 30, γ = 72.8 and E = 3e4 in units of γ and h, cm.
        let tense = |poisson, h: f64| ElasticLayer {
            young: 3e4 * h / 72.8,
            poisson,
            tension: 30.0 / 72.8,
            width: 0.0,
        };
        let rows = [
            (spread(0.3, 0.025), 2.4114),
            (spread(0.3, 0.1), 1.6095),
            (spread(0.3, 0.2), 1.2121),
            (spread(0.45, 0.1), 1.2691),
            (spread(0.45, 0.2), 0.9217),
            (tense(0.5, 0.05), 0.003672 / 0.05),
            (tense(0.49, 0.1), 0.004522 / 0.1),
        ];
        for (layer, should) in rows {
            // Beyond the sum's last wave number, 2000, only the surface tension of the solid resists.
            let rest = if layer.tension > 0.0 { 1.0 / (PI * layer.tension * 2000.0) } else { 0.0 };
            let found = layer.integral(|k| layer.line_load_transform(k)) + rest;
            assert!((found / should - 1.0).abs() < 3e-3, "{found} {should}");
        }
    }
}
