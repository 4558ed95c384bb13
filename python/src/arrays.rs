//! numpy arrays: read-only, of their own memory, made once.

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Type of the numbers of an array.
#[derive(Clone, Copy)]
pub enum Kind {
    /// Double precision.
    Float,
    /// Vertex numbers.
    Index,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Float => "<f8",
            Self::Index => "<u4",
        }
    }
}

/// Numbers that arrays are made of.
pub trait Plain {
    /// Their bytes.
    const BYTES: usize;
    /// Writes so many bytes, the lowest first.
    fn put(&self, bytes: &mut [u8]);
}

impl Plain for f64 {
    const BYTES: usize = 8;
    fn put(&self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }
}

impl Plain for u32 {
    const BYTES: usize = 4;
    fn put(&self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }
}

impl<T: Plain, const N: usize> Plain for [T; N] {
    const BYTES: usize = N * T::BYTES;
    fn put(&self, bytes: &mut [u8]) {
        self.iter().zip(bytes.chunks_exact_mut(T::BYTES)).for_each(|(value, bytes)| value.put(bytes));
    }
}

/// A read-only array of values; `shape` has their number, the last axis fastest.
pub fn array<'py, T: Plain>(
    py: Python<'py>,
    values: &[T],
    kind: Kind,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    flat(py, values, kind)?.call_method1("reshape", (shape,))
}

/// The same; the first axis is fastest.
pub fn array_first_axis_fastest<'py, T: Plain>(
    py: Python<'py>,
    values: &[T],
    kind: Kind,
    shape: Vec<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let order = PyDict::new(py);
    order.set_item("order", "F")?;
    flat(py, values, kind)?.call_method("reshape", (shape,), Some(&order))
}

fn flat<'py, T: Plain>(py: Python<'py>, values: &[T], kind: Kind) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    if values.is_empty() {
        let empty = numpy.call_method1("empty", (0, kind.name()))?;
        empty.call_method1("setflags", (false,))?;
        return Ok(empty);
    }
    // The array is a view of the bytes, which nobody can change.
    let bytes = PyBytes::new_with(py, values.len() * T::BYTES, |bytes| {
        values.iter().zip(bytes.chunks_exact_mut(T::BYTES)).for_each(|(value, bytes)| value.put(bytes));
        Ok(())
    })?;
    numpy.call_method1("frombuffer", (bytes, kind.name()))
}

/// Arrays that were made already, by name.
#[derive(Default)]
pub struct Cache(Mutex<BTreeMap<String, Py<PyAny>>>);

impl Cache {
    /// The array of a name; `make` makes it at the first call.
    pub fn get<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        make: impl FnOnce() -> PyResult<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        // The lock is never held while Python runs.
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner).get(name).map(|a| a.clone_ref(py));
        if let Some(known) = known {
            return Ok(known.into_bound(py));
        }
        let made = make()?;
        let kept = made.clone().unbind();
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), kept);
        Ok(made)
    }
}
