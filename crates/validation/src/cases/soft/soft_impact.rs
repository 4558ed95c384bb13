//! Impact of a drop on a deformable plate at three resolutions, as in the paper's Fig. 14.

use crate::measure::{at_least, bar};
use crate::{Case, Check, Mode};
use meniscus_numerics::Vector;
use meniscus_scene::build::AnySimulation;
use meniscus_scene::builtin;
use meniscus_scene::file::LoadOptions;
use meniscus_scene::output::frame::Frame;

/// The case.
pub const CASE: Case = Case {
    name: "soft-impact",
    title: "A drop falls on a soft plate: the contact points' histories converge",
    theory: "2D: the scene fig14-soft-plate at 256², 512² and 1024² cells, to 20 ms: it touches, spreads to \
        its widest and starts back. How far the outermost contact points of two resolutions are apart, as a \
        mean over times from the first contact on: from the coarse to the middle one over from the middle to \
        the fine one (the distance has to halve).",
    quick: false,
    run,
};

const NAME: &str = "soft-impact";
const RESOLUTIONS: [usize; 3] = [256, 512, 1024];
const TIMES: usize = 80;
const END: f64 = 0.02;

/// The outermost contact points at each time.
type History = Vec<Option<[Vector<3>; 2]>>;

fn run(_: Mode) -> Vec<Check> {
    let Some(all) = RESOLUTIONS.iter().map(|n| history(*n)).collect::<Option<Vec<History>>>() else {
        return Vec::new();
    };
    let size = 16e-3;
    let [first, second] =
        [0, 1].map(|k| mean_distance(&all[k], &all[k + 1]) / (size / RESOLUTIONS[0] as f64));
    let between = |k: usize| format!("{}² and {}²", RESOLUTIONS[k], RESOLUTIONS[k + 1]);
    let text = |k: usize| format!("contact points of {}, in cells of the coarsest", between(k));
    vec![
        Check::absolute(NAME, text(0), first, 0.0, bar(1.0)),
        Check::absolute(NAME, text(1), second, 0.0, bar(0.5)),
        at_least(NAME, "the first over the second", first / second, 2.0, 2.0),
    ]
}

/// The contact points of the scene at a resolution.
fn history(cells: usize) -> Option<History> {
    let sets = vec![format!("domain.resolution={cells}")];
    let scene = builtin::open("fig14-soft-plate", &LoadOptions { sets, ..LoadOptions::default() }).ok()?;
    let mut simulation = AnySimulation::of(&scene).ok()?;
    let mut history = History::new();
    for k in 1..=TIMES {
        simulation.run_to(END * k as f64 / TIMES as f64).ok()?;
        history.push(outermost(&simulation.frame().ok()?));
    }
    Some(history)
}

/// The first and the last contact point along the plate.
fn outermost(frame: &Frame) -> Option<[Vector<3>; 2]> {
    let mut points = frame.contact_line.as_ref()?.positions.clone();
    points.sort_by(|p, q| p[0].total_cmp(&q[0]));
    points.first().zip(points.last()).filter(|(p, q)| p[0] < q[0]).map(|(p, q)| [*p, *q].map(Vector::from))
}

/// Mean distance of the points of two histories, m, at the times when both have points.
fn mean_distance(one: &History, other: &History) -> f64 {
    let both = one.iter().zip(other).filter_map(|(p, q)| p.zip(*q));
    let each: Vec<f64> = both.flat_map(|(p, q)| [0, 1].map(|k| (p[k] - q[k]).norm())).collect();
    each.iter().sum::<f64>() / each.len().max(1) as f64
}
