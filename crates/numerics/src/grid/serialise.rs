//! Serialisation of grids and fields, for checkpoints.
//!
//! The values of a field are one run of little-endian bytes, so that each has its bits again and fields are written at the speed of
//! memory. A field whose number of values is not that of its grid is refused.

use super::{CellField, FaceField, Grid};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

#[derive(Serialize, Deserialize)]
struct GridRecord {
    cells: Vec<usize>,
    dx: f64,
    margin_cells: Vec<[usize; 2]>,
}

impl<const D: usize> Serialize for Grid<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (cells, margin_cells) = (self.cells.to_vec(), self.margin_cells.to_vec());
        GridRecord { cells, dx: self.dx, margin_cells }.serialize(serializer)
    }
}

impl<'de, const D: usize> Deserialize<'de> for Grid<D> {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        let GridRecord { cells, dx, margin_cells } = GridRecord::deserialize(deserializer)?;
        match (cells.try_into(), margin_cells.try_into()) {
            (Ok(cells), Ok(margin_cells)) => Ok(Self { cells, dx, margin_cells }),
            _ => Err(T::Error::custom(format_args!("the grid does not have {D} dimensions"))),
        }
    }
}

/// Values as bytes.
struct Packed<'a>(&'a [f64]);

impl Serialize for Packed<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let bytes: Vec<u8> = self.0.iter().flat_map(|value| value.to_le_bytes()).collect();
        serializer.serialize_bytes(&bytes)
    }
}

/// Values read from bytes.
struct Unpacked(Vec<f64>);

impl<'de> Deserialize<'de> for Unpacked {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        struct Bytes;
        impl Visitor<'_> for Bytes {
            type Value = Unpacked;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the bytes of numbers")
            }

            fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Unpacked, E> {
                match bytes.as_chunks::<8>() {
                    (words, []) => Ok(Unpacked(words.iter().map(|word| f64::from_le_bytes(*word)).collect())),
                    _ => Err(E::invalid_length(bytes.len(), &self)),
                }
            }
        }
        deserializer.deserialize_bytes(Bytes)
    }
}

/// An error unless there are `count` values.
fn check<E: Error>(values: &[f64], count: usize) -> Result<(), E> {
    let message = format_args!("a field has {} values where its grid has {count}", values.len());
    if values.len() == count { Ok(()) } else { Err(E::custom(message)) }
}

impl<const D: usize> Serialize for CellField<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.grid, Packed(&self.data)).serialize(serializer)
    }
}

impl<'de, const D: usize> Deserialize<'de> for CellField<D> {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        let (grid, Unpacked(data)) = <(Grid<D>, Unpacked)>::deserialize(deserializer)?;
        check(&data, grid.lattice().len())?;
        Ok(Self { grid, data })
    }
}

impl<const D: usize> Serialize for FaceField<D> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let axes: Vec<_> = self.axes.iter().map(|axis| Packed(axis)).collect();
        (self.grid, axes).serialize(serializer)
    }
}

impl<'de, const D: usize> Deserialize<'de> for FaceField<D> {
    fn deserialize<T: Deserializer<'de>>(deserializer: T) -> Result<Self, T::Error> {
        let (grid, axes) = <(Grid<D>, Vec<Unpacked>)>::deserialize(deserializer)?;
        if axes.len() != D {
            return Err(T::Error::invalid_length(axes.len(), &"a field on the faces of each axis"));
        }
        let mut field = Self::zeros(grid);
        for (a, Unpacked(values)) in axes.into_iter().enumerate() {
            check(&values, grid.face_lattice(a).len())?;
            field.axes[a] = values;
        }
        Ok(field)
    }
}
