//! An output folder on disk: its frames, their meshes, the size of the domain.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use meniscus_numerics::Vector;
use meniscus_numerics::mesh::ply::PlyMesh;

use crate::error::{Result, ViewError};

/// A point or direction in space.
pub(crate) type V3 = Vector<3>;

/// An output folder of a run.
#[derive(Debug)]
pub struct RunFolder {
    /// The folder.
    pub dir: PathBuf,
    /// Numbers of the frames with a `frames/liquid_NNNN.ply`, ascending.
    pub frame_numbers: Vec<u32>,
    /// `summary.json`, or `null` if there is none.
    pub summary: serde_json::Value,
    /// The names of the solids.
    pub solids: Vec<String>,
    /// 2 or 3.
    pub dimension: usize,
    /// Size of the domain, m, if the summary has it.
    pub domain: Option<[f64; 3]>,
    /// Cell size, m, if the summary has it.
    pub dx: Option<f64>,
    /// Time from one frame to the next, s, if the summary has it.
    pub frame_interval: Option<f64>,
}

/// The meshes of one frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Its number.
    pub number: u32,
    /// Its time, s, if known.
    pub time: Option<f64>,
    /// The surface of the liquid.
    pub liquid: PlyMesh,
    /// The contact line, if there is one.
    pub contact_line: Option<PlyMesh>,
    /// The solids by name.
    pub solids: BTreeMap<String, PlyMesh>,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub lower: V3,
    pub upper: V3,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self {
        lower: V3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        upper: V3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    pub(crate) fn add(&mut self, p: V3) {
        self.lower = self.lower.inf(&p);
        self.upper = self.upper.sup(&p);
    }

    pub(crate) fn join(&mut self, other: &Self) {
        self.lower = self.lower.inf(&other.lower);
        self.upper = self.upper.sup(&other.upper);
    }

    pub(crate) fn of(points: &[[f64; 3]]) -> Self {
        let mut b = Self::EMPTY;
        points.iter().for_each(|&p| b.add(V3::from(p)));
        b
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.lower.x > self.upper.x
    }

    pub(crate) fn size(&self) -> V3 {
        if self.is_empty() { V3::zeros() } else { self.upper - self.lower }
    }

    pub(crate) fn center(&self) -> V3 {
        if self.is_empty() { V3::zeros() } else { (self.lower + self.upper) * 0.5 }
    }
}

impl RunFolder {
    /// Opens the output folder `dir`. It must have at least one frame.
    pub fn open(dir: &Path) -> Result<Self> {
        let frames = dir.join("frames");
        let mut frame_numbers = Vec::new();
        let mut solids = BTreeSet::new();
        for entry in std::fs::read_dir(&frames).map_err(ViewError::io(&frames))? {
            let name = entry.map_err(ViewError::io(&frames))?.file_name();
            let Some(stem) = name.to_str().and_then(|n| n.strip_suffix(".ply")) else { continue };
            let Some((what, number)) = stem.rsplit_once('_') else { continue };
            let Ok(number) = number.parse::<u32>() else { continue };
            if what == "liquid" {
                frame_numbers.push(number);
            } else if let Some(solid) = what.strip_prefix("solid_") {
                solids.insert(solid.to_string());
            }
        }
        frame_numbers.sort_unstable();
        frame_numbers.dedup();
        if frame_numbers.is_empty() {
            return Err(ViewError::content(&frames, "the folder contains no file liquid_NNNN.ply"));
        }
        let mut folder = Self {
            dir: dir.into(),
            frame_numbers,
            summary: read_json(&dir.join("summary.json"))?,
            solids: solids.into_iter().collect(),
            dimension: 3,
            domain: None,
            dx: None,
            frame_interval: None,
        };
        folder.read_summary()?;
        Ok(folder)
    }

