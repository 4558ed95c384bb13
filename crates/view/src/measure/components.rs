//! Drops of a frame: connected components of the liquid's surface. Bubbles belong to the drop around them.

use meniscus_numerics::Vector;
use meniscus_numerics::mesh::SurfaceMesh;

/// The surface of one drop.
#[derive(Clone, Debug)]
pub(super) struct Component<const D: usize> {
    /// Its surface, including that of its bubbles.
    pub mesh: SurfaceMesh<D>,
    /// Kind of each vertex: 0 liquid–air, 1 liquid–solid, 2 contact line.
    pub kinds: Vec<u8>,
    /// Enclosed volume, m³ (2D: m²).
    pub volume: f64,
    /// Centre of mass, m.
    pub centroid: Vector<D>,
}

impl<const D: usize> Component<D> {
    /// The drops of a surface, by decreasing volume.
    pub(super) fn all(mesh: &SurfaceMesh<D>, kinds: &[u8]) -> Vec<Self> {
        let mut parts = connected_components(mesh, kinds);
        parts.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        let bubbles = parts.split_off(parts.partition_point(|p| p.volume > 0.0));
        for bubble in bubbles {
            let (low, high) = bubble.mesh.bounds();
            let holds = |drop: &&mut Self| {
                let (l, h) = drop.mesh.bounds();
                (0..D).all(|a| l[a] <= low[a] && high[a] <= h[a])
            };
            // The last match is the smallest drop around it.
            if let Some(drop) = parts.iter_mut().rev().find(holds) {
                drop.absorb(&bubble);
            }
        }
        parts
    }

    fn new(mesh: SurfaceMesh<D>, kinds: Vec<u8>) -> Self {
        let (volume, centroid) = moments(&mesh);
        Self { mesh, kinds, volume, centroid }
    }

    fn absorb(&mut self, bubble: &Self) {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend_from_slice(&bubble.mesh.positions);
        self.mesh.facets.extend(bubble.mesh.facets.iter().map(|f| f.map(|v| v + first)));
        self.kinds.extend_from_slice(&bubble.kinds);
        (self.volume, self.centroid) = moments(&self.mesh);
    }
}

/// The connected components of a surface, in the order of their first vertices.
fn connected_components<const D: usize>(mesh: &SurfaceMesh<D>, kinds: &[u8]) -> Vec<Component<D>> {
    let mut root: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    fn find(root: &mut [u32], mut v: u32) -> u32 {
        while root[v as usize] != v {
            root[v as usize] = root[root[v as usize] as usize];
            v = root[v as usize];
        }
        v
    }
    for facet in &mesh.facets {
        for k in 1..D {
            let (a, b) = (find(&mut root, facet[0]), find(&mut root, facet[k]));
            // The smaller index stays the root, so components keep the order of their first vertices.
            root[a.max(b) as usize] = a.min(b);
        }
    }
    let mut number = vec![u32::MAX; root.len()];
    let mut place = vec![0u32; root.len()];
    let mut out: Vec<(SurfaceMesh<D>, Vec<u8>)> = Vec::new();
    for v in 0..root.len() {
        let r = find(&mut root, v as u32) as usize;
        if number[r] == u32::MAX {
            number[r] = out.len() as u32;
            out.push(Default::default());
        }
        let (part, kind) = &mut out[number[r] as usize];
        place[v] = part.positions.len() as u32;
        part.positions.push(mesh.positions[v]);
        kind.push(kinds.get(v).copied().unwrap_or(0));
    }
    for facet in &mesh.facets {
        let r = find(&mut root, facet[0]) as usize;
        out[number[r] as usize].0.facets.push(facet.map(|v| place[v as usize]));
    }
    let whole = out.into_iter().filter(|(m, _)| !m.facets.is_empty());
    whole.map(|(mesh, kinds)| Component::new(mesh, kinds)).collect()
}

/// Volume (m³, 2D: m²) and centre of mass (m) of the region inside a surface.
fn moments<const D: usize>(mesh: &SurfaceMesh<D>) -> (f64, Vector<D>) {
    let Some(&origin) = mesh.positions.first() else { return (0.0, Vector::zeros()) };
    let (mut volume, mut moment) = (0.0, Vector::<D>::zeros());
    for f in 0..mesh.facets.len() {
        let corners = mesh.corners(f).map(|c| c - origin);
        let part = corners[0].dot(&mesh.area_vector(f)) / D as f64;
        volume += part;
        moment += corners.iter().sum::<Vector<D>>() * (part / (D + 1) as f64);
    }
    let shift = if volume == 0.0 { Vector::zeros() } else { moment / volume };
    (volume, origin + shift)
}
