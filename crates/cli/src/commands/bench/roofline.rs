//! `meniscus bench step --roofline`: how far each phase of a step is from the limits of the machine (S. Williams, A. Waterman, D. Patterson,
//! "Roofline: an insightful visual performance model for multicore architectures", Commun. ACM 52 (2009) 65).
//!
//! A phase that moves `B` bytes between memory and processor and does `F` operations on floating-point numbers takes at least the larger of
//! `B/b` and `F/f`, with the bandwidth `b` of a triad, `a = b + s c`, and the peak rate `f` of multiply–adds, both measured here on the same
//! threads. `B` is what must move if every array that a phase reads and writes passes once, and `F` what its formulas need
//! (`book/performance.md` lists both; operations of curvature, volume and momentum are estimates). Limit: lists of cells, and arrays that a phase makes for itself, are not counted.

use super::step::StepBench;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Instant;

/// Entries of each array of the triad, 64 MB: larger than any cache.
const TRIAD_ENTRIES: usize = 1 << 23;
/// Repetitions of each measurement; the best one counts.
const REPETITIONS: usize = 5;
/// Independent sums of the measurement of the peak rate, in vectors of eight.
const SUMS: usize = 12;
/// Multiply–adds of each of these sums.
const SUM_LENGTH: usize = 1 << 20;
/// Size of a number in double precision, bytes.
const DOUBLE: f64 = size_of::<f64>() as f64;
/// Size of a number in single precision, bytes.
const SINGLE: f64 = size_of::<f32>() as f64;

/// Limits of the machine with the threads of the current pool.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Machine {
    threads: usize,
    /// Bandwidth of a triad, byte/s.
    bandwidth: f64,
    /// Rate of multiply–adds, operations/s, two for each.
    peak: f64,
}

impl Machine {
    /// Measures the machine.
    pub fn measure() -> Self {
        let threads = rayon::current_num_threads();
        Self { threads, bandwidth: triad_bandwidth(threads), peak: peak_rate(threads) }
    }
}

/// Bandwidth of `a = b + s c`, byte/s, counted as three arrays.
fn triad_bandwidth(threads: usize) -> f64 {
    let (mut a, b, c) = (vec![0.0; TRIAD_ENTRIES], vec![1.0; TRIAD_ENTRIES], vec![2.0; TRIAD_ENTRIES]);
    let chunk = TRIAD_ENTRIES.div_ceil(threads);
    let seconds = best_seconds(|| {
        let parts = a.par_chunks_mut(chunk).zip(b.par_chunks(chunk).zip(c.par_chunks(chunk)));
        parts.for_each(|(a, (b, c))| {
            a.iter_mut().zip(b.iter().zip(c)).for_each(|(a, (b, c))| *a = b + 3.0 * c);
        });
        black_box(&mut a);
    });
    3.0 * DOUBLE * TRIAD_ENTRIES as f64 / seconds
}

/// Rate of multiply–adds of numbers in registers, operations/s.
fn peak_rate(threads: usize) -> f64 {
    let work = |thread: usize| {
        let mut sums = [[thread as f64; 8]; SUMS];
        let factor = black_box(1.0 - 1e-9);
        for _ in 0..SUM_LENGTH {
            for sum in &mut sums {
                sum.iter_mut().for_each(|s| *s = s.mul_add(factor, factor));
            }
        }
        black_box(sums);
    };
    let seconds = best_seconds(|| (0..threads).into_par_iter().for_each(work));
    (2 * threads * SUMS * 8 * SUM_LENGTH) as f64 / seconds
}

fn best_seconds(mut work: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(once).fold(f64::INFINITY, f64::min)
}

/// The data that a phase of a step has to move, and the arithmetic that it has to do.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Work {
    /// Kind of the entities that the phase loops over.
    items: &'static str,
    /// Number of these entities.
    count: f64,
    /// Bytes that move between memory and processor.
    bytes: f64,
    /// Floating-point operations.
    operations: f64,
}

/// Operations of the interpolation from `n` points along each of `d` axes: a multiplication and an addition for each weight, axis by axis.
fn interpolation(n: i32, d: i32) -> f64 {
    (1..=d).map(|axes| 2.0 * f64::from(n).powi(axes)).sum()
}