    fn read_summary(&mut self) -> Result<()> {
        let number = |key: &str| self.summary.get(key).and_then(serde_json::Value::as_f64);
        let positive = |key: &str| number(key).filter(|x| x.is_finite() && *x > 0.0);
        let dimension = positive("dimension");
        self.dx = positive("dx");
        self.frame_interval = positive("frame_interval");
        if let Some(lengths) = self.summary.get("domain").and_then(|d| d.as_array()) {
            let lengths: Vec<f64> = lengths.iter().filter_map(serde_json::Value::as_f64).collect();
            if (2..=3).contains(&lengths.len()) && lengths.iter().all(|x| x.is_finite() && *x > 0.0) {
                self.domain = Some([lengths[0], lengths[1], lengths.get(2).copied().unwrap_or(0.0)]);
            }
        }
        self.dimension = match dimension {
            Some(d) => d as usize,
            None => {
                let first = PlyMesh::load(&self.mesh_path("liquid", self.frame_numbers[0]))?;
                if first.faces.is_empty() && !first.edges.is_empty() { 2 } else { 3 }
            }
        };
        if self.frame_interval.is_none() {
            let end = positive("simulated_seconds");
            let last = self.frame_numbers.last().copied().filter(|&n| n > 0);
            self.frame_interval = end.zip(last).map(|(end, last)| end / f64::from(last));
        }
        Ok(())
    }

    pub(crate) fn mesh_path(&self, what: &str, number: u32) -> PathBuf {
        self.dir.join("frames").join(format!("{what}_{number:04}.ply"))
    }

    /// Reads a mesh. Its edges are in one order, whether the file has them as an element or as a property of the vertices.
    pub(crate) fn mesh(&self, what: &str, number: u32) -> Result<PlyMesh> {
        let mut mesh = PlyMesh::load(&self.mesh_path(what, number))?;
        mesh.edges.sort_by_key(|[from, _]| *from);
        Ok(mesh)
    }

    fn optional(&self, what: &str, number: u32) -> Result<Option<PlyMesh>> {
        self.mesh_path(what, number).is_file().then(|| self.mesh(what, number)).transpose()
    }

    /// Reads the meshes of one frame.
    pub fn frame(&self, number: u32) -> Result<Frame> {
        let liquid = self.mesh("liquid", number)?;
        let mut solids = BTreeMap::new();
        for name in &self.solids {
            if let Some(mesh) = self.optional(&format!("solid_{name}"), number)? {
                solids.insert(name.clone(), mesh);
            }
        }
        Ok(Frame {
            number,
            time: liquid.time().or(self.frame_interval.map(|dt| dt * f64::from(number))),
            liquid,
            contact_line: self.optional("contact_line", number)?,
            solids,
        })
    }

    /// Time of a frame, s, if known.
    pub(crate) fn time(&self, number: u32) -> Result<Option<f64>> {
        if let Some(interval) = self.frame_interval {
            return Ok(Some(interval * f64::from(number)));
        }
        Ok(PlyMesh::load(&self.mesh_path("liquid", number))?.time())
    }

    /// Names of the solids in scene order, to which the `solid` numbers of contact lines refer; sorted by name if unknown.
    pub fn solid_order(&self) -> Vec<String> {
        let listed = self.summary.get("solids").and_then(|s| s.as_array());
        let name = |s: &serde_json::Value| s.get("name")?.as_str().map(String::from);
        let names: Option<Vec<String>> = listed.map(|list| list.iter().filter_map(name).collect());
        names.filter(|n| n.len() == self.solids.len()).unwrap_or_else(|| self.solids.clone())
    }

    /// The scene's name, or the name of the folder.
    pub(crate) fn name(&self) -> String {
        let given = self.summary.get("scene").and_then(|s| s.as_str()).map(str::to_string);
        let of_dir = || self.dir.canonicalize().ok()?.file_name()?.to_str().map(str::to_string);
        given.or_else(of_dir).unwrap_or_else(|| "run".into())
    }

    /// At most `max_count` of `numbers`, evenly spaced, including the first and the last.
    pub(crate) fn evenly_spaced(numbers: &[u32], max_count: usize) -> Vec<u32> {
        let n = numbers.len();
        if n <= max_count {
            return numbers.to_vec();
        }
        (0..max_count).map(|i| numbers[i * (n - 1) / (max_count - 1).max(1)]).collect()
    }
}

/// Reads a JSON file; `null` if it does not exist.
fn read_json(path: &Path) -> Result<serde_json::Value> {
    if !path.is_file() {
        return Ok(serde_json::Value::Null);
    }
    let text = std::fs::read_to_string(path).map_err(ViewError::io(path))?;
    serde_json::from_str(&text).map_err(|e| ViewError::content(path, e.to_string()))
}
