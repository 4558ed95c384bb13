//! Impulses between liquid and solids.

use crate::solid::SolidView;
use crate::solid::surface::SurfacePoint;
use meniscus_numerics::{Vector, rotation_planes};
use std::collections::BTreeMap;

/// An impulse and its moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulse<const D: usize> {
    /// Linear impulse, N s (2D: per metre).
    pub linear: Vector<D>,
    /// Moment about the origin, N m s (2D: N s, in the last entry).
    pub angular: Vector<3>,
}

impl<const D: usize> Impulse<D> {
    /// The zero impulse.
    pub fn zero() -> Self {
        Self { linear: Vector::zeros(), angular: Vector::zeros() }
    }

    /// An impulse that acts at the point `x`.
    pub fn at(x: &Vector<D>, linear: Vector<D>) -> Self {
        Self { linear, angular: moment(x, &linear) }
    }

    /// Adds `scale` times another impulse.
    pub fn add(&mut self, other: &Self, scale: f64) {
        self.linear += other.linear * scale;
        self.angular += other.angular * scale;
    }

    /// The moment about a point.
    pub fn moment_about(&self, center: &Vector<D>) -> Vector<3> {
        self.angular - moment(center, &self.linear)
    }
}

/// `r × f` (2D: in the last entry).
pub fn moment<const D: usize>(r: &Vector<D>, f: &Vector<D>) -> Vector<3> {
    let mut sum = Vector::<3>::zeros();
    rotation_planes::<D>().iter().for_each(|&(a, b, place)| sum[place] += r[a] * f[b] - r[b] * f[a]);
    sum
}

/// A component of the liquid and a solid that exchange impulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ComponentSolid {
    /// Number of the component.
    pub component: u32,
    /// Index of the solid.
    pub solid: u32,
}

/// Impulses of the liquid on the solids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CouplingImpulses<const D: usize> {
    /// Impulses of each liquid component on each solid.
    pub pairs: BTreeMap<ComponentSolid, Impulse<D>>,
    /// Impulses at surface points, N s (2D: per metre), by the number of the deformable solid.
    pub point_impulses: BTreeMap<u32, Vec<(SurfacePoint<D>, Vector<D>)>>,
}

impl<const D: usize> CouplingImpulses<D> {
    /// No impulses.
    pub fn new() -> Self {
        Self { pairs: BTreeMap::new(), point_impulses: BTreeMap::new() }
    }

    /// Adds `scale` times an impulse of a component on a solid.
    pub fn add(&mut self, pair: ComponentSolid, impulse: &Impulse<D>, scale: f64) {
        self.pairs.entry(pair).or_insert_with(Impulse::zero).add(impulse, scale);
    }

    /// Adds an impulse at a surface point of a deformable solid.
    pub fn add_at_surface_point(&mut self, pair: ComponentSolid, grip: &SurfacePoint<D>, linear: Vector<D>) {
        self.add(pair, &Impulse::at(&grip.point, linear), 1.0);
        self.point_impulses.entry(pair.solid).or_default().push((*grip, linear));
    }

    /// Adds an impulse at a point of a rigid solid, or at the closest surface point of a deformable one.
    pub fn add_at(
        &mut self,
        pair: ComponentSolid,
        solid: &SolidView<'_, D>,
        x: &Vector<D>,
        linear: Vector<D>,
    ) {
        match solid.surface.closest_point(x) {
            Some(grip) => self.add_at_surface_point(pair, &grip, linear),
            None => self.add(pair, &Impulse::at(x, linear), 1.0),
        }
    }

    /// Adds all impulses of another.
    pub fn extend(&mut self, other: &Self) {
        other.pairs.iter().for_each(|(pair, impulse)| self.add(*pair, impulse, 1.0));
        other
            .point_impulses
            .iter()
            .for_each(|(solid, grips)| self.point_impulses.entry(*solid).or_default().extend(grips));
    }

    /// Sums over all components, by solid.
    pub fn by_solid(&self, solids: usize) -> Vec<Impulse<D>> {
        let mut sums = vec![Impulse::zero(); solids];
        self.pairs.iter().for_each(|(pair, impulse)| sums[pair.solid as usize].add(impulse, 1.0));
        sums
    }

    /// Whether there are no impulses.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }
}
