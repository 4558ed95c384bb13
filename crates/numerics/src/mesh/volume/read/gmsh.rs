//! Gmsh `.msh`, formats 2.2 and 4.1, text and binary (Gmsh reference manual, "File formats"). The elements of all physical
//! groups are merged.

use super::raw_mesh::{ElementUse, RawMesh};
use super::reader::{ReadFault, Reader};

/// Vertices by their number in the file, sorted.
type Numbers = Vec<(u64, u32)>;

/// Format of a file.
#[derive(Clone, Copy, PartialEq)]
struct Format {
    /// 2 or 4; 0 if not yet known.
    version: u8,
    binary: bool,
}

/// Reads a file.
pub(super) fn read<const D: usize>(bytes: &[u8]) -> Result<RawMesh, ReadFault> {
    let mut from = Reader::new(bytes, None);
    let (mut raw, mut numbers) = (RawMesh::default(), Numbers::new());
    let mut format = Format { version: 0, binary: false };
    while let Some(word) = from.word() {
        let Some(section) = word.strip_prefix('$') else {
            return Err(from.fault("no section that starts with `$`"));
        };
        let wanted = matches!(section, "Nodes" | "Elements");
        if wanted && format.version == 0 {
            return Err(from.fault("the section `$MeshFormat` is missing"));
        }
        if section == "MeshFormat" {
            format = read_format(&mut from)?;
        } else if wanted {
            match (section, format.version) {
                ("Nodes", 2) => numbers = nodes_2(&mut from, format.binary, &mut raw)?,
                ("Nodes", _) => numbers = nodes_4(&mut from, format.binary, &mut raw)?,
                (_, 2) => elements_2::<D>(&mut from, format.binary, &numbers, &mut raw)?,
                _ => elements_4::<D>(&mut from, format.binary, &numbers, &mut raw)?,
            }
        }
        from.binary = false;
        let end = format!("$End{section}");
        if !wanted {
            from.skip_past(&end)?;
        } else if from.word() != Some(&end) {
            let what = format!("more in `${section}` than its count says, or `{end}` is missing");
            return Err(from.fault(what));
        }
    }
    if format.version == 0 {
        return Err(from.fault("the section `$MeshFormat` is missing"));
    }
    Ok(raw)
}

/// Reads the section `$MeshFormat`.
fn read_format(from: &mut Reader) -> Result<Format, ReadFault> {
    let version = from.word().unwrap_or_default();
    let known = match version {
        "2.2" | "2" | "2.1" => 2,
        "4.1" => 4,
        _ => return Err(from.fault(format!("format {} is not read; use 2.2 or 4.1", version.escape_debug()))),
    };
    let binary = from.number::<u8>("the file type")? == 1;
    let size: u8 = from.number("the size of numbers")?;
    if size != 8 {
        return Err(from.fault(format!("numbers of {size} bytes; 8 are read")));
    }
    from.line();
    if binary {
        from.binary = true;
        let one = from.i32("the number one")?;
        from.big_endian = one != 1;
    }
    Ok(Format { version: known, binary })
}

fn point(from: &mut Reader) -> Result<[f64; 3], ReadFault> {
    Ok([from.f64("a coordinate")?, from.f64("a coordinate")?, from.f64("a coordinate")?])
}

/// Sorts vertices by number and rejects duplicates.
fn sorted(from: &Reader, mut numbers: Numbers) -> Result<Numbers, ReadFault> {
    numbers.sort_unstable();
    match numbers.windows(2).find(|n| n[0].0 == n[1].0) {
        Some(twice) => Err(from.fault(format!("vertex {} is there twice", twice[0].0))),
        None => Ok(numbers),
    }
}

fn nodes_2(from: &mut Reader, binary: bool, raw: &mut RawMesh) -> Result<Numbers, ReadFault> {
    let count = from.count("the number of vertices")?;
    from.line();
    from.binary = binary;
    let mut numbers = Vec::with_capacity(count);
    for _ in 0..count {
        numbers.push((from.i32("a vertex' number")? as u64, raw.points.len() as u32));
        raw.points.push(point(from)?);
    }
    sorted(from, numbers)
}

fn nodes_4(from: &mut Reader, binary: bool, raw: &mut RawMesh) -> Result<Numbers, ReadFault> {
    from.line();
    from.binary = binary;
    let blocks = from.u64("the number of blocks")?;
    (0..3).try_for_each(|_| from.u64("the number of vertices").map(drop))?;
    let mut numbers = Vec::new();
    for _ in 0..blocks {
        let dimension = from.i32("an entity's dimension")?;
        from.i32("an entity's number")?;
        let parametric = from.i32("whether there are parameters")? != 0;
        let count = from.u64("the number of vertices")?;
        let count = from.checked_count(count, "the number of vertices")?;
        let first = raw.points.len();
        for k in 0..count {
            numbers.push((from.u64("a vertex' number")?, (first + k) as u32));
        }
        for _ in 0..count {
            raw.points.push(point(from)?);
            let parameters = if parametric { dimension } else { 0 };
            (0..parameters).try_for_each(|_| from.f64("a parameter").map(drop))?;
        }
    }
    sorted(from, numbers)
}

