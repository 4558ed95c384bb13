//! Edges of a mesh joined to polylines.

/// Polylines, as vertex numbers, that contain every edge once; the last vertex of a closed one is its first. They follow the direction
/// of the edges where it is consistent, and end where other than two edges meet. Edges from a vertex to itself are left out.
///
/// The order follows from that of the edges alone.
pub fn polylines(vertices: usize, edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut chains = Chains::new(vertices, edges);
    let is_end = |chains: &Chains, vertex: u32| chains.edges_at(vertex).len() != 2;
    let mut all = Vec::new();
    // Open lines from their starts, then those against the direction of their edges, then closed ones.
    for side in [Some(0), Some(1), None] {
        for edge in 0..edges.len() {
            let from = edges[edge][side.unwrap_or(0)];
            if !chains.used[edge] && (side.is_none() || is_end(&chains, from)) {
                all.push(chains.follow(edge, from));
            }
        }
    }
    all
}

/// Edges around each vertex, and which of them are in a polyline.
struct Chains<'a> {
    edges: &'a [[u32; 2]],
    /// Place in `around` of the first edge of each vertex, and the number of all.
    first: Vec<usize>,
    around: Vec<usize>,
    used: Vec<bool>,
}

impl<'a> Chains<'a> {
    fn new(vertices: usize, edges: &'a [[u32; 2]]) -> Self {
        let used: Vec<bool> = edges.iter().map(|[a, b]| a == b).collect();
        let proper = || edges.iter().enumerate().filter(|(e, _)| !used[*e]);
        let mut first = vec![0; vertices + 1];
        proper().flat_map(|(_, edge)| edge).for_each(|v| first[*v as usize + 1] += 1);
        (0..vertices).for_each(|v| first[v + 1] += first[v]);
        let (mut next, mut around) = (first.clone(), vec![0; first[vertices]]);
        for (e, edge) in proper() {
            for v in edge {
                around[next[*v as usize]] = e;
                next[*v as usize] += 1;
            }
        }
        Self { edges, first, around, used }
    }

    fn edges_at(&self, vertex: u32) -> &[usize] {
        &self.around[self.first[vertex as usize]..self.first[vertex as usize + 1]]
    }

    /// The polyline from a vertex along an edge. It ends after at most as many vertices as there are edges.
    fn follow(&mut self, edge: usize, from: u32) -> Vec<u32> {
        let (mut line, mut at, mut next) = (vec![from], from, Some(edge));
        while let Some(edge) = next {
            self.used[edge] = true;
            let [a, b] = self.edges[edge];
            at = if a == at { b } else { a };
            line.push(at);
            let around = self.edges_at(at);
            next = around.iter().copied().find(|e| !self.used[*e]).filter(|_| around.len() == 2);
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_become_lines_loops_and_branches() {
        let lines = |edges: &[[u32; 2]]| polylines(8, edges);
        assert_eq!(lines(&[[1, 2], [0, 1], [2, 3]]), [vec![0, 1, 2, 3]]);
        assert_eq!(lines(&[[1, 2], [2, 0], [0, 1]]), [vec![1, 2, 0, 1]]);
        assert_eq!(lines(&[[1, 0], [1, 2]]), [vec![0, 1, 2]]);
        // Three edges meet at 1; 5 is a degenerate edge, 6 and 7 form a loop of two.
        let all = lines(&[[0, 1], [1, 2], [1, 3], [5, 5], [6, 7], [7, 6]]);
        assert_eq!(all, [vec![0, 1], vec![1, 2], vec![1, 3], vec![6, 7, 6]]);
        assert!(lines(&[]).is_empty());
    }
}
