//! Colours of solids by vertex values, normalised to their range over a run.

use meniscus_numerics::mesh::ply::PlyMesh;
use serde::Serialize;

use crate::error::Result;
use crate::folder::{RunFolder, V3};

/// Number of frames sampled for a range.
const SAMPLED_FRAMES: usize = 24;
/// Sequential colour map at equal steps (viridis, S. van der Walt and N. Smith 2015).
const SEQUENTIAL_COLORMAP: [u32; 5] = [0x0044_0154, 0x003b_528b, 0x0021_918c, 0x005e_c962, 0x00fd_e725];
/// Diverging colour map: wetted (negative), contact line (zero), dry (positive).
const DIVERGING_COLORMAP: [u32; 5] = [0x0021_66ac, 0x0092_c5de, 0x00f7_f7f7, 0x00f4_a582, 0x00b2_182b];

/// Quantity that colours solids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColorBy {
    /// One colour per solid; wetting patterns are shaded by contact angle.
    #[default]
    Plain,
    /// Signed distance to the contact line along the surface, m: blue where it is wetted, red where it is dry.
    PhiC,
    /// Largest principal strain of deformable solids.
    Strain,
    /// Displacement of deformable solids from rest, m.
    Displacement,
    /// Young's contact angle of solids with a pattern, degrees: blue where the liquid wets, red where it does not.
    Young,
}

/// Range of values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ScalarRange {
    pub low: f64,
    pub high: f64,
}

impl ColorBy {
    /// The quantities stored at vertices.
    pub(crate) const STORED: [Self; 4] = [Self::PhiC, Self::Strain, Self::Displacement, Self::Young];

    /// Its name: `plain`, `phi_c`, `strain`, `displacement`, `young`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::PhiC => "phi_c",
            Self::Strain => "strain",
            Self::Displacement => "displacement",
            Self::Young => "young",
        }
    }

    /// The quantity of a name.
    pub fn named(name: &str) -> Option<Self> {
        std::iter::once(Self::Plain).chain(Self::STORED).find(|s| s.name() == name)
    }

    /// Unit of the values.
    pub(crate) fn unit(self) -> Option<char> {
        match self {
            Self::Plain | Self::Strain => None,
            Self::PhiC | Self::Displacement => Some('m'),
            Self::Young => Some('°'),
        }
    }

    /// The stored values at a mesh's vertices; not finite where there is no contact line.
    pub(crate) fn values(self, mesh: &PlyMesh) -> Option<Vec<f64>> {
        let column = |name: &str| mesh.scalars.get(name).filter(|v| v.len() == mesh.positions.len());
        match self {
            Self::Plain => None,
            Self::PhiC | Self::Strain | Self::Young => column(self.name()).cloned(),
            Self::Displacement => {
                let [x, y, z] = ["ux", "uy", "uz"].map(column);
                Some((x?.iter().zip(y?).zip(z?)).map(|((x, y), z)| V3::new(*x, *y, *z).norm()).collect())
            }
        }
    }

    /// The colour at a normalised value, 0 to 1; linear light.
    pub(crate) fn color(self, place: f64) -> V3 {
        let diverges = matches!(self, Self::PhiC | Self::Young);
        let stops = if diverges { DIVERGING_COLORMAP } else { SEQUENTIAL_COLORMAP };
        let at = place.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        let k = (at as usize).min(stops.len() - 2);
        linear_from_srgb(stops[k]).lerp(&linear_from_srgb(stops[k + 1]), at - k as f64)
    }
}

/// A hexadecimal sRGB colour as linear light.
pub(crate) fn linear_from_srgb(hex: u32) -> V3 {
    let part = |shift: u32| {
        let s = f64::from(hex >> shift & 255) / 255.0;
        if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    };
    V3::new(part(16), part(8), part(0))
}

/// Largest absolute value of each of [`ColorBy::STORED`]; `None` where nothing is stored.
type Largest = [Option<f64>; 4];

/// The largest values of the frames of a run, as far as they were read.
#[derive(Clone, Debug, Default)]
pub(crate) struct LargestValues {
    largest: Largest,
    /// Number of the last frame.
    last: Option<u32>,
}

impl LargestValues {
    /// Reads a sample of those frames that came since the last call.
    ///
    /// # Errors
    /// A frame that cannot be read.
    pub fn update(&mut self, folder: &RunFolder) -> Result<()> {
        if folder.frame_numbers.last() < self.last.as_ref() {
            // Another run has begun in the folder.
            *self = Self::default();
        }
        let new: Vec<u32> =
            folder.frame_numbers.iter().copied().filter(|n| self.last.is_none_or(|last| *n > last)).collect();
        for number in RunFolder::evenly_spaced(&new, SAMPLED_FRAMES) {
            let frame = folder.frame(number)?;
            for (largest, shade) in self.largest.iter_mut().zip(ColorBy::STORED) {
                let values = frame.solids.values().filter_map(|mesh| shade.values(mesh)).flatten();
                *largest = values.filter(|v| v.is_finite()).map(f64::abs).chain(*largest).reduce(f64::max);
            }
        }
        self.last = new.last().copied().or(self.last);
        Ok(())
    }

    /// The ranges of [`ColorBy::STORED`].
    pub fn ranges(&self) -> ScalarRanges {
        std::array::from_fn(|k| {
            let high = self.largest[k].filter(|m| *m > 0.0)?;
            Some(match ColorBy::STORED[k] {
                ColorBy::PhiC => ScalarRange { low: -high, high },
                ColorBy::Young => ScalarRange { low: 0.0, high: 180.0 },
                _ => ScalarRange { low: 0.0, high },
            })
        })
    }
}

/// The ranges of [`ColorBy::STORED`]; `None` where nothing is stored.
pub(crate) type ScalarRanges = [Option<ScalarRange>; 4];

/// The ranges of the values over a run.
///
/// # Errors
/// A frame that cannot be read.
pub(crate) fn scalar_ranges(folder: &RunFolder) -> Result<ScalarRanges> {
    let mut largest = LargestValues::default();
    largest.update(folder)?;
    Ok(largest.ranges())
}

impl ScalarRange {
    /// Normalised value, 0 to 1; 0.5 for values that are not finite.
    pub fn normalised(&self, value: f64) -> f64 {
        let place = (value - self.low) / (self.high - self.low);
        if place.is_finite() { place.clamp(0.0, 1.0) } else { 0.5 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_their_places_and_colours() {
        let range = ScalarRange { low: -2.0, high: 2.0 };
        assert_eq!([-3.0, 0.0, 1.0, f64::NAN].map(|v| range.normalised(v)), [0.0, 0.5, 0.75, 0.5]);
        let mut mesh = PlyMesh { positions: vec![[0.0; 3]], ..PlyMesh::default() };
        assert_eq!(ColorBy::Displacement.values(&mesh), None);
        for (name, value) in [("ux", 3.0), ("uy", 0.0), ("uz", 4.0), ("strain", 0.5)] {
            mesh.scalars.insert(name.into(), vec![value]);
        }
        assert_eq!(ColorBy::Displacement.values(&mesh), Some(vec![5.0]));
        assert_eq!(ColorBy::Strain.values(&mesh), Some(vec![0.5]));
        let [wet, dry] = [0.0, 1.0].map(|t| ColorBy::PhiC.color(t));
        assert!(wet.z > wet.x && dry.x > dry.z);
        for shade in ColorBy::STORED {
            assert_eq!(ColorBy::named(shade.name()), Some(shade));
        }
    }
}
