//! The result page: a single self-contained HTML file.

mod live;
mod packed_mesh;
pub(crate) mod time_series;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::Write;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

pub use live::{LiveRun, live_page};

use crate::color_map::{self, ColorBy, ScalarRange, ScalarRanges};
use crate::error::{Result, ViewError};
use crate::folder::RunFolder;
use crate::whole_file;
use time_series::TimeSeries;

/// The page without data, built from `web/`.
const BUNDLE: &str = include_str!("../../assets/page.html");
/// Placeholder of the data in the bundle.
const DATA_PLACEHOLDER: &str = "\"MENISCUS_DATA\"";

/// The bundle's title.
const TITLE: &str = "<title>Meniscus</title>";

/// Options of the page.
#[derive(Clone, Debug)]
pub struct PageOptions {
    /// Include only each `every`-th frame.
    pub every: usize,
    /// Largest size of the page, MB; frames are left out until it fits.
    pub max_mb: f64,
    /// Output file; `None` for `page/index.html` in the output folder.
    pub to: Option<PathBuf>,
}

impl Default for PageOptions {
    fn default() -> Self {
        Self { every: 1, max_mb: 20.0, to: None }
    }
}

/// Report on a written page.
#[derive(Clone, Debug)]
pub struct PageReport {
    /// The page.
    pub path: PathBuf,
    /// Its size in bytes.
    pub bytes: u64,
    /// Number of frames in it.
    pub frames: usize,
    /// Stride of its frames in the run.
    pub every: usize,
}

/// One frame as packed meshes.
struct PackedFrame {
    number: u32,
    time: Option<f64>,
    liquid: String,
    line: Option<String>,
    solids: BTreeMap<String, String>,
}

impl PackedFrame {
    fn meshes(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.liquid).chain(&self.line).chain(self.solids.values())
    }
}

/// One frame with the places of its meshes: indices into the list of meshes, or addresses.
#[derive(Serialize)]
struct PageFrame<M> {
    number: u32,
    time: Option<f64>,
    liquid: M,
    line: Option<M>,
    solids: BTreeMap<String, M>,
}

/// A quantity that can colour solids.
#[derive(Serialize)]
struct PageShade {
    name: &'static str,
    unit: Option<char>,
    /// `None` where nothing is stored.
    range: Option<ScalarRange>,
}

/// The data of the page.
#[derive(Serialize)]
struct Payload<'a, M> {
    format: u32,
    name: String,
    version: &'a str,
    dimension: usize,
    domain: Option<[f64; 3]>,
    dx: Option<f64>,
    notes: Vec<String>,
    /// Quantities that can colour solids, in the order of [`ColorBy::STORED`].
    shades: Vec<PageShade>,
    frames: Vec<PageFrame<M>>,
    meshes: Vec<&'a str>,
    series: TimeSeries,
    summary: &'a serde_json::Value,
    scene: String,
}

impl<'a, M> Payload<'a, M> {
    /// The data of a run, with no frames and no notes yet.
    fn without_frames(
        folder: &'a RunFolder,
        ranges: &ScalarRanges,
        series: TimeSeries,
        scene: String,
    ) -> Self {
        Self {
            format: 1,
            name: folder.name(),
            version: env!("CARGO_PKG_VERSION"),
            dimension: folder.dimension,
            domain: folder.domain,
            dx: folder.dx,
            notes: Vec::new(),
            shades: page_shades(ranges),
            frames: Vec::new(),
            meshes: Vec::new(),
            series,
            summary: &folder.summary,
            scene,
        }
    }
}

/// Writes the page of the output folder `dir` and returns its path.
pub fn write_page(dir: &Path, options: &PageOptions) -> Result<PathBuf> {
    make_page(dir, options).map(|report| report.path)
}

