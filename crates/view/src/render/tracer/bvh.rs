//! A bounding volume hierarchy over bounding boxes of any primitives.

use crate::folder::{Bounds, V3};

/// Largest number of boxes in a leaf that can still be split.
const MAX_LEAF_SIZE: usize = 4;
/// Bins per axis of the surface area heuristic.
const BINS: usize = 12;
/// Depth from which nodes are split at the median, which bounds the depth of the tree.
const MAX_SAH_DEPTH: usize = 40;
/// Capacity of the stack of pending nodes.
const STACK_SIZE: usize = 96;

/// A ray with the reciprocals of its direction's components.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub origin: V3,
    pub dir: V3,
    inverse: [f64; 3],
}

impl Ray {
    pub(crate) fn new(origin: V3, dir: V3) -> Self {
        let inverse = |x: f64| if x.abs() > 1e-300 { 1.0 / x } else { 1e300 };
        Self { origin, dir, inverse: [inverse(dir.x), inverse(dir.y), inverse(dir.z)] }
    }

    pub(crate) fn at(&self, t: f64) -> V3 {
        self.origin + self.dir * t
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    lower: [f64; 3],
    upper: [f64; 3],
    /// Leaf: index of its first box in `order`. Inner node: its second child (the first one follows the node).
    first: u32,
    /// Number of boxes in a leaf; 0 for an inner node.
    count: u32,
}

/// The hierarchy. Primitives are identified by the index of their box.
#[derive(Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

struct Builder<'a> {
    boxes: &'a [Bounds],
    centers: Vec<[f64; 3]>,
    nodes: Vec<Node>,
}

impl Bvh {
    /// Builds the hierarchy over `boxes`.
    pub(crate) fn new(boxes: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let centers = boxes.iter().map(|b| b.center().into()).collect();
        let mut builder = Builder { boxes, centers, nodes: Vec::with_capacity(boxes.len()) };
        if !boxes.is_empty() {
            builder.build(&mut order, 0, 0);
        }
        Self { nodes: builder.nodes, order }
    }

    /// The primitives in the order of the leaves.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }

    /// Visits the primitives whose boxes the ray enters before `limit`, near boxes first. `hit` receives the index in
    /// [`Self::order`] and the current limit, and returns the new limit; a negative one ends the traversal.
    pub(crate) fn visit(&self, ray: &Ray, mut limit: f64, mut hit: impl FnMut(usize, f64) -> f64) {
        let mut stack = [(0u32, 0.0f64); STACK_SIZE];
        let mut top = 0;
        let Some(root) = self.nodes.first() else { return };
        let Some(t) = root.enter(ray, limit) else { return };
        stack[0] = (0, t);
        top += 1;
        while top > 0 {
            top -= 1;
            let (mut at, entered) = stack[top];
            if entered > limit {
                continue;
            }
            loop {
                let node = &self.nodes[at as usize];
                if node.count > 0 {
                    for place in node.first..node.first + node.count {
                        limit = hit(place as usize, limit);
                        if limit < 0.0 {
                            return;
                        }
                    }
                    break;
                }
                let (a, b) = (at + 1, node.first);
                let ta = self.nodes[a as usize].enter(ray, limit);
                let tb = self.nodes[b as usize].enter(ray, limit);
                match (ta, tb) {
                    (Some(ta), Some(tb)) => {
                        let (near, far) = if ta <= tb { (a, (b, tb)) } else { (b, (a, ta)) };
                        stack[top] = far;
                        top += 1;
                        at = near;
                    }
                    (Some(_), None) => at = a,
                    (None, Some(_)) => at = b,
                    (None, None) => break,
                }
            }
        }
    }
}

impl Node {
    /// Distance at which the ray enters the box, if before `limit`.
    fn enter(&self, ray: &Ray, limit: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0f64, limit);
        for a in 0..3 {
            let t0 = (self.lower[a] - ray.origin[a]) * ray.inverse[a];
            let t1 = (self.upper[a] - ray.origin[a]) * ray.inverse[a];
            near = near.max(t0.min(t1));
            far = far.min(t0.max(t1));
        }
        (near <= far * (1.0 + 1e-12)).then_some(near)
    }
}

