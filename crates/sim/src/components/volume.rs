//! Volume of every connected component of the liquid.
//!
//! Each component has a target volume. When components merge, their targets add up; when one splits, its target is shared in proportion
//! to the volumes of the parts. A constant shift of φ near the component's interface corrects the volume error of the level set in a
//! step. Where the centre of mass leaves its path in a direction in which only the momentum moves it, a translation of φ brings it back.

use crate::components::group::ComponentGroup;
use crate::free_surface::dual_cell::{CornerComponents, DualCell, MIN_CORNER_DISTANCE_CELLS, distribute};
use crate::free_surface::energy::DualGrid;
use crate::model::Model;
use crate::state::Component;
use meniscus_numerics::grid::{Band, CellField, Runs, Sampler};
use meniscus_numerics::{Vector, par};

/// Tolerance of a volume over its target, and of a centre of mass over the size of the domain.
const RELATIVE_TOLERANCE: f64 = 1e-13;
/// Largest number of Newton iterations for volumes and centres.
const MAX_NEWTON_ITERATIONS: usize = 6;

/// Which components became which.
pub struct ComponentMatch<const D: usize> {
    /// The groups that became one another.
    pub groups: Vec<ComponentGroup<D>>,
    /// Old components without a cell in common with a new one; they joined the nearest.
    pub vanished: Vec<usize>,
    /// New components without a cell in common with an old one, where no old one was missing, and the nearest old one, which they join.
    pub appeared: Vec<(usize, usize)>,
}

/// Matches components of `before` and `after` by the cells they share. Unmatched ones join the nearest, except those that have `left`
/// the domain.
pub fn match_components<const D: usize>(
    before: &Runs,
    after: &Runs,
    drops: &[Component<D>],
    centroids: &[Vector<D>],
    dt: f64,
    left: impl Fn(&Component<D>) -> bool,
) -> ComponentMatch<D> {
    let (m, n) = (before.components as usize, after.components as usize);
    let mut links = LinkedComponents { parent: (0..m + n).collect(), old_count: m };
    let overlaps = before.overlaps(after);
    let mut matched = vec![false; m + n];
    for &(a, b, _) in &overlaps {
        links.link(a as usize, m + b as usize);
        (matched[a as usize], matched[m + b as usize]) = (true, true);
    }
    // A small drop may leave its cells in a step, vanish or appear: it joins the nearest component, so that
    // volume and momentum are conserved. New components are first matched with missing ones.
    let (mut vanished, mut appeared) = (Vec::new(), Vec::new());
    let distance = |i: usize, j: usize| (drops[i].centroid + drops[i].velocity * dt - centroids[j]).norm();
    for j in 0..n {
        if matched[m + j] {
            continue;
        }
        let missing =
            (0..m).filter(|i| !matched[*i]).min_by(|a, b| distance(*a, j).total_cmp(&distance(*b, j)));
        let any = (0..m).min_by(|a, b| distance(*a, j).total_cmp(&distance(*b, j)));
        if let Some(i) = missing.or(any) {
            links.link(i, m + j);
            if missing.is_none() {
                appeared.push((j, i));
            }
            matched[i] = true;
        }
    }
    for i in 0..m {
        if matched[i] || left(&drops[i]) {
            continue;
        }
        vanished.push(i);
        if let Some(j) = (0..n).min_by(|a, b| distance(i, *a).total_cmp(&distance(i, *b))) {
            links.link(i, m + j);
        }
    }
    ComponentMatch { groups: links.groups(), vanished, appeared }
}

/// Old components, followed by new ones, of which some are linked: a forest whose trees are the groups.
struct LinkedComponents {
    /// The component above each one in its tree; a root is above itself.
    parent: Vec<usize>,
    /// Number of old components.
    old_count: usize,
}

impl LinkedComponents {
    /// The root of a component's tree.
    fn root(&self, mut i: usize) -> usize {
        while self.parent[i] != i {
            i = self.parent[i];
        }
        i
    }

    /// Makes one group of those of two components.
    fn link(&mut self, i: usize, j: usize) {
        let (a, b) = (self.root(i), self.root(j));
        self.parent[a.max(b)] = a.min(b);
    }

    /// All groups, in the order of their first components.
    fn groups<const D: usize>(&self) -> Vec<ComponentGroup<D>> {
        let (m, count) = (self.old_count, self.parent.len());
        let mut groups: Vec<ComponentGroup<D>> = vec![ComponentGroup::new(Vec::new(), Vec::new()); count];
        for i in 0..count {
            let root = self.root(i);
            if i < m { groups[root].old.push(i) } else { groups[root].new.push(i - m) }
        }
        groups.retain(|g| !g.old.is_empty() || !g.new.is_empty());
        groups
    }
}

