//! TetGen `.node` and `.ele` files, and Triangle's in 2D (H. Si, TetGen manual, 5.2; J. Shewchuk, Triangle).

use super::raw_mesh::RawMesh;
use super::reader::{ReadFault, Reader};

/// Vertices of a `.node` file, and the number of the first.
pub(super) struct Nodes {
    raw: RawMesh,
    first: u64,
}

/// Reads a `.node` file: number of vertices, dimension, numbers of attributes and markers; then for each vertex its number,
/// coordinates, attributes and markers.
pub(super) fn nodes<const D: usize>(bytes: &[u8]) -> Result<Nodes, ReadFault> {
    let mut from = Reader::new(bytes, Some(b'#'));
    let count = from.count("the number of vertices")?;
    let dimension: usize = from.number("the dimension")?;
    if !(dimension == D || (D == 2 && dimension == 3)) {
        return Err(from.fault(format!("vertices of a {dimension}D mesh in a {D}D scene")));
    }
    from.line();
    let (mut raw, mut first) = (RawMesh::default(), 0);
    for k in 0..count as u64 {
        let number: u64 = from.number("a vertex' number")?;
        first = if k == 0 { number } else { first };
        if number != first + k {
            return Err(from.fault(format!("vertex {number} where {} should be", first + k)));
        }
        let mut point = [0.0; 3];
        for x in &mut point[..dimension] {
            *x = from.f64("a coordinate")?;
        }
        raw.points.push(point);
        from.line();
    }
    expect_end(&mut from, count)?;
    Ok(Nodes { raw, first })
}

/// Reads an `.ele` file: number of elements, vertices per element, number of attributes; then each element's number and vertices.
pub(super) fn elements<const D: usize>(bytes: &[u8], nodes: Nodes) -> Result<RawMesh, ReadFault> {
    let Nodes { mut raw, first } = nodes;
    let mut from = Reader::new(bytes, Some(b'#'));
    let count = from.count("the number of elements")?;
    let corners: usize = from.number("the number of an element's vertices")?;
    from.line();
    for _ in 0..count {
        let element: u64 = from.number("an element's number")?;
        if corners != D + 1 {
            return Err(ReadFault::Element { element, what: format!("one of {corners} vertices") });
        }
        let mut vertices = Vec::with_capacity(D + 1);
        for _ in 0..=D {
            let v: u64 = from.number("a vertex")?;
            let place = v.checked_sub(first).and_then(|v| u32::try_from(v).ok());
            vertices.push(place.ok_or(ReadFault::Vertex { element })?);
        }
        raw.elements.push((element, vertices));
        from.line();
    }
    expect_end(&mut from, count)?;
    Ok(raw)
}

/// Rejects content after the end of a list.
fn expect_end(from: &mut Reader, count: usize) -> Result<(), ReadFault> {
    match from.word() {
        Some(_) => Err(from.fault(format!("more lines than the {count} of the file's head"))),
        None => Ok(()),
    }
}