fn elements_2<const D: usize>(
    from: &mut Reader,
    binary: bool,
    numbers: &Numbers,
    raw: &mut RawMesh,
) -> Result<(), ReadFault> {
    let count = from.count("the number of elements")?;
    from.line();
    from.binary = binary;
    let mut read = 0;
    while read < count {
        // Binary elements come in blocks of one type; the element numbers follow the block's head.
        let first = from.i32("an element's number or type")?;
        let (kind, many) = if binary {
            (first, from.i32("a number of elements")?)
        } else {
            (from.i32("an element's type")?, 1)
        };
        let tags = from.i32("the number of tags")?;
        let nodes = node_count(from, kind)?;
        if many < 1 || tags < 0 {
            return Err(from.fault("a block without elements"));
        }
        for _ in 0..many {
            let element = if binary { from.i32("an element's number")? } else { first };
            (0..tags).try_for_each(|_| from.i32("a tag").map(drop))?;
            let v: Vec<u64> =
                (0..nodes).map(|_| from.i32("a vertex").map(|v| v as u64)).collect::<Result<_, _>>()?;
            add_element::<D>(element as u64, kind, &v, numbers, raw)?;
            read += 1;
        }
    }
    Ok(())
}

fn elements_4<const D: usize>(
    from: &mut Reader,
    binary: bool,
    numbers: &Numbers,
    raw: &mut RawMesh,
) -> Result<(), ReadFault> {
    from.line();
    from.binary = binary;
    let blocks = from.u64("the number of blocks")?;
    (0..3).try_for_each(|_| from.u64("the number of elements").map(drop))?;
    for _ in 0..blocks {
        from.i32("an entity's dimension")?;
        from.i32("an entity's number")?;
        let kind = from.i32("an element's type")?;
        let count = from.u64("the number of elements")?;
        let nodes = node_count(from, kind)?;
        for _ in 0..from.checked_count(count, "the number of elements")? {
            let element = from.u64("an element's number")?;
            let v: Vec<u64> = (0..nodes).map(|_| from.u64("a vertex")).collect::<Result<_, _>>()?;
            add_element::<D>(element, kind, &v, numbers, raw)?;
        }
    }
    Ok(())
}

/// Adds an element if its type is accepted.
fn add_element<const D: usize>(
    element: u64,
    kind: i32,
    vertices: &[u64],
    numbers: &Numbers,
    raw: &mut RawMesh,
) -> Result<(), ReadFault> {
    match element_use::<D>(kind) {
        ElementUse::Skipped => return Ok(()),
        ElementUse::Rejected(what) => return Err(ReadFault::Element { element, what: what.into() }),
        ElementUse::Accepted => {}
    }
    let place = |v: &u64| numbers.binary_search_by_key(v, |n| n.0).ok().map(|i| numbers[i].1);
    let v = vertices.iter().map(place).collect::<Option<Vec<u32>>>();
    raw.elements.push((element, v.ok_or(ReadFault::Vertex { element })?));
    Ok(())
}

/// Number of vertices of an element of a type.
fn node_count(from: &Reader, kind: i32) -> Result<usize, ReadFault> {
    const NODES: [usize; 31] = [
        2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5, 6, 20,
        35, 56,
    ];
    let index = usize::try_from(kind - 1).ok();
    let nodes = index.and_then(|i| NODES.get(i).copied());
    nodes.ok_or_else(|| from.fault(format!("elements of type {kind} are not known")))
}

/// Use of elements of a type.
fn element_use<const D: usize>(kind: i32) -> ElementUse {
    match (D, kind) {
        (2, 2) | (3, 4) => ElementUse::Accepted,
        // Points and lines; in 3D triangles and quadrilaterals.
        (_, 1 | 8 | 15 | 26..=28) | (3, 2 | 3 | 9 | 10 | 16 | 20..=25) => ElementUse::Skipped,
        (2, 4) => ElementUse::Rejected("a tetrahedron"),
        (_, 3 | 10 | 16) => ElementUse::Rejected("a quadrilateral"),
        (_, 5 | 12 | 17) => ElementUse::Rejected("a hexahedron"),
        (_, 6 | 13 | 18) => ElementUse::Rejected("a prism"),
        (_, 7 | 14 | 19) => ElementUse::Rejected("a pyramid"),
        _ => ElementUse::Rejected("an element of higher order"),
    }
}
