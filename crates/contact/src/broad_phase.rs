//! Broad phase: overlapping pairs of axis-aligned boxes, found with a lattice of bins.

pub use meniscus_numerics::Aabb;

use meniscus_numerics::{Vector, par};

/// Width of the bins over the mean width of the boxes.
const BIN_WIDTH_FACTOR: f64 = 2.0;

/// Overlapping pairs of boxes of two lists, in ascending order.
pub fn overlapping_pairs<const D: usize>(one: &[Aabb<D>], other: &[Aabb<D>]) -> Vec<(u32, u32)> {
    let Some(bins) = Bins::new(other) else { return Vec::new() };
    par::flat_map(one.len(), 16, |k, pairs| {
        let own = &one[k];
        let meets = |o: &u32| {
            let b = &other[*o as usize];
            (0..D).all(|a| b[0][a] <= own[1][a] && own[0][a] <= b[1][a])
        };
        let mut found: Vec<u32> =
            bins.touched_bins(own).flat_map(|bin| bins.boxes_in(bin)).copied().filter(meets).collect();
        found.sort_unstable();
        found.dedup();
        pairs.extend(found.into_iter().map(|o| (k as u32, o)));
    })
}

/// Boxes sorted into the bins of a lattice. If widths are similar, bins have few boxes and boxes touch few bins.
struct Bins<const D: usize> {
    lower: Vector<D>,
    width: Vector<D>,
    count: [usize; D],
    /// Start of the boxes of each bin in `boxes`.
    starts: Vec<u32>,
    boxes: Vec<u32>,
}

impl<const D: usize> Bins<D> {
    /// Bins of these boxes; `None` if there are no boxes.
    fn new(boxes: &[Aabb<D>]) -> Option<Self> {
        let first = *boxes.first()?;
        let [lower, upper] = boxes.iter().fold(first, |all, b| [all[0].inf(&b[0]), all[1].sup(&b[1])]);
        let mean = boxes.iter().map(|b| b[1] - b[0]).sum::<Vector<D>>() / boxes.len() as f64;
        // Limits the number of bins to about 2^D times that of the boxes, however thin these are.
        let most = 2 * (boxes.len() as f64).powf(1.0 / D as f64).ceil() as usize;
        let span = upper - lower;
        let count =
            std::array::from_fn(|a| ((span[a] / (BIN_WIDTH_FACTOR * mean[a])) as usize).clamp(1, most));
        let width = Vector::from_fn(|a, _| span[a] / count[a] as f64);
        let mut bins = Self { lower, width, count, starts: Vec::new(), boxes: Vec::new() };
        bins.fill(boxes);
        Some(bins)
    }

    /// Sorts the boxes into the bins, in order within each bin.
    fn fill(&mut self, boxes: &[Aabb<D>]) {
        let mut starts = vec![0u32; self.count.iter().product::<usize>() + 1];
        for b in boxes {
            self.touched_bins(b).for_each(|bin| starts[bin + 1] += 1);
        }
        for bin in 1..starts.len() {
            starts[bin] += starts[bin - 1];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; starts[starts.len() - 1] as usize];
        for (k, b) in boxes.iter().enumerate() {
            for bin in self.touched_bins(b) {
                sorted[next[bin] as usize] = k as u32;
                next[bin] += 1;
            }
        }
        (self.starts, self.boxes) = (starts, sorted);
    }

    /// Boxes that touch a bin.
    fn boxes_in(&self, bin: usize) -> &[u32] {
        &self.boxes[self.starts[bin] as usize..self.starts[bin + 1] as usize]
    }

    /// Bins that a box touches; the nearest ones for a box outside the lattice.
    fn touched_bins(&self, extent: &Aabb<D>) -> impl Iterator<Item = usize> + use<D> {
        let count = self.count;
        let [from, to] = extent.map(|corner| -> [usize; D] {
            // An axis of width 0 has one bin, whatever the ratio.
            std::array::from_fn(|a| {
                (((corner[a] - self.lower[a]) / self.width[a]) as usize).min(count[a] - 1)
            })
        });
        let many: [usize; D] = std::array::from_fn(|a| to[a].max(from[a]) + 1 - from[a]);
        (0..many.iter().product()).map(move |mut k: usize| {
            let mut bin = 0;
            let mut stride = 1;
            for a in 0..D {
                bin += (from[a] + k % many[a]) * stride;
                stride *= count[a];
                k /= many[a];
            }
            bin
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of very different widths, some of zero width, some far outside.
    fn some(count: usize, seed: f64) -> Vec<Aabb<3>> {
        let part = |k: usize, a: usize| (k as f64 * seed * [1.0, 1.324_718, 1.732_051][a]).fract();
        let of = |k: usize| {
            let far = if k.is_multiple_of(17) { 3.0 } else { 1.0 };
            let wide = [(29, 0.8), (7, 0.0), (1, 0.15)].into_iter().find(|w| k.is_multiple_of(w.0));
            let low = Vector::from_fn(|a, _| far * part(k, a));
            [low, low + Vector::from_fn(|a, _| wide.map_or(0.0, |w| w.1) * part(k + 5, a))]
        };
        (0..count).map(of).collect()
    }

    #[test]
    fn finds_what_a_look_at_all_pairs_finds() {
        let (one, other) = (some(300, 0.618_034), some(500, 0.324_718));
        let mut all = Vec::new();
        for (k, a) in one.iter().enumerate() {
            for (o, b) in other.iter().enumerate() {
                if (0..3).all(|d| a[0][d] <= b[1][d] && b[0][d] <= a[1][d]) {
                    all.push((k as u32, o as u32));
                }
            }
        }
        assert!(all.len() > 100);
        assert_eq!(overlapping_pairs(&one, &other), all);
        let point = [[Vector::<3>::zeros(); 2]];
        assert_eq!(overlapping_pairs(&point, &point), [(0, 0)]);
        assert!(overlapping_pairs::<3>(&one, &[]).is_empty());
    }
}