impl Builder<'_> {
    /// Builds the node over the boxes in `order`, a slice that starts at `offset` of the whole.
    fn build(&mut self, order: &mut [u32], offset: usize, depth: usize) {
        let mut all = Bounds::EMPTY;
        order.iter().for_each(|&i| all.join(&self.boxes[i as usize]));
        let at = self.nodes.len();
        self.nodes.push(Node {
            lower: all.lower.into(),
            upper: all.upper.into(),
            first: offset as u32,
            count: order.len() as u32,
        });
        if order.len() <= MAX_LEAF_SIZE {
            return;
        }
        let middle = if depth < MAX_SAH_DEPTH { self.split(order) } else { None };
        let middle = middle.unwrap_or_else(|| self.median(order));
        let (a, b) = order.split_at_mut(middle);
        self.build(a, offset, depth + 1);
        let second = self.nodes.len() as u32;
        self.build(b, offset + middle, depth + 1);
        self.nodes[at].first = second;
        self.nodes[at].count = 0;
    }

    fn centers(&self, order: &[u32]) -> Bounds {
        let mut b = Bounds::EMPTY;
        order.iter().for_each(|&i| b.add(self.centers[i as usize].into()));
        b
    }

    /// Splits at the median along the longest axis.
    fn median(&self, order: &mut [u32]) -> usize {
        let axis = self.centers(order).size().imax();
        let key = |i: &u32| self.centers[*i as usize][axis];
        order.sort_by(|i, j| key(i).total_cmp(&key(j)).then(i.cmp(j)));
        order.len() / 2
    }

    /// Splits at the minimum of the surface area heuristic; `None` if no split leaves boxes on both sides.
    fn split(&self, order: &mut [u32]) -> Option<usize> {
        let centers = self.centers(order);
        let axis = centers.size().imax();
        let (from, width) = (centers.lower[axis], centers.size()[axis]);
        if width <= 0.0 {
            return None;
        }
        let bin = |i: u32| {
            let x = (self.centers[i as usize][axis] - from) / width * BINS as f64;
            (x as usize).min(BINS - 1)
        };
        let mut bins = [(Bounds::EMPTY, 0usize); BINS];
        for &i in order.iter() {
            let b = &mut bins[bin(i)];
            b.0.join(&self.boxes[i as usize]);
            b.1 += 1;
        }
        let mut best = (f64::INFINITY, 0);
        for cut in 1..BINS {
            let (left, right) = (gather(&bins[..cut]), gather(&bins[cut..]));
            let cost = left.1 as f64 * area(&left.0) + right.1 as f64 * area(&right.0);
            if left.1 > 0 && right.1 > 0 && cost < best.0 {
                best = (cost, cut);
            }
        }
        if best.1 == 0 {
            return None;
        }
        order.sort_by_key(|&i| (bin(i) >= best.1, i));
        Some(order.partition_point(|&i| bin(i) < best.1))
    }
}

fn gather(bins: &[(Bounds, usize)]) -> (Bounds, usize) {
    bins.iter().fold((Bounds::EMPTY, 0), |(mut all, n), (b, count)| {
        all.join(b);
        (all, n + count)
    })
}

fn area(b: &Bounds) -> f64 {
    let s = b.size();
    s.x * s.y + s.y * s.z + s.z * s.x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::tracer::sampling::hash;

    fn random(seed: u32) -> f64 {
        f64::from(hash(seed)) / f64::from(u32::MAX)
    }

    #[test]
    fn finds_what_brute_force_finds() {
        let point = |i: u32| V3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2));
        let boxes: Vec<Bounds> = (0..2000)
            .map(|i| {
                let mut b = Bounds::EMPTY;
                b.add(point(i));
                b.add(point(i) + (point(i + 7000) - V3::repeat(0.5)) * 0.05);
                b
            })
            .collect();
        let bvh = Bvh::new(&boxes);
        let enter = |b: &Bounds, ray: &Ray| {
            let node = Node { lower: b.lower.into(), upper: b.upper.into(), first: 0, count: 1 };
            node.enter(ray, f64::INFINITY)
        };
        let mut hits = 0;
        for k in 0..3000u32 {
            let origin = point(k + 20_000) * 3.0 - V3::repeat(1.0);
            let ray = Ray::new(origin, (point(k + 40_000) - origin).normalize());
            let brute = boxes.iter().filter_map(|b| enter(b, &ray)).fold(f64::INFINITY, f64::min);
            let mut found = f64::INFINITY;
            bvh.visit(&ray, f64::INFINITY, |place, limit| {
                let t = enter(&boxes[bvh.order()[place] as usize], &ray);
                found = found.min(t.unwrap_or(f64::INFINITY));
                limit.min(found)
            });
            assert_eq!(brute, found);
            hits += usize::from(brute.is_finite());
        }
        assert!(hits > 1000, "{hits}");
    }

    #[test]
    fn equal_boxes_and_none_at_all() {
        let mut b = Bounds::EMPTY;
        b.add(V3::zeros());
        b.add(V3::repeat(1.0));
        let bvh = Bvh::new(&vec![b; 100]);
        let mut seen = 0;
        bvh.visit(&Ray::new(V3::new(0.5, 0.5, -1.0), V3::z()), f64::INFINITY, |_, limit| {
            seen += 1;
            limit
        });
        assert_eq!(seen, 100);
        Bvh::new(&[]).visit(&Ray::new(V3::zeros(), V3::z()), 1.0, |_, _| panic!("nothing to visit"));
    }
}