/// The work of a phase; `None` for those of solids, which depends on their kind.
fn work(phase: &str, row: &StepBench) -> Option<Work> {
    let d = f64::from(row.dimension);
    let [points_2, points_4, points_6] = [2, 4, 6].map(|n| interpolation(n, row.dimension));
    let [liquid, band, surface] =
        [row.liquid_cells, row.band_cells, row.surface_cells].map(|count| count as f64);
    let faces = d * liquid;
    let of = |items, count: f64, bytes: f64, operations: f64| {
        Some(Work { items, count, bytes: count * bytes, operations: count * operations })
    };
    match phase {
        // φ and the velocity are read, φ is written. Two further velocities on the path, cubic in five of the 16 layers.
        "advect surface" => {
            let path = 2.0 * d * (11.0 * points_2 + 5.0 * points_4) / 16.0;
            of("band cells", band, (2.0 + d) * DOUBLE, path + points_6)
        }
        // Two evaluations with their gradients, which cost as much again, for the six inner layers of eight.
        "redistance" => of("band cells", 0.75 * band, 2.0 * DOUBLE, 4.0 * points_6),
        // Second derivatives and their invariants for the five inner layers of eight.
        "curvature" => of("band cells", 0.625 * band, 2.0 * DOUBLE, 30.0 * d * d),
        // Four measurements of dual cells, each cut into d! simplices; the last shifts the band.
        "volume" => {
            let simplices = if row.dimension == 2 { 2.0 } else { 6.0 };
            let measured = of("dual cells", surface, 4.0 * DOUBLE, 4.0 * simplices * 20.0 * d);
            measured.map(|w| Work { bytes: w.bytes + 2.0 * DOUBLE * band, ..w })
        }
        // Velocity read and written, φ before and after read; per face a cubic value, per cell two velocities on its path.
        "advect velocity" => {
            of("faces", faces, (2.0 + 2.0 / d) * DOUBLE, points_4 + 2.0 * points_2 + 4.0 * d)
        }
        // Per iteration: the image of the direction, the residual, the direction and the iterate, in single precision.
        "viscosity" => {
            let iteration = (12.0 * SINGLE, 10.0 * d + 10.0);
            let [bytes, operations] =
                [iteration.0, iteration.1].map(|n| n * row.viscosity_iterations_per_step);
            of("faces", faces, bytes + 4.0 * DOUBLE, operations)
        }
        // Per iteration: as above in double precision, and a multigrid cycle of six sweeps in single precision.
        "pressure" => {
            let cycle = (6.0 * 3.0 * SINGLE, 6.0 * (2.0 * d + 3.0));
            let bytes = 12.0 * DOUBLE + cycle.0 * 8.0 / 7.0;
            let operations = 4.0 * d + 12.0 + cycle.1 * 8.0 / 7.0;
            let n = row.iterations_per_step;
            of("liquid cells", liquid, n * bytes + (4.0 + 4.0 * d) * DOUBLE, n * operations + 12.0 * d)
        }
        // The moments read the velocity, the restoration changes it, and half of the band's faces are extended.
        "momentum and extension" => of("faces", faces + 0.5 * d * band, 3.0 * DOUBLE, 20.0),
        _ => None,
    }
}

/// The rows of a scene: seconds, work, and the time at the limits of the machine as a share of that measured.
pub fn rows(row: &StepBench, machine: &Machine) -> String {
    let Machine { threads, bandwidth, peak } = machine;
    let mut out = format!(
        "{}: {:.3} s/step on {threads} threads; triad {:.1} GB/s, peak {:.1} Gflop/s\n    {:22} {:>9} {:>9} {:13} {:>8} {:>8} {:>9} {:>9}\n",
        row.name,
        row.seconds_per_step,
        bandwidth * 1e-9,
        peak * 1e-9,
        "phase",
        "s",
        "millions",
        "of",
        "MB",
        "Mflop",
        "memory %",
        "flops %",
    );
    for (phase, seconds) in &row.phases {
        let Some(Work { items, count, bytes, operations }) = work(phase, row) else {
            let _ = writeln!(out, "    {phase:22} {seconds:9.4}");
            continue;
        };
        let [memory, flops] = [bytes / bandwidth, operations / peak].map(|limit| 100.0 * limit / seconds);
        let _ = writeln!(
            out,
            "    {phase:22} {seconds:9.4} {:9.3} {items:13} {:8.1} {:8.0} {memory:9.1} {flops:9.1}",
            count * 1e-6,
            bytes * 1e-6,
            operations * 1e-6,
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phase_of_the_liquid_has_work_and_the_machine_has_limits() {
        assert_eq!(interpolation(2, 3), 28.0);
        let row = StepBench {
            dimension: 3,
            liquid_cells: 1000,
            band_cells: 900,
            surface_cells: 100,
            iterations_per_step: 3.0,
            viscosity_iterations_per_step: 2.0,
            ..StepBench::default()
        };
        let phases = [
            "advect surface",
            "redistance",
            "curvature",
            "volume",
            "advect velocity",
            "viscosity",
            "pressure",
            "momentum and extension",
        ];
        for phase in phases {
            let work = work(phase, &row);
            assert!(work.is_some_and(|work| work.bytes > 0.0 && work.operations > 0.0), "{phase}");
        }
        assert_eq!(work("solids", &row), None);
        assert!(peak_rate(1) > 1e7);
    }
}
