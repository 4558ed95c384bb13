//! `[expect] repairs`: how much may have been mended in a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Makes the table and its list of bounds from one list of entries.
macro_rules! bounds {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Largest repairs of a run that are accepted, as named in `repairs` of `summary.json`. Counts are plain numbers, volumes are
        /// relative to the liquid's volume at the start, momenta to that of all the liquid at the largest root mean square speed of
        /// the run, angular momenta to that times the size of a cube of the start volume, lengths are in cells.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct RepairsFile {
            $($(#[$doc])* #[serde(default, skip_serializing_if = "Option::is_none")] pub $name: Option<f64>,)*
        }

        impl RepairsFile {
            /// The bounds that are given, by name.
            pub fn bounds(&self) -> Vec<(&'static str, f64)> {
                let all = [$((stringify!($name), self.$name),)*];
                all.into_iter().filter_map(|(name, max)| max.map(|max| (name, max))).collect()
            }

            /// Sets the bound of a name, if there is one of this name.
            pub fn set(&mut self, name: &str, max: f64) {
                $(if name == stringify!($name) { self.$name = Some(max); })*
            }
        }
    };
}

bounds! {
    /// Volume of the liquid that was deleted: components within solids, or that had come through one.
    deleted_volume,
    /// The part of it that had come through a solid.
    leaked_volume,
    /// Liquid cells that were deleted with it.
    deleted_cells,
    /// Volume that was moved to keep every component's volume, summed over components and steps.
    volume_shift,
    /// The same with its sign; its size counts.
    volume_shift_net,
    /// The largest `volume_shift` of a step, over the volume of the liquid.
    volume_shift_largest,
    /// Largest distance, in cells, by which a component's centre of mass was put back onto its path.
    center_shift,
    /// Volume of components that left no cell behind.
    vanished_volume,
    /// Their momentum.
    vanished_momentum,
    /// Volume of components that appeared where no liquid was.
    appeared_volume,
    /// Their momentum.
    appeared_momentum,
    /// Momentum that was restored to liquid that no held solid or side touches.
    momentum_restored,
    /// Angular momentum that was restored to it.
    spin_restored,
    /// Momentum that was restored, once it was carried along, to liquid that solids hold.
    carried_momentum_restored,
    /// Angular momentum that was restored to it.
    carried_spin_restored,
    /// Moment of the liquid's surface that contact lines too close together did not give to solids that deform.
    line_moment_lost,
    /// Cells of the surface whose curvature was cut down to the largest that the grid knows.
    clamped_curvatures,
    /// Faces at the surface whose curvature was unknown.
    unknown_curvatures,
    /// Solves of the curvature's filter that did not converge.
    filter_unconverged,
    /// Largest relative residual that such a solve ended with.
    filter_residual,
    /// Steps in which Newton's iterations for the volumes did not converge.
    volume_unconverged,
    /// Largest volume error that they left, over the volume of the liquid.
    volume_residual,
    /// Newton's iterations of solids for which only the positive part of the second derivatives could be used.
    indefinite_iterations,
    /// Largest share of the liquid's weight that the filter of the curvature beside solids leaves out.
    weight_left_out,
    /// Rounds of impacts whose Gauss-Seidel iterations ended at the largest number of sweeps.
    contact_sweeps,
    /// Steps in which rigid solids still hit one another after the largest number of rounds.
    contact_rounds,
    /// Rounds of impacts that did not bounce, as that would have made energy.
    stopped_bounces,
    /// Elements below three tenths of their volume, which an extra energy keeps upright, summed over the steps.
    crushed_elements,
    /// Free solids without an inverse of their inertia, summed over the steps.
    singular_inertia,
    /// Bodies of liquid between solids whose momentum was not restored, summed over the steps.
    unrestored,
    /// Times that a liquid cell had no component.
    unlabelled,
    /// Faces within solids that found no solid to slip along.
    slip_unknown,
    /// Steps whose forces acted for another time than the scheme asks for.
    limited_kicks,
    /// Steps that were accepted although volume or energy changed by more than is credible.
    doubtful_steps,
    /// Steps that were done again with half the length.
    redone,
    /// Those of them in which a solve failed or the liquid ran away.
    failed_tries,
    /// Iterations of all kinds that ended before they converged.
    unconverged,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::summary::UNCONVERGED;
    use meniscus_sim::Repairs;

    #[test]
    fn every_repair_can_be_bounded() {
        let mut file = RepairsFile::default();
        let names = Repairs::ENTRIES.iter().map(|(name, _)| *name).chain([UNCONVERGED]);
        let all: Vec<(&str, f64)> = names.map(|name| (name, 0.5)).collect();
        all.iter().for_each(|(name, max)| file.set(name, *max));
        assert_eq!(file.bounds(), all);
    }
}
