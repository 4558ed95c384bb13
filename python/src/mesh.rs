//! Meshes of frames: surfaces, contact lines, elements of solids.

use crate::arrays::{Cache, Kind, array};
use crate::errors::OrRaise;
use crate::frame::save;
use meniscus_scene::output::frame::{Attribute, Frame as FrameContent, FrameElements, FrameMesh};
use pyo3::exceptions::{PyAttributeError, PyKeyError};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// Which mesh of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// The liquid's surface.
    Liquid,
    /// The surface of a solid, by its number.
    Solid(usize),
    /// The contact line.
    Line,
}

/// A mesh of a frame: vertices with attributes, and the triangles or edges between them.
///
/// ``mesh["NAME"]`` is an attribute: an array (n,) of float64 with a value for each vertex. ``mesh.attributes`` has their names,
/// ``mesh.unit(name)`` and ``mesh.meaning(name)`` tell what they are. All numbers are in SI units, angles in degrees.
#[pyclass(frozen, module = "meniscus")]
pub struct Mesh {
    frame: Arc<FrameContent>,
    part: Part,
    cache: Cache,
}

impl Mesh {
    /// A mesh of a frame, which has this part.
    pub fn new(frame: &Arc<FrameContent>, part: Part) -> Self {
        Self { frame: Arc::clone(frame), part, cache: Cache::default() }
    }

    fn content(&self) -> PyResult<&FrameMesh> {
        let found = match self.part {
            Part::Liquid => Some(&self.frame.liquid),
            Part::Solid(number) => self.frame.solids.get(number).map(|(_, mesh)| mesh),
            Part::Line => self.frame.contact_line.as_ref(),
        };
        found.ok_or_else(|| PyKeyError::new_err("the frame has no such mesh"))
    }

    fn attribute(&self, name: &str) -> PyResult<&Attribute> {
        find(&self.content()?.attributes, name)
    }
}

/// The attribute of a name, or a ``KeyError`` with all names.
fn find<'a>(all: &'a [Attribute], name: &str) -> PyResult<&'a Attribute> {
    all.iter().find(|a| a.name == name).ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|a| &*a.name).collect();
        PyKeyError::new_err(format!("there is no attribute `{name}`; there are: {}", names.join(", ")))
    })
}

#[pymethods]
impl Mesh {
    /// Positions of the vertices, m: array (n, 3) of float64. In 2D the third coordinate is 0.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = &self.content()?.positions;
        self.cache.get(py, "positions", || array(py, of, Kind::Float, vec![of.len(), 3]))
    }

    /// Triangles as vertex numbers, counter-clockwise seen from outside: array (m, 3) of uint32; empty in 2D.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = &self.content()?.triangles;
        self.cache.get(py, "triangles", || array(py, of, Kind::Index, vec![of.len(), 3]))
    }

    /// Edges as vertex numbers: array (m, 2) of uint32; of surfaces in 2D, and of contact lines in 3D.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = &self.content()?.edges;
        self.cache.get(py, "edges", || array(py, of, Kind::Index, vec![of.len(), 2]))
    }

    /// Normals of the vertices, of length 1: array (n, 3) of float64. Of surfaces in 3D.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = self.content()?.normals();
        self.cache.get(py, "normals", || array(py, &of, Kind::Float, vec![of.len(), 3]))
    }

    /// Names of the attributes.
    #[getter]
    fn attributes(&self) -> PyResult<Vec<String>> {
        Ok(self.content()?.attributes.iter().map(|a| a.name.to_string()).collect())
    }

    /// The unit of an attribute; ``1`` for a number without one.
    fn unit(&self, name: &str) -> PyResult<String> {
        Ok(self.attribute(name)?.unit.to_string())
    }

    /// What an attribute is, a phrase.
    fn meaning(&self, name: &str) -> PyResult<String> {
        Ok(self.attribute(name)?.meaning.to_string())
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let of = &self.attribute(name)?.values;
        self.cache.get(py, &format!("[{name}]"), || array(py, of, Kind::Float, vec![of.len()]))
    }

    fn __contains__(&self, name: &str) -> PyResult<bool> {
        Ok(self.content()?.attributes.iter().any(|a| a.name == name))
    }

    fn __len__(&self) -> PyResult<usize> {
        Ok(self.content()?.positions.len())
    }

    /// Writes the mesh into a file whose format is that of its ending: ``.ply``, ``.vtp``, ``.obj``, ``.glb``, ``.usda``; a contact line
    /// also ``.csv``.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let frame = &self.frame;
        let content = FrameContent {
            time: frame.time,
            interval: frame.interval,
            unit: frame.unit,
            up_axis: frame.up_axis,
            liquid: if self.part == Part::Liquid { frame.liquid.clone() } else { FrameMesh::default() },
            solids: match self.part {
                Part::Solid(number) => frame.solids.get(number).cloned().into_iter().collect(),
                _ => Vec::new(),
            },
            contact_line: frame.contact_line.clone().filter(|_| self.part == Part::Line),
            wall_solid: frame.wall_solid,
            elements: Vec::new(),
            fields: None,
        };
        let name = match self.part {
            Part::Liquid => "liquid".to_owned(),
            Part::Solid(number) => format!("solid_{}", frame.solids.get(number).map_or("", |s| &s.0)),
            Part::Line => "contact_line".to_owned(),
        };
        py.detach(|| save(&content, &name, &path)).or_raise(py)
    }

    fn __repr__(&self) -> PyResult<String> {
        let of = self.content()?;
        Ok(format!(
            "<meniscus.Mesh: {} vertices, {} triangles, {} edges, attributes {}>",
            of.positions.len(),
            of.triangles.len(),
            of.edges.len(),
            self.attributes()?.join(", ")
        ))
    }
}