/// Target volumes of the new components, and the volume of vanished ones, m³ (2D: m²).
pub fn target_volumes<const D: usize>(
    groups: &[ComponentGroup<D>],
    drops: &[Component<D>],
    volumes: &[f64],
) -> (Vec<f64>, f64) {
    let mut targets = volumes.to_vec();
    let mut lost = 0.0;
    for group in groups {
        let total: f64 = group.old.iter().map(|&i| drops[i].target_volume).sum();
        let measured: f64 = group.new.iter().map(|&j| volumes[j].max(0.0)).sum();
        if group.new.is_empty() {
            lost += total;
        } else if group.old.is_empty() {
            lost -= measured;
        } else {
            let share = |j: usize| {
                if measured > 0.0 { volumes[j].max(0.0) / measured } else { 1.0 / group.new.len() as f64 }
            };
            group.new.iter().for_each(|&j| targets[j] = total * share(j));
        }
    }
    (targets, lost)
}

/// Component of each cell of the band: its own, or that of the nearest liquid.
pub fn band_labels<const D: usize>(
    model: &Model<D>,
    band: &Band<D>,
    phi: &CellField<D>,
    liquid: &Runs,
) -> Vec<u32> {
    let lattice = model.grid.lattice();
    let rows = liquid.row_starts(&model.grid);
    let own = |&cell: &u32| {
        if phi.data[cell as usize] >= 0.0 {
            return u32::MAX;
        }
        let (row, x) = (cell as usize / lattice.extent[0], cell % lattice.extent[0] as u32);
        let runs = &liquid.runs[rows[row]..rows[row + 1]];
        let k = runs.partition_point(|r| r.end <= x);
        runs.get(k).filter(|r| r.start <= x).map_or(u32::MAX, |r| r.component)
    };
    let mut labels = par::map_slice(&band.cells, 1024, own);
    for i in 0..band.cells.len() {
        if labels[i] == u32::MAX {
            let near = |n: usize| band.slot(n).map(|s| labels[s]).filter(|l| *l != u32::MAX);
            labels[i] = lattice.neighbours(band.cells[i] as usize).find_map(near).unwrap_or(u32::MAX);
        }
    }
    labels
}

/// Measured interface: dual cells, volume and centre of each component.
pub struct VolumeMeasurement<const D: usize> {
    /// Keys of the dual cells; they depend on the signs of φ alone.
    keys: Vec<u32>,
    /// Components at their corners, which depend on them alone, too.
    components: Vec<CornerComponents>,
    /// Dual cells that contain the interface.
    pub dual_cells: Vec<DualCell>,
    /// Volume of each component, m³ (2D: m²).
    pub volumes: Vec<f64>,
    /// Centre of mass of each component, m.
    pub centers: Vec<Vector<D>>,
}

/// Displacement of each component that moves its group to its target position, m.
pub fn centroid_corrections<const D: usize>(
    groups: &[ComponentGroup<D>],
    targets: &[f64],
    centers: &[Vector<D>],
) -> Vec<Vector<D>> {
    let mut moves = vec![Vector::zeros(); centers.len()];
    for group in groups {
        let Some(whole) = group.target_motion.as_ref().or(group.advected_motion.as_ref()) else { continue };
        let sum = group.new.iter().fold(Vector::zeros(), |s: Vector<D>, &j| s + centers[j] * targets[j]);
        group
            .new
            .iter()
            .for_each(|&j| moves[j] = group.unconstrained_projector * (whole.center - sum / whole.volume));
    }
    moves
}

/// Measures and corrects the volume of the liquid.
pub struct VolumeCorrection<'a, const D: usize> {
    /// The model.
    pub model: &'a Model<D>,
    /// The dual grid, which measures the volume.
    pub dual_grid: &'a DualGrid<D>,
    /// The cells of the narrow band.
    pub band: &'a Band<D>,
    /// The liquid cells.
    pub cells: &'a Runs,
    /// Component of each cell of the band ([`band_labels`]).
    pub labels: &'a [u32],
}