/// Writes the page of the output folder `dir` and reports its contents.
pub fn make_page(dir: &Path, options: &PageOptions) -> Result<PageReport> {
    let folder = RunFolder::open(dir)?;
    let asked = options.every.max(1);
    let numbers: Vec<u32> = folder.frame_numbers.iter().copied().step_by(asked).collect();
    let ranges = color_map::scalar_ranges(&folder)?;
    let packed =
        numbers.par_iter().map(|&n| pack(&folder, n, &ranges)).collect::<Result<Vec<PackedFrame>>>()?;
    let series = TimeSeries::load_for_plots(&dir.join("timeseries.csv"))?;
    let scene = std::fs::read_to_string(dir.join("scene.toml")).unwrap_or_default();
    let fixed =
        BUNDLE.len() + scene.len() + series.columns.iter().map(|c| 14 * c.len()).sum::<usize>() + 20_000;
    let budget = ((options.max_mb * 1e6) as usize).saturating_sub(fixed);
    let skip = (1..packed.len()).find(|&k| size(&packed, k) <= budget).unwrap_or(packed.len().max(1));
    let kept: Vec<&PackedFrame> = packed.iter().step_by(skip).collect();
    let (frames, meshes) = deduplicate_meshes(&kept);
    let notes = notes(&folder, options, asked, skip, &series);
    let payload =
        Payload { notes, frames, meshes, ..Payload::without_frames(&folder, &ranges, series, scene) };
    let path = options.to.clone().unwrap_or_else(|| dir.join("page").join("index.html"));
    let html = insert_data(&payload, &path)?;
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).map_err(ViewError::io(parent))?;
    }
    whole_file::write(&path, |file| file.write_all(html.as_bytes()).map_err(ViewError::io(&path)))?;
    Ok(PageReport { path, bytes: html.len() as u64, frames: kept.len(), every: asked * skip })
}

fn page_shades(ranges: &ScalarRanges) -> Vec<PageShade> {
    let shade = |(range, shade): (&Option<ScalarRange>, ColorBy)| PageShade {
        name: shade.name(),
        unit: shade.unit(),
        range: *range,
    };
    ranges.iter().zip(ColorBy::STORED).map(shade).collect()
}

fn pack(folder: &RunFolder, number: u32, ranges: &ScalarRanges) -> Result<PackedFrame> {
    let frame = folder.frame(number)?;
    Ok(PackedFrame {
        number,
        time: frame.time,
        liquid: packed_mesh::pack(&frame.liquid, ranges),
        line: frame.contact_line.as_ref().map(|line| packed_mesh::pack(line, ranges)),
        solids: frame
            .solids
            .iter()
            .map(|(name, mesh)| (name.clone(), packed_mesh::pack(mesh, ranges)))
            .collect(),
    })
}

/// Size of the meshes of each `skip`-th frame, bytes; equal meshes count once.
fn size(packed: &[PackedFrame], skip: usize) -> usize {
    let mut seen = HashSet::new();
    let meshes = packed.iter().step_by(skip).flat_map(PackedFrame::meshes);
    meshes.filter(|m| seen.insert(m.as_str())).map(|m| m.len() + 3).sum()
}

/// Frames as indices into a list of distinct meshes.
fn deduplicate_meshes<'a>(packed: &[&'a PackedFrame]) -> (Vec<PageFrame<usize>>, Vec<&'a str>) {
    let mut meshes: Vec<&str> = Vec::new();
    let mut known: HashMap<&str, usize> = HashMap::new();
    let mut place = |mesh: &'a String| {
        *known.entry(mesh).or_insert_with(|| {
            meshes.push(mesh);
            meshes.len() - 1
        })
    };
    let frames = packed
        .iter()
        .map(|p| PageFrame {
            number: p.number,
            time: p.time,
            liquid: place(&p.liquid),
            line: p.line.as_ref().map(&mut place),
            solids: p.solids.iter().map(|(name, mesh)| (name.clone(), place(mesh))).collect(),
        })
        .collect();
    (frames, meshes)
}

/// Notes on omitted data.
fn notes(
    folder: &RunFolder,
    options: &PageOptions,
    asked: usize,
    skip: usize,
    series: &TimeSeries,
) -> Vec<String> {
    let mut notes = Vec::new();
    let all = folder.frame_numbers.len();
    if asked * skip > 1 {
        let kept = all.div_ceil(asked).div_ceil(skip);
        let why = if skip > 1 { format!(" to stay below {} MB", options.max_mb) } else { String::new() };
        notes.push(format!("{kept} of {all} frames are shown (every {}{why}).", ordinal(asked * skip)));
    }
    notes.extend(series_note(series));
    notes
}

/// A note on rows of the time series that the plots leave out.
fn series_note(series: &TimeSeries) -> Option<String> {
    let note = || format!("The plots show every {} of {} steps.", ordinal(series.stride), series.rows);
    (series.stride > 1).then(note)
}

fn ordinal(n: usize) -> String {
    let end = match (n % 10, n % 100) {
        (1, x) if x != 11 => "st",
        (2, x) if x != 12 => "nd",
        (3, x) if x != 13 => "rd",
        _ => "th",
    };
    format!("{n}{end}")
}

