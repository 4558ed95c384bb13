//! The invariants: their names, bounds, and reasons of the bounds.

/// An invariant of every run.
#[derive(Clone, Copy, Debug)]
pub struct Invariant {
    /// Its name.
    pub name: &'static str,
    /// What must hold.
    pub holds: &'static str,
}

/// Growth of the energy relative to its initial scale: 1 %. Discretisation errors of the surface area at eight cells per radius are a
/// tenth of it.
pub const MAX_ENERGY_GROWTH: f64 = 0.01;
/// Rise of the energy in a step, relative to its scale, in sets where no step may have one. Rounding and the pressure residual (relative
/// tolerance 1e-6) are smaller.
pub const MAX_ENERGY_RISE_PER_STEP: f64 = 1e-6;
/// Unexplained momentum over that of all mass at the largest root mean square speed. Discretisation losses are restored, so only rounding
/// and the solver's residual (1e-6) remain.
pub const MAX_MOMENTUM_ERROR: f64 = 1e-5;
/// Relative volume error.
pub const MAX_VOLUME_ERROR: f64 = 1e-3;
/// Overlap of solids beyond that at the start, in cells; `[expect]` has the same tolerance.
pub const MAX_OVERLAP_CELLS: f64 = 0.01;
/// Depth of liquid within a solid, in cells.
pub const MAX_LIQUID_DEPTH_CELLS: f64 = 1.0;
/// Largest speed over the largest physical one.
pub const MAX_SPEED_RATIO: f64 = 3.0;
/// Longest step over the median, and the shortest that counts, s; below it machine noise dominates.
pub const SLOW_STEP_LIMITS: (f64, f64) = (50.0, 1.0);
/// Memory over the estimate of `check`, and the program's memory without a scene, bytes (code, tables, threads, allocator). The estimate
/// of large scenes is right within a third; twice it counts as a violation.
pub const MEMORY_LIMITS: (f64, f64) = (2.0, 64e6);
/// Processor time of a step that counts as hanging, s.
pub const HANG_CPU_SECONDS: f64 = 20.0;
/// Processor time after which a case ends without a verdict, s: 2D, 3D.
pub const CPU_BUDGET_SECONDS: [f64; 2] = [60.0, 150.0];
/// Steps after which a case ends without a verdict: twice the expected number.
pub const MAX_STEPS: u64 = 1200;
/// The same for the drop test, whose cases are longer, s.
pub const DROP_TEST_CPU_BUDGET_SECONDS: [f64; 2] = [180.0, 900.0];
/// Steps of a drop-test case after which it ends without a verdict.
pub const DROP_TEST_MAX_STEPS: u64 = 6000;
/// Tolerances of a mirrored run after [`COMPARED_STEPS`] steps: energy over its scale, and centre of mass in cells. The differences come
/// from rounding and the solver's residual (1e-6), amplified by the flow.
pub const MIRROR_TOLERANCES: (f64, f64) = (0.01, 0.1);
/// The same for a shifted run: the second-order error of drops of four cells per radius, `(1/4)²`, the smallest that are drawn.
pub const SHIFT_TOLERANCES: (f64, f64) = (0.06, 0.25);
/// Steps after which repeated runs are compared.
pub const COMPARED_STEPS: u64 = 60;

/// All invariants, worst first.
pub const INVARIANTS: [Invariant; 22] = [
    Invariant { name: "panic", holds: "the program does not panic" },
    Invariant { name: "hang", holds: "no step takes 20 s" },
    Invariant { name: "not-finite", holds: "all fields and sums are finite" },
    Invariant { name: "gave-up", holds: "the solver can continue" },
    Invariant { name: "inverted", holds: "no element of a solid is inverted" },
    Invariant { name: "overlap", holds: "solids overlap by at most 0.01 cells more than at the start" },
    Invariant { name: "speed", holds: "the liquid is at most 3 times as fast as its energy allows" },
    Invariant { name: "solid-speed", holds: "rigid solids are at most 3 times as fast as the energy allows" },
    Invariant {
        name: "energy",
        holds: "without external work the energy exceeds its initial value by at most 1 % of its scale",
    },
    Invariant {
        name: "energy-again",
        holds: "the mean energy of 8 steps exceeds its minimum so far by at most 1 % of its scale",
    },
    Invariant {
        name: "energy-step",
        holds: "in no step of the drop test does the energy rise by more than 1e-6 of its scale",
    },
    Invariant { name: "momentum", holds: "without contact with a side, momentum is conserved within 1e-5" },
    Invariant { name: "volume", holds: "at most 1e-3 of the initial volume is lost or misplaced" },
    Invariant {
        name: "volume-before",
        holds: "before the volume correction no step misplaces more than 1e-3 of the initial volume",
    },
    Invariant { name: "leak", holds: "in no step does more than 1e-3 of the volume leak through a solid" },
    Invariant { name: "within-solid", holds: "no liquid is more than a cell deep inside a solid" },
    Invariant { name: "slow-step", holds: "no step takes more than 1 s and more than 50 times the median" },
    Invariant {
        name: "memory",
        holds: "peak memory is at most 64 MB plus twice the estimate of `meniscus check`",
    },
    Invariant { name: "threads", holds: "one and two threads give bitwise identical results" },
    Invariant { name: "resume", holds: "a run resumed from a checkpoint gives bitwise identical results" },
    Invariant {
        name: "mirror",
        holds: "the mirrored scene agrees within 1 % of the energy scale and 0.1 cells",
    },
    Invariant {
        name: "shift",
        holds: "the scene shifted by 0.37 cells agrees within 6 % of the energy scale and 0.25 cells",
    },
];
