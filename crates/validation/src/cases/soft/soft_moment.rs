//! The bending moment of a beam that carries a drop, against statics.

use crate::measure::{TimeMean, bars, checks_or_failure, external_load, liquid_force};
use crate::plate::vertices_at_height;
use crate::setup::{at_rest, block, run_to, unit_model};
use crate::soft::SoftMaterial;
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_numerics::fit::least_squares;
use meniscus_numerics::grid::Grid;
use meniscus_sim::{Hysteresis, Model, Simulation, StepError, Wall};

/// The case.
pub const CASE: Case = Case {
    name: "soft-moment",
    title: "A drop bends a beam by its weight and the lever of it",
    theory: "2D, SI: a water drop (radius 1 mm, friction of the line 0.3 Pa s) is put on a beam (9 mm by 0.4 mm, 500 kPa, \
        ν = 0.45, density 1100) that is clamped over its first 0.5 mm. At 30 degrees it spreads to the tip, where an edge holds \
        its line; at 90 ± 20 degrees it stays in mid-beam. In the dry part between clamp and drop statics give the moment, \
        M(s) = W (x_drop − x(s)) + ∫ ρ_s g t (x − x(s)) ds' from s to the tip. The beam's is B κ, B = E t³/12(1−ν²), κ the \
        slope of the middle line's angle by a parabola over 0.6 mm to both sides. The liquid's moment about the clamp is what the \
        clamp's reaction balances, less the beam's own. Means from 0.3 to 0.8 s. 8 and 16 cells a millimetre. Quick: the first drop, 8 cells.",
    quick: true,
    run: |mode| checks_or_failure(NAME, run(mode)),
};

const NAME: &str = "soft-moment";
const MM: f64 = 1e-3;
const YOUNG: f64 = 500e3;
const POISSON: f64 = 0.45;
const DENSITY: f64 = 1100.0;
const LIQUID_DENSITY: f64 = 1000.0;
const GRAVITY: f64 = 9.81;
const THICKNESS: f64 = 0.4 * MM;
/// Ends of the beam, and height of its lower side, m.
const BEAM: [f64; 2] = [MM, 10.0 * MM];
const BEAM_BOTTOM: f64 = 3.6 * MM;
/// End of the clamp, m.
const CLAMP_END: f64 = 1.5 * MM;
/// Positions where moments are compared, m: more than a plate's thickness from the clamp and from the liquid.
const STATIONS: [f64; 4] = [2.5 * MM, 3.0 * MM, 3.5 * MM, 4.0 * MM];
/// Half the length of the fit of the curvature, m.
const FIT_HALF_LENGTH: f64 = 0.6 * MM;

/// Time window of the means, s. Beam and drop oscillate with a period of 0.07 s, sustained by the lines at the edges: means over two
/// periods differ by several per cent.
const AVERAGING_WINDOW: [f64; 2] = [0.3, 0.8];

/// A drop on the beam.
struct DropCase {
    angle: f64,
    hysteresis: Option<f64>,
    damping: f64,
}

const DROPS: [DropCase; 2] = [
    DropCase { angle: 30.0, hysteresis: None, damping: 0.1 },
    DropCase { angle: 90.0, hysteresis: Some(20.0), damping: 0.3 },
];

fn run(mode: Mode) -> Result<Vec<Check>, StepError> {
    let (cells, drops): (&[usize], _) =
        if mode == Mode::Quick { (&[8], &DROPS[..1]) } else { (&[8, 16], &DROPS[..]) };
    let mut checks = Vec::new();
    for &cells in cells {
        for drop in drops {
            checks.extend(drop.checks(cells)?);
        }
    }
    Ok(checks)
}

/// Means over time.
struct Means {
    /// Points of the middle line: position at rest, and mean position.
    middle: Vec<(f64, [TimeMean; 2])>,
    /// Weight of the liquid, N/m, and the position of its centre, m.
    weight: TimeMean,
    center: TimeMean,
    /// Upward force reported for the liquid, N/m; moment of the clamp's reaction about the clamp's end, N.
    force: TimeMean,
    moment: TimeMean,
}

impl DropCase {
    fn checks(&self, cells: usize) -> Result<Vec<Check>, StepError> {
        let means = self.means(cells)?;
        let what = |text: &str| format!("{text}, θ = {}°, {cells} cells/mm", self.angle);
        let (weight, center) = (means.weight.mean(), means.center.mean());
        let mut checks: Vec<Check> = STATIONS
            .iter()
            .map(|&place| {
                let text = what(&format!("moment at s = {} mm", place / MM));
                let told = means.static_moment(place);
                Check::relative(NAME, text, means.bending_moment(place), told, bars(0.03, 0.01)).in_unit("N")
            })
            .collect();
        let torque = weight * (center - CLAMP_END);
        let (found, text) = (-means.moment.mean(), what("moment of the liquid about the clamp"));
        checks.push(Check::relative(NAME, text, found, torque, bars(0.03, 0.01)).in_unit("N"));
        let (found, text) = (-means.force.mean(), what("force of the liquid"));
        checks.push(Check::relative(NAME, text, found, weight, bars(0.02, 0.01)).in_unit("N/m"));
        Ok(checks)
    }

