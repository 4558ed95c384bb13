//! The tree of an OpenVDB grid: a root, nodes of 32³ nodes, nodes of 16³ leaves, leaves of 8³ voxels.
//!
//! Source: Museth, "VDB: High-resolution sparse volumes with dynamic topology", ACM Transactions on Graphics 32, 3 (2013); the format of
//! files is that of OpenVDB 10 (`openvdb/io/Compression.h`, `openvdb/tree`). A node has a bit for each place, the last axis fastest. An
//! inactive place has the background as its value, or its negative within a level set; a mask tells them apart, so only active values
//! are stored, compressed with zlib where that makes them smaller.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use meniscus_numerics::par;
use std::collections::BTreeMap;
use std::io::Write;

/// Binary logarithms of the edges of leaf, lower node and upper node.
const LEAF: u32 = 3;
const LOWER: u32 = 4;
const UPPER: u32 = 5;

/// How inactive values are stored: all are the background; all its negative; a mask has a bit where they are the background.
const BACKGROUND: u8 = 0;
const NEGATIVE: u8 = 1;
const MASK: u8 = 3;

/// Coordinates of a voxel, or of the first voxel of a node.
type Coordinates = [i32; 3];

/// A type of values.
pub(super) trait Stored: Copy + Send + Sync {
    /// Its name in the type of a tree.
    const NAME: &'static str;

    /// Appends the bytes.
    fn put(self, out: &mut Vec<u8>);
}

impl Stored for f32 {
    const NAME: &'static str = "float";

    fn put(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.to_le_bytes());
    }
}

impl Stored for [f32; 3] {
    const NAME: &'static str = "vec3s";

    fn put(self, out: &mut Vec<u8>) {
        self.into_iter().for_each(|x| x.put(out));
    }
}

/// A voxel of a grid.
pub(super) enum Voxel<T> {
    /// An active one with its value.
    Active(T),
    /// An inactive one with the background.
    Outside,
    /// An inactive one with the negative of the background.
    Inside,
}

/// One bit for each place of a node.
#[derive(Clone)]
struct Mask(Vec<u64>);

impl Mask {
    fn new(log: u32) -> Self {
        Self(vec![0; (1usize << (3 * log)) / 64])
    }

    fn set(&mut self, place: usize) {
        self.0[place / 64] |= 1 << (place % 64);
    }

    fn put(&self, out: &mut Vec<u8>) {
        self.0.iter().for_each(|word| out.extend_from_slice(&word.to_le_bytes()));
    }

    fn is_empty(&self) -> bool {
        self.0.iter().all(|word| *word == 0)
    }

    /// The places that have no bit in any of two masks.
    fn neither(&self, other: &Self) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(a, b)| !(a | b)).collect())
    }
}

/// A leaf: which voxels are active, and its values as they are stored.
struct Leaf {
    active: Mask,
    values: Vec<u8>,
}

/// A node of leaves.
struct Lower {
    leaves: BTreeMap<usize, Leaf>,
    /// Places within a level set that have no leaf.
    inside: Mask,
}

/// A grid's values.
pub(super) struct Tree<T> {
    background: T,
    /// Upper nodes by their first voxel, each with its lower nodes by their place.
    uppers: BTreeMap<Coordinates, BTreeMap<usize, Lower>>,
}

impl<T: Stored> Tree<T> {
    /// The voxels from `lower` on, below `upper`, all others inactive.
    pub fn new(
        [lower, upper]: [Coordinates; 2],
        background: T,
        voxel: impl Fn(Coordinates) -> Voxel<T> + Sync,
    ) -> Self {
        let first = lower.map(|x| x.div_euclid(1 << LEAF));
        let counts: [usize; 3] =
            std::array::from_fn(|a| ((upper[a] - 1).div_euclid(1 << LEAF) - first[a] + 1).max(0) as usize);
        let is_within = |at: Coordinates| (0..3).all(|a| at[a] >= lower[a] && at[a] < upper[a]);
        let voxel = |at: Coordinates| if is_within(at) { voxel(at) } else { Voxel::Outside };
        let blocks = par::filter_map(counts.iter().product(), 1, |n| {
            let place = [n / (counts[1] * counts[2]), n / counts[2] % counts[1], n % counts[2]];
            let origin: Coordinates = std::array::from_fn(|a| (first[a] + place[a] as i32) << LEAF);
            Some((origin, block(origin, &voxel)?))
        });
        let mut uppers = BTreeMap::new();
        for (origin, block) in blocks {
            let (upper, lower, place) = path(origin);
            let lowers: &mut BTreeMap<usize, Lower> = uppers.entry(upper).or_default();
            let node = lowers.entry(lower);
            let node = node.or_insert_with(|| Lower { leaves: BTreeMap::new(), inside: Mask::new(LOWER) });
            match block {
                Block::Leaf(leaf) => drop(node.leaves.insert(place, leaf)),
                Block::Inside => node.inside.set(place),
            }
        }
        Self { background, uppers }
    }

