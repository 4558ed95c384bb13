//! The repairs of a step: every mechanism that corrects the result of another one leaves a count or a sum here, measured before
//! the correction. No result depends on it.

/// Makes the record and the list of its entries from one table.
macro_rules! record {
    (@type count) => { u64 };
    (@type sum) => { f64 };
    (@type max) => { f64 };
    (@add count, $a:expr, $b:expr) => { $a += $b };
    (@add sum, $a:expr, $b:expr) => { $a += $b };
    (@add max, $a:expr, $b:expr) => { $a = $a.max($b) };
    (@from count, $v:expr) => { $v as u64 };
    (@from sum, $v:expr) => { $v };
    (@from max, $v:expr) => { $v };
    ($($(#[$doc:meta])* $name:ident: $merge:ident of $quantity:ident,)*) => {
        /// The repairs of a step, or of many.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Repairs {
            $($(#[$doc])* pub $name: record!(@type $merge),)*
        }

        impl Repairs {
            /// Names of all entries, and what each measures, in order.
            pub const ENTRIES: &'static [(&'static str, Quantity)] =
                &[$((stringify!($name), Quantity::$quantity),)*];

            /// The entries in the order of [`Self::ENTRIES`]. Counts are exact below 2⁵³.
            pub fn values(&self) -> Vec<f64> {
                vec![$(self.$name as f64,)*]
            }

            /// The record of which these are the [`Self::values`]; nothing if their number is another.
            pub fn from_values(values: &[f64]) -> Option<Self> {
                let mut next = values.iter().copied();
                let record = Self { $($name: record!(@from $merge, next.next()?),)* };
                next.next().is_none().then_some(record)
            }

            /// Takes the repairs of a later step into account: counts and sums add up, of largest values the larger stays.
            pub fn add(&mut self, step: &Self) {
                $(record!(@add $merge, self.$name, step.$name);)*
            }
        }
    };
}

/// What an entry of [`Repairs`] measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A number of events.
    Count,
    /// A volume, m³ (2D: m²).
    Volume,
    /// A momentum, kg m/s (2D: kg/s).
    Momentum,
    /// An angular momentum, kg m²/s (2D: kg m/s).
    AngularMomentum,
    /// A length, m.
    Length,
    /// A pure number.
    Ratio,
}