impl<const D: usize> VolumeCorrection<'_, D> {
    /// Component of a cell; in the band that of the nearest liquid.
    fn component_of(&self) -> impl Fn(usize) -> Option<u32> {
        let deep = self.cells.component_lookup(&self.model.grid);
        move |cell| match self.band.slot(cell) {
            Some(slot) => Some(self.labels[slot]).filter(|l| *l != u32::MAX),
            None => deep(cell),
        }
    }

    /// Measures the volumes within the interface of `phi`.
    pub fn measure(&self, phi: &CellField<D>) -> VolumeMeasurement<D> {
        let keys = self.dual_grid.interface_keys(&phi.data, self.band);
        let (dual_cells, label) = (self.dual_grid.dual_cells(&phi.data, &keys), self.component_of());
        let components = par::map_slice(&dual_cells, 256, |cube| cube.corner_components(&label));
        self.volumes_of(keys, components, dual_cells)
    }

    /// Sums up the volumes within dual cells.
    fn volumes_of(
        &self,
        keys: Vec<u32>,
        components: Vec<CornerComponents>,
        dual_cells: Vec<DualCell>,
    ) -> VolumeMeasurement<D> {
        let sums = self.dual_grid.component_volumes(self.cells, &components, &dual_cells);
        let (volumes, centers) = sums.into_iter().unzip();
        VolumeMeasurement { keys, components, dual_cells, volumes, centers }
    }

    /// Shifts φ within `limit` (m) of each component's interface until volumes and positions match their targets (Newton iteration).
    /// Returns the final measurement and whether it converged.
    pub fn correct(
        &self,
        phi: &mut CellField<D>,
        mut now: VolumeMeasurement<D>,
        targets: &[f64],
        groups: &[ComponentGroup<D>],
        limit: f64,
    ) -> (VolumeMeasurement<D>, bool) {
        let dx = self.model.grid.dx;
        let min_phi = MIN_CORNER_DISTANCE_CELLS * dx;
        let position_tolerance = RELATIVE_TOLERANCE * self.model.grid.domain_upper().norm();
        let slopes = self.phi_gradients(phi, groups);
        let is_converged = |now: &VolumeMeasurement<D>, moves: &[Vector<D>]| {
            let off = |c: usize| (now.volumes[c] - targets[c]).abs() > RELATIVE_TOLERANCE * targets[c].abs();
            !(0..targets.len()).any(|c| off(c) || moves[c].norm() > position_tolerance)
        };
        for _ in 0..MAX_NEWTON_ITERATIONS {
            let moves = centroid_corrections(groups, targets, &now.centers);
            if is_converged(&now, &moves) {
                return (now, true);
            }
            let moves: Vec<Vector<D>> = moves.iter().map(|d| d.cap_magnitude(0.1 * dx)).collect();
            let shifts = self.phi_shifts(&now, targets);
            let row = self.model.grid.cells[0];
            par::for_each_segment(&mut phi.data, row, &self.band.segments, |s, part| {
                for (x, value) in part.iter_mut().enumerate().filter(|(_, value)| value.abs() < limit) {
                    let Some(slot) = self.band.slot(s.row * row + s.start + x) else { continue };
                    let Some(c) = Some(self.labels[slot] as usize).filter(|c| *c < shifts.len()) else {
                        continue;
                    };
                    // Signs are kept: the runs of liquid cells must not change within a step.
                    let shifted = *value + shifts[c] - slopes.get(slot).map_or(0.0, |s| s.dot(&moves[c]));
                    *value = if *value < 0.0 { shifted.min(-min_phi) } else { shifted.max(min_phi) };
                }
            });
            // The memory of the dual cells is used again: new pages are slow.
            self.dual_grid.update_dual_cells(&phi.data, &now.keys, &mut now.dual_cells);
            now = self.volumes_of(now.keys, now.components, now.dual_cells);
        }
        let converged = is_converged(&now, &centroid_corrections(groups, targets, &now.centers));
        (now, converged)
    }

    /// Change of φ that corrects the volume of each component, m.
    fn phi_shifts(&self, now: &VolumeMeasurement<D>, targets: &[f64]) -> Vec<f64> {
        let mut slopes = vec![0.0; targets.len()];
        for (cube, components) in now.dual_cells.iter().zip(&now.components) {
            let slope = cube.volume_slope.iter().sum::<f64>();
            distribute(components, |c, part| slopes[c as usize] += part * slope);
        }
        let grid = &self.model.grid;
        let shift = |c: usize| (now.volumes[c] - targets[c]) / grid.cell_volume() / f64::max(slopes[c], 1.0);
        (0..targets.len()).map(|c| shift(c).clamp(-0.1, 0.1) * grid.dx).collect()
    }

    /// ∇φ on the band; empty if no group has a target position.
    fn phi_gradients(&self, phi: &CellField<D>, groups: &[ComponentGroup<D>]) -> Vec<Vector<D>> {
        if groups.iter().all(|g| g.unconstrained_projector.norm_squared() == 0.0) {
            return Vec::new();
        }
        let grid = &self.model.grid;
        let sampler = Sampler::cells(grid, &phi.data, self.model.scalar_boundary());
        let slope = |&cell: &u32| sampler.gradient(grid.lattice().coordinates(cell as usize));
        par::map_slice(&self.band.cells, 1, slope)
    }
}
