//! `[expect] repairs`: how much may have been mended in a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Makes the table and its list of bounds from one list of entries.
macro_rules! bounds {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Largest accepted repairs of a run, named as in `repairs` of `summary.json`. Counts are plain
        /// numbers. Volumes are relative to the volume of the liquid at the start, momenta to that of all the
        /// liquid at its largest root mean square speed of the run, angular momenta to this momentum times the
        /// edge of a cube of the start volume. Lengths are in cells.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct RepairBounds {
            $($(#[$doc])* #[serde(default, skip_serializing_if = "Option::is_none")] pub $name: Option<f64>,)*
        }

        impl RepairBounds {
            /// The bounds that are given, by name.
            pub fn bounds(&self) -> Vec<(&'static str, f64)> {
                let all = [$((stringify!($name), self.$name),)*];
                all.into_iter().filter_map(|(name, max)| max.map(|max| (name, max))).collect()
            }

            /// Whether none is given.
            pub fn is_empty(&self) -> bool {
                self.bounds().is_empty()
            }
        }
    };
}

bounds! {
    /// Volume of deleted liquid: components that lay entirely within solids or had leaked through one.
    deleted_volume,
    /// The part of `deleted_volume` that had leaked through a solid.
    leaked_volume,
    /// Number of liquid cells that were deleted with `deleted_volume`.
    deleted_cells,
    /// Volume that was moved to restore the volume of every component, summed over components and steps.
    volume_shift,
    /// Volume that was moved to restore the volume of every component, summed with its sign: positive where
    /// liquid was added. The bound is for its absolute value.
    volume_shift_net,
    /// The largest `volume_shift` of a step, over the volume of the liquid.
    volume_shift_largest,
    /// Largest distance, in cells, by which the centre of mass of a component was moved back onto its predicted
    /// path.
    center_shift,
    /// Volume of components that left no cell behind; the nearest component inherits it.
    vanished_volume,
    /// Momentum of the components of `vanished_volume`.
    vanished_momentum,
    /// Volume of components that appeared where no liquid was; they take it from the nearest component.
    appeared_volume,
    /// Momentum of the components of `appeared_volume`.
    appeared_momentum,
    /// Momentum that was restored to liquid that touches no constrained solid and no side.
    momentum_restored,
    /// Angular momentum that was restored to liquid that touches no constrained solid and no side.
    spin_restored,
    /// Momentum that was restored after advection to liquid that touches constrained solids.
    carried_momentum_restored,
    /// Angular momentum that was restored after advection to liquid that touches constrained solids.
    carried_spin_restored,
    /// Moment of surface tension that deformable solids did not receive because their contact lines are too
    /// close together.
    line_moment_lost,
    /// Cells at the free surface whose curvature was reduced to the largest one allowed, 2 per cell.
    clamped_curvatures,
    /// Faces at the free surface whose curvature is not known on either side: no surface tension acts there.
    unknown_curvatures,
    /// Solves of the curvature filter that did not converge.
    filter_unconverged,
    /// Largest relative residual of a solve of the curvature filter that did not converge.
    filter_residual,
    /// Steps in which Newton's iteration for the volumes of the components did not converge.
    volume_unconverged,
    /// Largest volume error that remained in a step of `volume_unconverged`, over the volume of the liquid.
    volume_residual,
    /// Newton iterations of solids with an indefinite Hessian, which was replaced by its positive part.
    indefinite_iterations,
    /// Largest share of the liquid's weight that the energy beside solids leaves out.
    weight_left_out,
    /// Rounds of impacts whose Gauss-Seidel iteration did not converge within the largest number of sweeps.
    contact_sweeps,
    /// Steps in which rigid solids still collided after the largest number of rounds of impacts.
    contact_rounds,
    /// Rounds of impacts without restitution, because with it they would have created energy.
    stopped_bounces,
    /// Elements with less than three tenths of their rest volume, where the inversion barrier acts, summed over
    /// the steps.
    crushed_elements,
    /// Free solids with a singular inertia matrix, summed over the steps.
    singular_inertia,
    /// Groups of components between solids whose momentum was not restored, summed over the steps.
    unrestored,
    /// Look-ups of the component of a liquid cell that has none.
    unlabelled,
    /// Faces within solids for which no solid was found to slip along: their velocity is zero.
    slip_unknown,
    /// Steps whose impulse time was bounded because the step had changed by too much.
    limited_kicks,
    /// Steps that were accepted although volume or energy changed by more than the bounds.
    doubtful_steps,
    /// Steps that were undone and repeated with half the length.
    redone,
    /// Steps of `redone` in which a solve failed or the velocity became too large.
    failed_tries,
    /// Iterations that ended before they converged: the sum of `filter_unconverged`, `volume_unconverged`,
    /// `contact_sweeps` and `contact_rounds`.
    unconverged,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::summary::UNCONVERGED;
    use meniscus_sim::Repairs;

    #[test]
    fn every_repair_can_be_bounded() {
        let names = Repairs::ENTRIES.iter().map(|(name, _)| *name).chain([UNCONVERGED]);
        let all: Vec<(&str, f64)> = names.map(|name| (name, 0.5)).collect();
        let text: String = all.iter().map(|(name, max)| format!("{name} = {max}\n")).collect();
        assert_eq!(toml::from_str::<RepairBounds>(&text).unwrap().bounds(), all);
    }
}