    /// Appends the nodes, with masks but without the leaves' values.
    pub fn put_topology(&self, out: &mut Vec<u8>) {
        // One buffer; no tile at the root.
        out.extend_from_slice(&1u32.to_le_bytes());
        self.background.put(out);
        for count in [0, self.uppers.len() as u32] {
            out.extend_from_slice(&count.to_le_bytes());
        }
        for (origin, lowers) in &self.uppers {
            origin.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
            put_node(out, UPPER, &mut lowers.keys(), &Mask::new(UPPER));
            for node in lowers.values() {
                put_node(out, LOWER, &mut node.leaves.keys(), &node.inside);
                node.leaves.values().for_each(|leaf| leaf.active.put(out));
            }
        }
    }

    /// Appends the leaves' values.
    pub fn put_values(&self, out: &mut Vec<u8>) {
        for leaf in self.uppers.values().flat_map(BTreeMap::values).flat_map(|node| node.leaves.values()) {
            leaf.active.put(out);
            out.extend_from_slice(&leaf.values);
        }
    }
}

/// What stands at the place of a leaf, if it is not the background.
enum Block {
    Leaf(Leaf),
    Inside,
}

/// The block at an origin.
fn block<T: Stored>(origin: Coordinates, voxel: &impl Fn(Coordinates) -> Voxel<T>) -> Option<Block> {
    let (mut active, mut inside, mut bytes) = (Mask::new(LEAF), Mask::new(LEAF), Vec::new());
    for place in 0..1usize << (3 * LEAF) {
        let at = [place >> 6, place >> 3 & 7, place & 7];
        match voxel(std::array::from_fn(|a| origin[a] + at[a] as i32)) {
            Voxel::Active(value) => {
                active.set(place);
                value.put(&mut bytes);
            }
            Voxel::Inside => inside.set(place),
            Voxel::Outside => {}
        }
    }
    let outside = active.neither(&inside);
    if active.is_empty() && (inside.is_empty() || outside.is_empty()) {
        return if inside.is_empty() { None } else { Some(Block::Inside) };
    }
    let mut values = Vec::new();
    put_inactive(&mut values, &inside, &outside);
    put_compressed(&mut values, &bytes);
    Some(Block::Leaf(Leaf { active, values }))
}

/// The first voxel of the upper node of a leaf, the place of the lower node in it, and that of the leaf in the lower node.
fn path(origin: Coordinates) -> (Coordinates, usize, usize) {
    let (lower, upper) = (LEAF + LOWER, LEAF + LOWER + UPPER);
    let place = |shift: u32, log: u32| {
        let along = |x: i32| ((x >> shift) & ((1 << log) - 1)) as usize;
        let [x, y, z] = origin.map(along);
        x << (2 * log) | y << log | z
    };
    (origin.map(|x| x >> upper << upper), place(lower, UPPER), place(LEAF, LOWER))
}

/// Appends a node without active values: its children's mask, that of values, and which places are inside.
fn put_node(out: &mut Vec<u8>, log: u32, children: &mut dyn Iterator<Item = &usize>, inside: &Mask) {
    let mut mask = Mask::new(log);
    children.for_each(|place| mask.set(*place));
    mask.put(out);
    Mask::new(log).put(out);
    put_inactive(out, inside, &mask.neither(inside));
    put_compressed(out, &[]);
}

/// Appends which inactive places have the background, and which its negative.
fn put_inactive(out: &mut Vec<u8>, inside: &Mask, outside: &Mask) {
    match (inside.is_empty(), outside.is_empty()) {
        (true, _) => out.push(BACKGROUND),
        (false, true) => out.push(NEGATIVE),
        (false, false) => {
            out.push(MASK);
            outside.put(out);
        }
    }
}

/// Appends bytes behind their number: that of the compressed ones, or the negative one if they are stored as they are.
fn put_compressed(out: &mut Vec<u8>, bytes: &[u8]) {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    // Writing to memory does not fail; if it did, the bytes would be stored as they are.
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    match packed.ok().filter(|packed| packed.len() < bytes.len()) {
        Some(packed) => {
            out.extend_from_slice(&(packed.len() as i64).to_le_bytes());
            out.extend_from_slice(&packed);
        }
        None => {
            out.extend_from_slice(&(-(bytes.len() as i64)).to_le_bytes());
            out.extend_from_slice(bytes);
        }
    }
}
