//! VTK legacy files with an unstructured grid, versions up to 5.1, text and binary (The VTK User's Guide, "Simple legacy
//! formats"). Binary numbers are big-endian.

use super::raw_mesh::{ElementUse, RawMesh};
use super::reader::{ReadFault, Reader};

/// Reads a file. Elements are numbered from 0.
pub(super) fn read<const D: usize>(bytes: &[u8]) -> Result<RawMesh, ReadFault> {
    let mut from = Reader::new(bytes, None);
    let head = from.line();
    let Some(version) = head.strip_prefix("# vtk DataFile Version ") else {
        return Err(from.fault("the first line is not `# vtk DataFile Version …`"));
    };
    let offsets = version.trim().starts_with('5');
    from.line();
    let binary = match from.word() {
        Some("ASCII") => false,
        Some("BINARY") => true,
        _ => return Err(from.fault("neither `ASCII` nor `BINARY` follows the title")),
    };
    from.big_endian = true;
    if (from.word(), from.word()) != (Some("DATASET"), Some("UNSTRUCTURED_GRID")) {
        return Err(from.fault("`DATASET UNSTRUCTURED_GRID` is missing"));
    }
    let (mut raw, mut cells) = (RawMesh::default(), Vec::new());
    while let Some(word) = from.word() {
        match word {
            "POINTS" => points(&mut from, binary, &mut raw)?,
            "CELLS" if offsets => cells = cells_by_offsets(&mut from, binary)?,
            "CELLS" => cells = cells_by_counts(&mut from, binary)?,
            "CELL_TYPES" => {
                types::<D>(&mut from, binary, &mut cells, &mut raw)?;
                return Ok(raw);
            }
            "FIELD" => fields(&mut from, binary)?,
            "METADATA" => {
                // The section ends at an empty line or at the end of the file.
                from.line();
                while !from.ended() && !from.line().is_empty() {}
            }
            other => return Err(from.fault(format!("`{}` is not known here", other.escape_debug()))),
        }
        from.binary = false;
    }
    Err(from.fault("`CELL_TYPES` is missing"))
}

fn points(from: &mut Reader, binary: bool, raw: &mut RawMesh) -> Result<(), ReadFault> {
    let count = from.count("the number of points")?;
    let double = match from.word() {
        Some("double") => true,
        Some("float") => false,
        _ => return Err(from.fault("points are neither `float` nor `double`")),
    };
    from.line();
    from.binary = binary;
    for _ in 0..count {
        let mut point = [0.0; 3];
        for x in &mut point {
            *x = if double { from.f64("a coordinate")? } else { from.f32("a coordinate")? };
        }
        raw.points.push(point);
    }
    Ok(())
}

/// Skips field data of the whole data set, such as a time.
fn fields(from: &mut Reader, binary: bool) -> Result<(), ReadFault> {
    from.word();
    for _ in 0..from.count("the number of arrays")? {
        from.word();
        let parts = from.count("the number of an array's components")?;
        let entries = parts.saturating_mul(from.count("the number of an array's entries")?);
        let size = match from.word() {
            Some("char" | "unsigned_char") => 1,
            Some("short" | "unsigned_short") => 2,
            Some("int" | "unsigned_int" | "float" | "vtkIdType") => 4,
            Some("long" | "unsigned_long" | "double" | "vtktypeint64" | "vtktypeuint64") => 8,
            other => {
                let what = format!("entries of an array are `{}`", other.unwrap_or_default().escape_debug());
                return Err(from.fault(what));
            }
        };
        from.line();
        if binary {
            from.skip(entries.saturating_mul(size))?;
        } else if (0..entries).any(|_| from.word().is_none()) {
            return Err(from.fault("the file ends too early"));
        }
    }
    Ok(())
}

/// Cells up to version 4: for each cell the number of its vertices, then the vertices.
fn cells_by_counts(from: &mut Reader, binary: bool) -> Result<Vec<Vec<u32>>, ReadFault> {
    let count = from.count("the number of cells")?;
    from.count("the number of entries")?;
    from.line();
    from.binary = binary;
    let mut cells = Vec::with_capacity(count);
    for _ in 0..count {
        let vertices = from.i32("the number of a cell's vertices")?;
        let vertices = from.checked_count(vertices as u64, "the number of a cell's vertices")?;
        cells.push((0..vertices).map(|_| from.i32("a vertex").map(|v| v as u32)).collect::<Result<_, _>>()?);
    }
    Ok(cells)
}

/// Cells from version 5: the offset of each cell's vertices, then the vertices of all cells.
fn cells_by_offsets(from: &mut Reader, binary: bool) -> Result<Vec<Vec<u32>>, ReadFault> {
    let sizes = [from.count("the number of offsets")?, from.count("the number of entries")?];
    let mut lists: [Vec<u64>; 2] = Default::default();
    for ((name, size), list) in ["OFFSETS", "CONNECTIVITY"].into_iter().zip(sizes).zip(&mut lists) {
        from.binary = false;
        if from.word() != Some(name) {
            return Err(from.fault(format!("`{name}` is missing")));
        }
        let wide = matches!(from.word(), Some("vtktypeint64"));
        from.line();
        from.binary = binary;
        for _ in 0..size {
            list.push(if wide { from.u64("an entry")? } else { from.i32("an entry")? as u64 });
        }
    }
    let [offsets, vertices] = lists;
    let cell = |pair: &[u64]| {
        let range = usize::try_from(pair[0]).ok()?..usize::try_from(pair[1]).ok()?;
        Some(vertices.get(range)?.iter().map(|v| u32::try_from(*v).unwrap_or(u32::MAX)).collect())
    };
    offsets
        .windows(2)
        .map(cell)
        .collect::<Option<_>>()
        .ok_or_else(|| from.fault("offsets beyond the vertices"))
}

/// Reads the types of the cells and keeps the cells that are accepted.
fn types<const D: usize>(
    from: &mut Reader,
    binary: bool,
    cells: &mut [Vec<u32>],
    raw: &mut RawMesh,
) -> Result<(), ReadFault> {
    let count = from.count("the number of types")?;
    if count != cells.len() {
        return Err(from.fault(format!("{count} types of {} cells", cells.len())));
    }
    from.line();
    from.binary = binary;
    for (number, cell) in cells.iter_mut().enumerate() {
        let element = number as u64;
        match element_use::<D>(from.i32("a cell's type")?) {
            ElementUse::Accepted => raw.elements.push((element, std::mem::take(cell))),
            ElementUse::Skipped => {}
            ElementUse::Rejected(what) => return Err(ReadFault::Element { element, what: what.into() }),
        }
    }
    Ok(())
}

/// Use of cells of a type.
fn element_use<const D: usize>(kind: i32) -> ElementUse {
    match (D, kind) {
        (2, 5) | (3, 10) => ElementUse::Accepted,
        (_, 0..=4 | 21) | (3, 5..=9 | 22 | 23) => ElementUse::Skipped,
        (2, 10) => ElementUse::Rejected("a tetrahedron"),
        (_, 6..=9) => ElementUse::Rejected("no triangle but a strip, polygon or quadrilateral"),
        (_, 11 | 12) => ElementUse::Rejected("a hexahedron"),
        (_, 13) => ElementUse::Rejected("a prism"),
        (_, 14) => ElementUse::Rejected("a pyramid"),
        _ => ElementUse::Rejected("an element of higher order"),
    }
}