record! {
    /// Volume of the liquid that was deleted: components that lay within solids altogether or had come through one, m³
    /// (2D: m²), as far as it was outside of solids.
    deleted_volume: sum of Volume,
    /// The part of it that had come through a solid, m³ (2D: m²); the rest are residues that a receding line left in a solid.
    leaked_volume: sum of Volume,
    /// Liquid cells that were deleted with it.
    deleted_cells: count of Count,
    /// Volume that the shift of φ moved: the sum over all components of what each had too much or too little, m³ (2D: m²).
    volume_shift: sum of Volume,
    /// The same with its sign, m³ (2D: m²): positive where the shift added liquid.
    volume_shift_net: sum of Volume,
    /// The largest [`Self::volume_shift`] of a step, over the volume of the liquid.
    volume_shift_largest: max of Ratio,
    /// Largest distance that the centre of mass of a component was from its path before it was put back, m.
    center_shift: max of Length,
    /// Volume of components that left no cell behind; the nearest component inherits it, m³ (2D: m²).
    vanished_volume: sum of Volume,
    /// Their momentum, kg m/s (2D: kg/s), the sum of its sizes.
    vanished_momentum: sum of Momentum,
    /// Volume of components that appeared where no liquid was and that took it from the nearest one, m³ (2D: m²).
    appeared_volume: sum of Volume,
    /// Their momentum, kg m/s (2D: kg/s), the sum of its sizes, with the velocity of the component that gave them their volume.
    appeared_momentum: sum of Momentum,
    /// Momentum that was restored to liquid that no held solid or side touches, kg m/s (2D: kg/s), the sum of its sizes.
    momentum_restored: sum of Momentum,
    /// Angular momentum that was restored to it, kg m²/s (2D: kg m/s), the sum of its sizes.
    spin_restored: sum of AngularMomentum,
    /// Momentum that was restored, once it was carried along, to liquid that solids hold, kg m/s (2D: kg/s).
    carried_momentum_restored: sum of Momentum,
    /// Angular momentum that was restored to it, kg m²/s (2D: kg m/s).
    carried_spin_restored: sum of AngularMomentum,
    /// Moment of the liquid's surface that solids that deform did not get, because their contact lines are too close together to
    /// carry it, as angular momentum, kg m²/s (2D: kg m/s), the sum of its sizes.
    line_moment_lost: sum of AngularMomentum,
    /// Cells of the surface whose curvature was cut down to the largest that the grid knows, two radii a cell.
    clamped_curvatures: count of Count,
    /// Faces at the surface with an unknown curvature on both sides: no tension acts there.
    unknown_curvatures: count of Count,
    /// Solves of the curvature's filter that did not converge.
    filter_unconverged: count of Count,
    /// Largest relative residual that such a solve ended with.
    filter_residual: max of Ratio,
    /// Steps in which Newton's iterations for the volumes and centres of the components did not converge.
    volume_unconverged: count of Count,
    /// Largest volume error that they left, over the volume of the liquid.
    volume_residual: max of Ratio,
    /// Newton's iterations of solids whose second derivatives were not positive definite, so that their positive part was taken.
    indefinite_iterations: count of Count,
    /// Largest share of the liquid's weight that the filter of the curvature beside solids leaves out.
    weight_left_out: max of Ratio,
    /// Rounds of impacts whose iterations (Gauss–Seidel) ended unconverged at the largest number of sweeps.
    contact_sweeps: count of Count,
    /// Steps in which rigid solids still hit one another after the largest number of rounds.
    contact_rounds: count of Count,
    /// Rounds of impacts that did not bounce, as that would have made energy.
    stopped_bounces: count of Count,
    /// Elements below three tenths of their volume at rest, which an extra energy keeps upright, in every step.
    crushed_elements: count of Count,
    /// Free solids whose moments of inertia have no inverse, in every step: nothing turns them.
    singular_inertia: count of Count,
    /// Bodies of liquid, in every step, whose momentum was not restored, because they lie between solids: the mass of their faces
    /// differs from that of their volume by more than twice.
    unrestored: count of Count,
    /// Times that the component of a liquid cell was asked for where there is none; it then counts as the first component's.
    unlabelled: count of Count,
    /// Faces within solids for which no solid was found to slip along: their velocity is zero.
    slip_unknown: count of Count,
    /// Steps whose forces acted for a shorter or longer time than the leapfrog scheme asks for, because the length of the step
    /// had changed by too much.
    limited_kicks: count of Count,
    /// Steps that were accepted although volume or energy changed by more than is credible.
    doubtful_steps: count of Count,
    /// Steps that were thrown away and done again with half the length. Their other repairs are not counted.
    redone: count of Count,
    /// Those of them in which a solve for pressure, viscosity or a solid failed, or the liquid ran away.
    failed_tries: count of Count,
}

impl Repairs {
    /// Iterations of all kinds that ended before they converged.
    pub fn unconverged(&self) -> u64 {
        self.filter_unconverged + self.volume_unconverged + self.contact_sweeps + self.contact_rounds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_add_up_and_survive_as_numbers() {
        let step = Repairs {
            volume_shift: 0.5,
            volume_shift_largest: 0.25,
            contact_rounds: 1,
            ..Repairs::default()
        };
        let mut sum = Repairs { volume_shift_largest: 0.5, redone: 2, ..Repairs::default() };
        (0..2).for_each(|_| sum.add(&step));
        assert_eq!((sum.volume_shift, sum.volume_shift_largest), (1.0, 0.5));
        assert_eq!((sum.contact_rounds, sum.redone, sum.unconverged()), (2, 2, 2));
        assert_eq!(sum.values().len(), Repairs::ENTRIES.len());
        assert_eq!(Repairs::from_values(&sum.values()), Some(sum.clone()));
        assert_eq!(Repairs::from_values(&sum.values()[1..]), None);
    }
}