/// The bundle with the data inserted.
fn insert_data<M: Serialize>(payload: &Payload<'_, M>, path: &Path) -> Result<String> {
    let json = serde_json::to_string(payload).map_err(|e| ViewError::content(path, e.to_string()))?;
    bundle_with(&json, &payload.name)
        .ok_or_else(|| ViewError::content(path, "the built-in page has no placeholder for the data"))
}

/// The bundle with a text of JSON as its data.
fn bundle_with(json: &str, name: &str) -> Option<String> {
    let (before, after) = BUNDLE.split_once(DATA_PLACEHOLDER)?;
    // Title of the browser tab before any script runs.
    let name: String = name.chars().filter(|c| !"<>&".contains(*c)).collect();
    let before = before.replacen(TITLE, &format!("<title>{name} – Meniscus</title>"), 1);
    // A `<` could end the script element with the data; in JSON it occurs only in strings.
    Some([&before, &json.replace('<', "\\u003c"), after].concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::mesh::ply::PlyMesh;

    fn folder(name: &str, frames: u32) -> PathBuf {
        let dir = std::env::temp_dir().join(format!("meniscus-page-{name}-{}", std::process::id()));
        std::fs::create_dir_all(dir.join("frames")).unwrap();
        for n in 0..frames {
            let point = |i: u32| [f64::from(i * (n + 7) % 89), f64::from(i * (n + 3) % 97), 0.0];
            let edges = (0..500).map(|i| [i, (i + 1) % 500]).collect();
            let mesh = PlyMesh { positions: (0..500).map(point).collect(), edges, ..PlyMesh::default() };
            mesh.save(&dir.join(format!("frames/liquid_{n:04}.ply"))).unwrap();
            let still = PlyMesh { positions: vec![[0.0; 3]; 2], edges: vec![[0, 1]], ..PlyMesh::default() };
            still.save(&dir.join(format!("frames/solid_plate_{n:04}.ply"))).unwrap();
        }
        std::fs::write(dir.join("scene.toml"), "name = \"</script><b>\"").unwrap();
        std::fs::write(dir.join("timeseries.csv"), "step,time\n0,0\n1,0.5\n").unwrap();
        dir
    }

    fn data(html: &str) -> serde_json::Value {
        let from = html.find("{\"format\":1").unwrap();
        serde_json::Deserializer::from_str(&html[from..]).into_iter().next().unwrap().unwrap()
    }

    #[test]
    fn the_payload_decodes() {
        let dir = folder("decode", 3);
        let path = write_page(&dir, &PageOptions::default()).unwrap();
        let html = std::fs::read_to_string(path).unwrap();
        assert!(!html.contains("</script><b>"));
        assert!(html.contains("meniscus-page-decode-") && !html.contains(TITLE), "tabs have the run's name");
        let data = data(&html);
        assert_eq!(data["dimension"], 2);
        assert_eq!(data["scene"], "name = \"</script><b>\"");
        assert_eq!(data["frames"].as_array().unwrap().len(), 3);
        assert_eq!(data["meshes"].as_array().unwrap().len(), 4, "the solid at rest is there once");
        let place = data["frames"][2]["liquid"].as_u64().unwrap() as usize;
        let mesh = packed_mesh::tests::unpack(data["meshes"][place].as_str().unwrap());
        assert_eq!(mesh.edges.len(), 500);
        assert!((mesh.positions[5][0] - 45.0).abs() < 1e-2);
        std::fs::remove_dir_all(dir).unwrap();
    }

    #[test]
    fn frames_are_left_out_to_fit() {
        let dir = folder("budget", 40);
        let whole = make_page(&dir, &PageOptions::default()).unwrap();
        let max_mb = whole.bytes as f64 * 1e-6 - 0.01;
        let less = make_page(&dir, &PageOptions { max_mb, ..PageOptions::default() }).unwrap();
        assert!(less.bytes as f64 <= max_mb * 1e6 && less.frames < 40 && less.every > 1, "{less:?}");
        let html = std::fs::read_to_string(&less.path).unwrap();
        assert!(data(&html)["notes"][0].as_str().unwrap().contains("of 40 frames"));
        let one = make_page(&dir, &PageOptions { max_mb: 0.0, ..PageOptions::default() }).unwrap();
        assert_eq!(one.frames, 1);
        std::fs::remove_dir_all(dir).unwrap();
    }
}
