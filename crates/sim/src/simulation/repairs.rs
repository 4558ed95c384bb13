//! Repairs of a step: every mechanism that corrects the result of another one records a count or a sum here, measured before
//! the correction. No result depends on this record.

/// Generates the record and the list of its entries from one table.
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
        /// Repairs of one step, or of many.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Repairs {
            $($(#[$doc])* pub $name: record!(@type $merge),)*
        }

        impl Repairs {
            /// Names and quantities of all entries, in order.
            pub const ENTRIES: &'static [(&'static str, Quantity)] =
                &[$((stringify!($name), Quantity::$quantity),)*];

            /// The entries in the order of [`Self::ENTRIES`]. Counts are exact below 2⁵³.
            pub fn values(&self) -> Vec<f64> {
                vec![$(self.$name as f64,)*]
            }

            /// The record with these [`Self::values`]; `None` if their number is wrong.
            pub fn from_values(values: &[f64]) -> Option<Self> {
                let mut next = values.iter().copied();
                let record = Self { $($name: record!(@from $merge, next.next()?),)* };
                next.next().is_none().then_some(record)
            }

            /// Adds the repairs of a later step: counts and sums add up, of maxima the larger one stays.
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
    /// Liquid volume outside solids that was deleted, m³ (2D: m²): components that lay entirely within solids or had leaked through one.
    deleted_volume: sum of Volume,
    /// Part of [`Self::deleted_volume`] that had leaked through a solid, m³ (2D: m²). The rest is residue of receding contact lines.
    leaked_volume: sum of Volume,
    /// Number of liquid cells deleted with it.
    deleted_cells: count of Count,
    /// Volume moved by the shift of φ: the sum of the absolute volume errors of all components, m³ (2D: m²).
    volume_shift: sum of Volume,
    /// The same with its sign, m³ (2D: m²): positive if the shift added liquid.
    volume_shift_net: sum of Volume,
    /// Largest [`Self::volume_shift`] of a step, over the volume of the liquid.
    volume_shift_largest: max of Ratio,
    /// Largest distance of a component's centre of mass from its predicted path before the correction, m.
    center_shift: max of Length,
    /// Volume of components that left no cell behind, m³ (2D: m²); the nearest component inherits it.
    vanished_volume: sum of Volume,
    /// Momentum of these components, kg m/s (2D: kg/s), sum of magnitudes.
    vanished_momentum: sum of Momentum,
    /// Volume of components that appeared where no liquid was and took it from the nearest component, m³ (2D: m²).
    appeared_volume: sum of Volume,
    /// Momentum of these components at the velocity of the component that gave the volume, kg m/s (2D: kg/s), sum of magnitudes.
    appeared_momentum: sum of Momentum,
    /// Momentum restored to liquid that touches no constrained solid and no side, kg m/s (2D: kg/s), sum of magnitudes.
    momentum_restored: sum of Momentum,
    /// Angular momentum restored to the same liquid, kg m²/s (2D: kg m/s), sum of magnitudes.
    spin_restored: sum of AngularMomentum,
    /// Momentum restored after advection to liquid that touches constrained solids, kg m/s (2D: kg/s).
    carried_momentum_restored: sum of Momentum,
    /// Angular momentum restored to the same liquid, kg m²/s (2D: kg m/s).
    carried_spin_restored: sum of AngularMomentum,
    /// Moment of surface tension that deformable solids did not receive because their contact lines are too close together to
    /// carry it, as angular momentum, kg m²/s (2D: kg m/s), sum of magnitudes.
    line_moment_lost: sum of AngularMomentum,
    /// Interface cells whose curvature was clamped to the largest one, 2/Δ.
    clamped_curvatures: count of Count,
    /// Interface faces with unknown curvature on both sides: no surface tension acts there.
    unknown_curvatures: count of Count,
    /// Solves of the curvature filter that did not converge.
    filter_unconverged: count of Count,
    /// Largest relative residual of such a solve.
    filter_residual: max of Ratio,
    /// Steps in which the Newton iteration for volumes and centres of the components did not converge.
    volume_unconverged: count of Count,
    /// Largest remaining volume error of such a step, over the volume of the liquid.
    volume_residual: max of Ratio,
    /// Newton iterations of solids with an indefinite Hessian, which was replaced by its positive part.
    indefinite_iterations: count of Count,
    /// Largest fraction of the liquid's weight that the energy of the dual cells leaves out because the cells are too large.
    weight_left_out: max of Ratio,
    /// Rounds of impacts whose Gauss–Seidel iteration did not converge within the largest number of sweeps.
    contact_sweeps: count of Count,
    /// Steps in which rigid solids still collided after the largest number of rounds.
    contact_rounds: count of Count,
    /// Rounds of impacts without restitution, which would have created energy.
    stopped_bounces: count of Count,
    /// Elements below three tenths of their rest volume, where an additional energy prevents inversion, summed over the steps.
    crushed_elements: count of Count,
    /// Free solids with a singular inertia matrix, which nothing turns, summed over the steps.
    singular_inertia: count of Count,
    /// Groups of components whose momentum was not restored, summed over the steps: they lie between solids, and the masses of
    /// their faces and of their volume differ by more than a factor of two.
    unrestored: count of Count,
    /// Lookups of the component of a liquid cell that has none. The cell then counts as part of the first component.
    unlabelled: count of Count,
    /// Faces within solids for which no solid was found to slip along: their velocity is zero.
    slip_unknown: count of Count,
    /// Steps whose impulse time was clamped because the step length had changed by too much for the leapfrog scheme.
    limited_kicks: count of Count,
    /// Steps accepted despite a doubtful change of volume or energy.
    doubtful_steps: count of Count,
    /// Steps rejected and repeated with half the length. Their other repairs are not counted.
    redone: count of Count,
    /// Those of them rejected because a solve for pressure, viscosity or a solid failed, or the velocity became too large.
    failed_tries: count of Count,
}

impl Repairs {
    /// Number of iterations of all kinds that ended unconverged.
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
