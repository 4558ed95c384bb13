//! Groups of mutually coupled vertices.

/// Lists of vertices, one after another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cliques {
    /// End of each list in `vertices`.
    ends: Vec<usize>,
    vertices: Vec<u32>,
}

impl Cliques {
    /// Adds a list.
    pub fn push(&mut self, list: impl IntoIterator<Item = u32>) {
        self.vertices.extend(list);
        self.ends.push(self.vertices.len());
    }

    /// Number of lists.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Range of list `k` among the vertices of all lists.
    pub fn range(&self, k: usize) -> std::ops::Range<usize> {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        start..self.ends[k]
    }

    /// List `k`.
    pub fn get(&self, k: usize) -> &[u32] {
        &self.vertices[self.range(k)]
    }

    /// Iterator over all lists.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.len()).map(|k| self.get(k))
    }
}
