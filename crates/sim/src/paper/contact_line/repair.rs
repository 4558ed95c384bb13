//! Repair of the line's mesh (Section 4.3.1; T. Brochu and R. Bridson 2009): edges longer than 1.5 times the mean edge are split at their
//! middles, then those shorter than half of it are collapsed to their middles. A loop keeps three points, an open chain two.

use meniscus_numerics::Vector;

/// Shortest and longest edge over the mean one.
pub const EDGE_BOUNDS: [f64; 2] = [0.5, 1.5];

/// No point.
const NONE: u32 = u32::MAX;

/// Points that follow each other in loops or open chains; in 2D single points.
#[derive(Clone, Debug, PartialEq)]
pub struct Chains<const D: usize> {
    /// Positions, m.
    pub positions: Vec<Vector<D>>,
    /// The point after each one, and the one before.
    next: Vec<u32>,
    previous: Vec<u32>,
}

impl<const D: usize> Chains<D> {
    /// Points and the segments between them, each point the start of one segment and the end of one at most.
    pub fn new(positions: Vec<Vector<D>>, segments: &[[u32; 2]]) -> Self {
        let (mut next, mut previous) = (vec![NONE; positions.len()], vec![NONE; positions.len()]);
        for [a, b] in segments {
            (next[*a as usize], previous[*b as usize]) = (*b, *a);
        }
        Self { positions, next, previous }
    }

    /// The segments, in the order of their first points.
    pub fn segments(&self) -> Vec<[u32; 2]> {
        let starts = (0..self.next.len() as u32).filter(|v| self.next[*v as usize] != NONE);
        starts.map(|v| [v, self.next[v as usize]]).collect()
    }

    /// Splits long edges and collapses short ones, by the mean edge before.
    pub fn repair(&mut self) {
        let segments = self.segments();
        if segments.is_empty() {
            return;
        }
        let mean = segments.iter().map(|s| self.length(s[0])).sum::<f64>() / segments.len() as f64;
        self.split(EDGE_BOUNDS[1] * mean);
        let is_gone = self.collapse(EDGE_BOUNDS[0] * mean);
        self.remove(&is_gone);
    }

    /// Length of the edge from a point to the next one, m.
    fn length(&self, v: u32) -> f64 {
        (self.positions[self.next[v as usize] as usize] - self.positions[v as usize]).norm()
    }

    /// Splits edges longer than `longest` (m) until none is left.
    fn split(&mut self, longest: f64) {
        let mut v = 0;
        while v < self.positions.len() {
            // Every split halves the edge, and new points have their own turn.
            while self.next[v] != NONE && self.length(v as u32) > longest {
                let (after, middle) = (self.next[v], self.positions.len() as u32);
                let position = 0.5 * (self.positions[v] + self.positions[after as usize]);
                self.positions.push(position);
                self.next.push(after);
                self.previous.push(v as u32);
                (self.next[v], self.previous[after as usize]) = (middle, middle);
            }
            v += 1;
        }
    }

    /// Collapses edges shorter than `shortest` (m), each onto its first point; tells which points are gone.
    fn collapse(&mut self, shortest: f64) -> Vec<bool> {
        let mut is_gone = vec![false; self.positions.len()];
        for v in 0..self.positions.len() as u32 {
            // Every turn removes a point.
            while !is_gone[v as usize] && self.may_collapse(v) && self.length(v) < shortest {
                let gone = self.next[v as usize] as usize;
                self.positions[v as usize] = 0.5 * (self.positions[v as usize] + self.positions[gone]);
                let after = self.next[gone];
                self.next[v as usize] = after;
                if after != NONE {
                    self.previous[after as usize] = v;
                }
                is_gone[gone] = true;
            }
        }
        is_gone
    }

    /// Whether the edge from a point may go: three points remain of a loop, two of an open chain.
    fn may_collapse(&self, v: u32) -> bool {
        let after = |v: u32| if v == NONE { NONE } else { self.next[v as usize] };
        let before = |v: u32| if v == NONE { NONE } else { self.previous[v as usize] };
        let (first, second, third) = (after(v), after(after(v)), after(after(after(v))));
        if first == NONE {
            return false;
        }
        let is_short_loop = second == v || third == v;
        let is_single_edge = second == NONE && before(v) == NONE;
        !is_short_loop && !is_single_edge
    }

    /// Removes points, which are no longer part of any chain.
    fn remove(&mut self, is_gone: &[bool]) {
        let kept: Vec<usize> = (0..is_gone.len()).filter(|v| !is_gone[*v]).collect();
        let mut number = vec![NONE; is_gone.len()];
        kept.iter().enumerate().for_each(|(new, old)| number[*old] = new as u32);
        let renamed = |v: u32| if v == NONE { NONE } else { number[v as usize] };
        self.positions = kept.iter().map(|v| self.positions[*v]).collect();
        self.next = kept.iter().map(|v| renamed(self.next[*v])).collect();
        self.previous = kept.iter().map(|v| renamed(self.previous[*v])).collect();
    }
}