/// A solid in a frame.
#[pyclass(frozen, module = "meniscus")]
pub struct Solid {
    frame: Arc<FrameContent>,
    number: usize,
    cache: Cache,
}

impl Solid {
    /// The solid of a number in a frame, which has it.
    pub fn new(frame: &Arc<FrameContent>, number: usize) -> Self {
        Self { frame: Arc::clone(frame), number, cache: Cache::default() }
    }

    fn content(&self) -> PyResult<&(String, FrameMesh)> {
        self.frame.solids.get(self.number).ok_or_else(|| PyKeyError::new_err("the frame has no such solid"))
    }

    fn surface(&self) -> Mesh {
        Mesh::new(&self.frame, Part::Solid(self.number))
    }
}

#[pymethods]
impl Solid {
    /// Its name.
    #[getter]
    fn name(&self) -> PyResult<&str> {
        Ok(&self.content()?.0)
    }

    /// Its surface with all attributes.
    #[getter]
    fn mesh(&self) -> Mesh {
        self.surface()
    }

    /// Positions of the vertices of the surface, m: array (n, 3) of float64.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = &self.content()?.1.positions;
        self.cache.get(py, "positions", || array(py, of, Kind::Float, vec![of.len(), 3]))
    }

    /// Displacement of the vertices of the surface from their place at rest, m: array (n, 3) of float64. Of solids that deform.
    #[getter]
    fn displacement<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (name, mesh) = self.content()?;
        let parts = ["ux", "uy", "uz"].map(|part| mesh.values(part));
        let [Some(x), Some(y), Some(z)] = parts else {
            let message = format!("the solid `{name}` does not deform, so it has no displacement");
            return Err(PyAttributeError::new_err(message));
        };
        self.cache.get(py, "displacement", || {
            let of: Vec<[f64; 3]> = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]).collect();
            array(py, &of, Kind::Float, vec![of.len(), 3])
        })
    }

    /// Distance to the contact line along the surface at its vertices, m, negative where it is wetted: array (n,) of float64.
    #[getter]
    fn phi_c<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.surface().__getitem__(py, "phi_c")
    }

    /// Its elements, if it deforms; None in a frame that was read from files.
    #[getter]
    fn elements(&self) -> PyResult<Option<Elements>> {
        let name = &self.content()?.0;
        let found = self.frame.elements.iter().position(|(own, _)| own == name);
        Ok(found.map(|at| Elements { frame: Arc::clone(&self.frame), at, cache: Cache::default() }))
    }

    fn __repr__(&self) -> PyResult<String> {
        let (name, mesh) = self.content()?;
        Ok(format!("<meniscus.Solid `{name}`: {} vertices of the surface>", mesh.positions.len()))
    }
}

/// The elements of a solid that deforms.
///
/// ``elements["NAME"]`` is an attribute: ``displacement`` (m) and ``velocity`` (m/s), arrays (n, 3); ``strain``, (n,), the largest
/// |stretch - 1|; ``stress`` (Pa, Cauchy's), (n, 3, 3), not of springs; ``green_strain``, (m, 3, 3), of the elements.
#[pyclass(frozen, module = "meniscus")]
pub struct Elements {
    frame: Arc<FrameContent>,
    at: usize,
    cache: Cache,
}

impl Elements {
    fn content(&self) -> PyResult<&FrameElements> {
        let found = self.frame.elements.get(self.at).map(|(_, elements)| elements);
        found.ok_or_else(|| PyKeyError::new_err("the frame has no such elements"))
    }
}

#[pymethods]
impl Elements {
    /// Positions of the vertices, m: array (n, 3) of float64.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = &self.content()?.positions;
        self.cache.get(py, "positions", || array(py, of, Kind::Float, vec![of.len(), 3]))
    }

    /// Elements as vertex numbers: array (m, 4) of uint32, tetrahedra; in 2D (m, 3), triangles.
    #[getter]
    fn simplices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let of = self.content()?;
        let corners = if of.are_triangles { 3 } else { 4 };
        self.cache.get(py, "simplices", || {
            let all: Vec<u32> = of.simplices.iter().flat_map(|s| &s[..corners]).copied().collect();
            array(py, &all, Kind::Index, vec![of.simplices.len(), corners])
        })
    }

    /// Names of the attributes.
    #[getter]
    fn attributes(&self) -> PyResult<Vec<String>> {
        let of = self.content()?;
        Ok(of.at_vertices.iter().chain(&of.at_elements).map(|a| a.name.to_string()).collect())
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let of = self.content()?;
        let own = of.at_vertices.iter().find(|a| a.name == name);
        let (count, found) = match own {
            Some(found) => (of.positions.len(), found),
            None => (of.simplices.len(), find(&of.at_elements, name)?),
        };
        let shape = match found.values.len().checked_div(count).unwrap_or(1) {
            9 => vec![count, 3, 3],
            3 => vec![count, 3],
            _ => vec![count],
        };
        self.cache.get(py, &format!("[{name}]"), || array(py, &found.values, Kind::Float, shape))
    }

    fn __repr__(&self) -> PyResult<String> {
        let of = self.content()?;
        Ok(format!("<meniscus.Elements: {} vertices, {} elements>", of.positions.len(), of.simplices.len()))
    }
}
