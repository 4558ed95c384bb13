//! The page of a run that a server shows: the same bundle, whose meshes are asked for one at a time, while the run may go on.

use super::{PageFrame, Payload, bundle_with, packed_mesh, series_note};
use crate::color_map::{LargestValues, ScalarRange, ScalarRanges};
use crate::error::{Result, ViewError};
use crate::folder::RunFolder;
use crate::page::time_series::TimeSeries;
use meniscus_numerics::mesh::ply::PlyMesh;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The page that asks its server for everything.
pub fn live_page() -> String {
    bundle_with("{\"live\":true}", "view").unwrap_or_default()
}

/// A run of which frames may still come.
#[derive(Clone, Debug)]
pub struct LiveRun {
    dir: PathBuf,
    /// First words of the addresses of its meshes.
    address: String,
    largest: LargestValues,
}

impl LiveRun {
    /// The run in the output folder `dir`, whose meshes have addresses that begin with `address`; nothing is read.
    pub fn new(dir: &Path, address: &str) -> Self {
        Self { dir: dir.into(), address: address.into(), largest: LargestValues::default() }
    }

    /// The data of the page at this moment.
    ///
    /// # Errors
    /// A file that cannot be read; a folder without frames.
    pub fn data(&mut self) -> Result<Value> {
        let folder = RunFolder::open(&self.dir)?;
        self.largest.update(&folder)?;
        let ranges = self.largest.ranges();
        let series = TimeSeries::load_for_plots(&self.dir.join("timeseries.csv"))?;
        let notes = series_note(&series).into_iter().collect();
        let scene = std::fs::read_to_string(self.dir.join("scene.toml")).unwrap_or_default();
        let frames = folder.frame_numbers.iter().map(|n| self.frame(&folder, *n, &ranges));
        let frames = frames.collect::<Result<_>>()?;
        let payload = Payload { notes, frames, ..Payload::without_frames(&folder, &ranges, series, scene) };
        let mut data =
            serde_json::to_value(payload).map_err(|e| ViewError::content(&self.dir, e.to_string()))?;
        data["folder"] = self.dir.display().to_string().into();
        Ok(data)
    }

    /// A frame with the addresses of its meshes. The ranges of values are part of an address, so that what a browser keeps stays valid.
    fn frame(&self, folder: &RunFolder, number: u32, ranges: &ScalarRanges) -> Result<PageFrame<String>> {
        let range = |r: &Option<ScalarRange>| r.map_or_else(String::new, |r| format!("{}:{}", r.low, r.high));
        let ranges = ranges.iter().map(range).collect::<Vec<_>>().join(",");
        let address = |part: &str| format!("{}/{number}/{part}?{ranges}", self.address);
        let solids =
            folder.solids.iter().filter(|name| folder.mesh_path(&format!("solid_{name}"), number).is_file());
        let line = folder.mesh_path("contact_line", number).is_file();
        Ok(PageFrame {
            number,
            time: folder.time(number)?,
            liquid: address("liquid"),
            line: line.then(|| address("contact_line")),
            solids: solids.map(|name| (name.clone(), address(&format!("solid_{name}")))).collect(),
        })
    }

    /// The packed mesh of an address without its first words: `NUMBER/PART?RANGES`. None if there is no such mesh.
    pub fn packed_mesh(&self, address: &str) -> Option<String> {
        let (path, ranges) = address.split_once('?')?;
        let mesh = self.mesh(path)?;
        let range = |text: &str| {
            let (low, high) = text.split_once(':')?;
            Some(ScalarRange { low: low.parse().ok()?, high: high.parse().ok()? })
        };
        let mut read: ScalarRanges = [None; 4];
        read.iter_mut().zip(ranges.split(',')).for_each(|(to, text)| *to = range(text));
        Some(packed_mesh::pack(&mesh, &read))
    }

    /// Positions and values of the contact line of a frame, such as `12/contact_line`, with the names of solids.
    pub fn line_points(&self, path: &str) -> Option<Value> {
        let folder = RunFolder::open(&self.dir).ok()?;
        let line = self.mesh(path)?;
        let values: BTreeMap<&String, &Vec<f64>> = line.scalars.iter().collect();
        Some(json!({ "positions": line.positions, "values": values, "solids": folder.solid_order() }))
    }

    /// The mesh `NUMBER/PART`, if the run has this part.
    fn mesh(&self, path: &str) -> Option<PlyMesh> {
        let (number, part) = path.split_once('/')?;
        let folder = RunFolder::open(&self.dir).ok()?;
        let is_solid =
            part.strip_prefix("solid_").is_some_and(|name| folder.solids.iter().any(|s| s == name));
        (is_solid || ["liquid", "contact_line"].contains(&part)).then_some(())?;
        folder.mesh(part, number.parse().ok()?).ok()
    }
}
