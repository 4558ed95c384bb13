//! The text of a USD layer.

use super::prim::{FRAMES_PER_SECOND, Material, Prim, Property, Values};
use std::io::{self, Write};

/// Name of the root prim.
pub(super) const ROOT: &str = "frame";

/// Frames of a layer.
pub(super) struct Range {
    /// Number of the first one.
    pub first: u64,
    /// Number of the last one.
    pub last: u64,
    /// The axis that points up: 1 or 2.
    pub up_axis: usize,
    /// Length of one unit of the positions, m.
    pub unit: f64,
}

/// Colour, roughness, index of refraction and opacity of a material.
type Look = (Material, &'static str, f32, f32, f32);

/// Water at 20 °C has the index 1.333 (CRC Handbook of Chemistry and Physics); the other numbers are a matter of taste.
const LOOKS: [Look; 3] = [
    (Material::Liquid, "(0.8, 0.92, 1)", 0.02, 1.333, 0.15),
    (Material::Solid, "(0.75, 0.73, 0.7)", 0.6, 1.5, 1.0),
    (Material::Line, "(0.82, 0.16, 0.16)", 0.5, 1.5, 1.0),
];

/// Writes the head of a layer.
pub(super) fn write_head(out: &mut impl Write, range: &Range) -> io::Result<()> {
    let Range { first, last, up_axis, unit } = range;
    let up = if *up_axis == 1 { "Y" } else { "Z" };
    let version = env!("CARGO_PKG_VERSION");
    write!(
        out,
        "#usda 1.0\n(\n    customLayerData = {{\n        string creator = \"Meniscus {version}\"\n    }}\n    defaultPrim = \"{ROOT}\"\n    \
         doc = \"Attributes in SI units and degrees. A time code is the number of a frame.\"\n    \
         endTimeCode = {last}\n    framesPerSecond = {FRAMES_PER_SECOND}\n    metersPerUnit = {unit}\n    startTimeCode = {first}\n    \
         timeCodesPerSecond = {FRAMES_PER_SECOND}\n    upAxis = \"{up}\"\n)\n\n"
    )
}

/// Opens the root prim, with further metadata if there is some, and writes the materials.
pub(super) fn open_root(out: &mut impl Write, metadata: Option<&str>) -> io::Result<()> {
    let metadata = metadata.unwrap_or_default();
    write!(out, "def Xform \"{ROOT}\" (\n{metadata}    kind = \"component\"\n)\n{{\n")?;
    write!(out, "    def Scope \"materials\"\n    {{\n")?;
    LOOKS.iter().try_for_each(|look| write_material(out, look))?;
    write!(out, "    }}\n\n")
}

/// Closes the root prim.
pub(super) fn close_root(out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "}}")
}

fn write_material(out: &mut impl Write, look: &Look) -> io::Result<()> {
    let (material, color, roughness, ior, opacity) = look;
    let name = material.name();
    write!(
        out,
        "        def Material \"{name}\"\n        {{\n            \
         token outputs:surface.connect = </{ROOT}/materials/{name}/surface.outputs:surface>\n\n            \
         def Shader \"surface\"\n            {{\n                uniform token info:id = \"UsdPreviewSurface\"\n                \
         color3f inputs:diffuseColor = {color}\n                float inputs:ior = {ior:?}\n                \
         float inputs:metallic = 0\n                float inputs:opacity = {opacity:?}\n                \
         float inputs:roughness = {roughness:?}\n                token outputs:surface\n            }}\n        }}\n"
    )
}

/// Writes the time in seconds as an attribute of the root prim: a sample at the number of a frame, or without one the attribute alone.
pub(super) fn write_time(out: &mut impl Write, sample: Option<(u64, f64)>) -> io::Result<()> {
    write!(
        out,
        "    custom double meniscus:time (\n        customData = {{\n            string unit = \"s\"\n        }}\n        \
         doc = \"time of the frame\"\n    )\n"
    )?;
    if let Some((number, time)) = sample {
        write!(out, "    double meniscus:time.timeSamples = {{\n        {number}: {time:?},\n    }}\n")?;
    }
    writeln!(out)
}

/// Writes a prim, with its values at the number of a frame, or without any.
pub(super) fn write_prim(out: &mut impl Write, prim: &Prim, number: Option<u64>) -> io::Result<()> {
    let Prim { kind, label, fixed, properties } = prim;
    write!(
        out,
        "    def {kind} \"{}\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n        displayName = \"{}\"\n    )\n    {{\n",
        label.name,
        quoted(&label.shown)
    )?;
    let material = label.material;
    writeln!(out, "        uniform bool doubleSided = 1")?;
    writeln!(out, "        rel material:binding = </{ROOT}/materials/{}>", material.name())?;
    write!(
        out,
        "        color3f[] primvars:displayColor = [{}] (\n            interpolation = \"constant\"\n        )\n",
        material.display_color()
    )?;
    fixed.iter().try_for_each(|line| writeln!(out, "        {line}"))?;
    properties.iter().try_for_each(|property| write_property(out, property, number))?;
    write!(out, "    }}\n\n")
}

fn write_property(out: &mut impl Write, property: &Property, number: Option<u64>) -> io::Result<()> {
    let Property { kind, name, interpolation, unit, meaning, values } = property;
    write!(out, "        {kind} {name}")?;
    if let Some(interpolation) = interpolation {
        writeln!(out, " (")?;
        if !unit.is_empty() {
            let unit = quoted(unit);
            write!(
                out,
                "            customData = {{\n                string unit = \"{unit}\"\n            }}\n"
            )?;
        }
        if !meaning.is_empty() {
            writeln!(out, "            doc = \"{}\"", quoted(meaning))?;
        }
        write!(out, "            interpolation = \"{interpolation}\"\n        )")?;
    }
    writeln!(out)?;
    let Some(number) = number else { return Ok(()) };
    write!(out, "        {kind} {name}.timeSamples = {{\n            {number}: [")?;
    match values {
        Values::Integers(all) => write_list(out, all, |out, x| write!(out, "{x}")),
        Values::Floats(all) => write_list(out, all, |out, x| write!(out, "{x:?}")),
        Values::Vectors(all) => write_list(out, all, |out, [x, y, z]| write!(out, "({x:?}, {y:?}, {z:?})")),
    }?;
    write!(out, "],\n        }}\n")
}

fn write_list<W: Write, T>(
    out: &mut W,
    all: &[T],
    write: impl Fn(&mut W, &T) -> io::Result<()>,
) -> io::Result<()> {
    all.iter().enumerate().try_for_each(|(i, value)| {
        if i > 0 {
            out.write_all(b", ")?;
        }
        write(out, value)
    })
}

/// A text that can stand between quotes.
fn quoted(text: &str) -> String {
    text.replace(['"', '\\', '\n', '\r'], "'")
}