    fn means(&self, cells: usize) -> Result<Means, StepError> {
        let mut sim = self.start(cells)?;
        let [from, to] = AVERAGING_WINDOW;
        let lines = middle_line(&sim);
        let middle = lines.iter().map(|(s, _)| (*s, [TimeMean::default(); 2])).collect();
        let none = TimeMean::default();
        let mut means = Means { middle, weight: none, center: none, force: none, moment: none };
        let clamp = Vector::<2>::new(CLAMP_END, BEAM_BOTTOM + 0.5 * THICKNESS);
        run_to(&mut sim, from, |_, _| ())?;
        run_to(&mut sim, to, |sim, report| {
            let dt = report.dt;
            means.weight.add(LIQUID_DENSITY * GRAVITY * report.diagnostics.volume, dt);
            means.center.add(report.diagnostics.centroid[0], dt);
            means.force.add(liquid_force(sim, 0)[1], dt);
            means.moment.add(external_load(sim, 0, &clamp).map_or(f64::NAN, |load| load.moment), dt);
            let Some(body) = sim.state.solids[0].as_deformable() else { return };
            for ((_, mean), (_, [top, bottom])) in means.middle.iter_mut().zip(&lines) {
                let at = 0.5 * (body.vertices.positions[*top] + body.vertices.positions[*bottom]);
                (0..2).for_each(|a| mean[a].add(at[a], dt));
            }
        })?;
        Ok(means)
    }

    fn start(&self, cells: usize) -> Result<Simulation<2>, StepError> {
        let dx = MM / cells as f64;
        let shape = block(
            Vector::<2>::new(0.5 * (BEAM[0] + BEAM[1]), BEAM_BOTTOM + 0.5 * THICKNESS),
            Vector::<2>::new(0.5 * (BEAM[1] - BEAM[0]), 0.5 * THICKNESS),
        );
        let material =
            SoftMaterial { young: YOUNG, poisson: POISSON, density: DENSITY, damping: self.damping };
        let mut beam = material.solid(shape, dx / 1.5, |x| x[0] <= CLAMP_END)?;
        beam.young_cosine = self.angle.to_radians().cos();
        beam.line_friction = 0.3;
        beam.hysteresis = self.hysteresis.map(|by| Hysteresis::Around([by.to_radians(); 2]));
        let model = Model {
            density: LIQUID_DENSITY,
            kinematic_viscosity: 1e-6,
            surface_tension: 72.8e-3,
            gravity: Vector::<2>::new(0.0, -GRAVITY),
            solids: vec![beam],
            ..unit_model(Grid::<2>::new([14 * cells, 8 * cells], dx), [[Wall::Slip; 2]; 2])
        };
        let center = Vector::<2>::new(6.0 * MM, 5.05 * MM);
        let ball = move |x: &Vector<2>| (x - center).norm() - MM;
        Ok(at_rest(model, &ball))
    }
}

/// Positions along the beam at rest, in order, and the vertices of the upper and the lower side there.
fn middle_line(sim: &Simulation<2>) -> Vec<(f64, [usize; 2])> {
    let Some(elastic) = sim.model.solids[0].elastic() else { return Vec::new() };
    let side = |height: f64| vertices_at_height(&elastic.rest_mesh().positions, height, 0.0);
    let pairs = side(BEAM_BOTTOM + THICKNESS).into_iter().zip(side(BEAM_BOTTOM));
    pairs.map(|((top, s), (bottom, _))| (s, [top, bottom])).collect()
}

impl Means {
    /// The mean middle line.
    fn line(&self) -> Vec<(f64, Vector<2>)> {
        self.middle.iter().map(|(s, x)| (*s, Vector::<2>::new(x[0].mean(), x[1].mean()))).collect()
    }

    /// B κ at a position along the beam, N; positive where it bends down.
    fn bending_moment(&self, place: f64) -> f64 {
        let line = self.line();
        let near = line.windows(2).filter_map(|pair| {
            let (s, way) = (0.5 * (pair[0].0 + pair[1].0) - place, pair[1].1 - pair[0].1);
            (s.abs() < FIT_HALF_LENGTH).then(|| {
                (1.0, [1.0, s / FIT_HALF_LENGTH, (s / FIT_HALF_LENGTH).powi(2)], way[1].atan2(way[0]))
            })
        });
        let stiffness = YOUNG * THICKNESS.powi(3) / (12.0 * (1.0 - POISSON * POISSON));
        least_squares(near).map_or(f64::NAN, |fit| -stiffness * fit[1] / FIT_HALF_LENGTH)
    }

    /// Static moment of the part beyond a position along the beam, N.
    fn static_moment(&self, place: f64) -> f64 {
        let line = self.line();
        let next = line.partition_point(|(s, _)| *s < place).clamp(1, line.len() - 1);
        let ((a, from), (b, to)) = (line[next - 1], line[next]);
        let here = from + (to - from) * ((place - a) / (b - a));
        let rest = std::iter::once((place, here)).chain(line[next..].iter().copied());
        let rest: Vec<(f64, f64)> = rest.map(|(s, x)| (s, x[0] - here[0])).collect();
        let arms: f64 = rest.windows(2).map(|p| 0.5 * (p[0].1 + p[1].1) * (p[1].0 - p[0].0)).sum();
        self.weight.mean() * (self.center.mean() - here[0]) + DENSITY * GRAVITY * THICKNESS * arms
    }
}
