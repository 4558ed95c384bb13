//! `meniscus measure`: measures of drops and solids in a stored frame.

use super::print;
use crate::args::MeasureArgs;
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use meniscus_scene::units::{Dimension, parse};
use meniscus_view::{
    AngleAt, ContactInterval, ContactMeasure, FitShape, MeasureOptions, Measurement, Midline, SoftMeasure,
    SolidMeasure, TimeStatistics, ViewError,
};
use std::fmt::Write as _;

/// Placeholder for a missing value.
const NONE: &str = "–";

/// Measures a stored frame and prints a table or JSON.
pub fn measure(args: &MeasureArgs) -> Result {
    let at = args.at.as_deref().map(|text| time("--at", text)).transpose()?;
    let window = args.window.as_deref().map(|text| time("--window", text)).transpose()?;
    let options = MeasureOptions { at, window };
    let measured = meniscus_view::measure(&args.dir, &options).map_err(failure)?;
    let text = if args.json { format!("{:#}\n", serde_json::json!(measured)) } else { table(&measured) };
    print(&text)?;
    Ok(0)
}

fn time(flag: &str, text: &str) -> Result<f64> {
    let parsed = parse(text, Dimension::Time);
    parsed.map(|p| p.value).map_err(|e| Failure::new(USAGE, format!("{flag}: {}", e.message)).help(e.help))
}

fn failure(error: ViewError) -> Failure {
    match error {
        ViewError::Time { .. } => {
            Failure::new(USAGE, error.to_string()).help("choose a time in this range for --at")
        }
        _ => Failure::new(OUTPUT, error.to_string()).help("give the output folder of a run"),
    }
}

/// A measurement as text.
fn table(m: &Measurement) -> String {
    let at = m.time.map_or_else(String::new, |t| format!(" at {}", prefixed(t, "s")));
    let mut out =
        format!("{}: frame {}{at}, {}D, cells of {}\n\n", m.scene, m.frame, m.dimension, prefixed(m.dx, "m"));
    out += &drops(m);
    if !m.solids.is_empty() {
        let header = ["solid", "force", "by pressure", "at line", "centre", "depth", "touched"];
        let rows = m.solids.iter().map(|s| solid(s, m));
        out += &titled(&header, rows);
    }
    let soft: Vec<(&str, &SoftMeasure)> =
        m.solids.iter().filter_map(|s| Some((s.name.as_str(), s.soft.as_ref()?))).collect();
    if !soft.is_empty() {
        let header = [
            "deforms",
            "deflection",
            "mean",
            "displacement",
            "tip at",
            "tip moved",
            "slopes",
            "fold",
            "curvature",
            "wetted",
            "ridge",
        ];
        out += &titled(&header, soft.iter().map(|(name, s)| deformation_row(name, s, m)));
    }
    out + &means(m)
}

/// The table of the drops and of the solids that they touch.
fn drops(m: &Measurement) -> String {
    let power = if m.dimension == 2 { "m²" } else { "m³" };
    let sides = if m.dimension == 2 { &["left", "right"][..] } else { &[] };
    let header = [
        &["drop", "volume", "on", "angle", "fit", "residual", "angle at line"],
        sides,
        &["base radius", "height", "wetted area"],
    ];
    let mut rows = vec![header.concat().into_iter().map(String::from).collect::<Vec<_>>()];
    for (i, drop) in m.drops.iter().enumerate() {
        let first = [(i + 1).to_string(), format!("{:.4e} {power}", drop.volume)];
        let blank = [String::new(), String::new()];
        let contacts = drop.contacts.iter().enumerate();
        let lines = contacts.map(|(k, c)| {
            [if k == 0 { &first } else { &blank }.to_vec(), contact(c, drop.centroid[0], m)].concat()
        });
        rows.extend(lines);
        if drop.contacts.is_empty() {
            rows.push([first.to_vec(), vec!["nothing".into()]].concat());
        }
    }
    let mut out = aligned(&rows);
    if m.small_drops > 0 {
        let _ = writeln!(out, "and {} of less than 8 cells, not measured", m.small_drops);
    }
    let drawn = m.drops.len() + m.small_drops;
    if let Some(counted) = m.drops_of_solver.filter(|n| *n != drawn) {
        let _ = writeln!(
            out,
            "the solver counts {counted} of these {drawn} (column `drops`): by its cells, also where they are joined by less than a cell"
        );
    }
    out
}

/// The table of means over the window; empty without one.
fn means(m: &Measurement) -> String {
    let Some(window) = &m.window else { return String::new() };
    let rows: Vec<Vec<String>> = m
        .solids
        .iter()
        .flat_map(|solid| {
            solid.window.iter().map(|(quantity, mean)| mean_row(&solid.name, quantity, mean, m))
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let span = format!("{} to {}", prefixed(window.from, "s"), prefixed(window.to, "s"));
    let table = titled(&["solid", "", "mean", "standard deviation", "least", "largest"], rows.into_iter());
    format!("\nmeans over {span}, {} steps{table}", window.steps)
}

/// A row for a quantity of a solid. The components of a force share one unit, so that they can be compared.
fn mean_row(solid: &str, quantity: &str, mean: &TimeStatistics, m: &Measurement) -> Vec<String> {
    let tell = |x: f64| match quantity.split('_').next() {
        Some("angle") => format!("{x:.2}°"),
        Some("wetted") => format!("{:.1} %", 100.0 * x),
        Some("force") => prefixed(x, if m.dimension == 2 { "N/m" } else { "N" }),
        _ => prefixed(x, "m"),
    };
    let cells = [mean.mean, mean.std, mean.least, mean.largest].map(tell);
    [vec![solid.to_owned(), quantity.replace('_', " ")], cells.to_vec()].concat()
}

/// A table with a header, after an empty line.
fn titled(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let header = header.iter().map(|h| (*h).to_owned()).collect();
    let rows: Vec<Vec<String>> = std::iter::once(header).chain(rows).collect();
    format!("\n{}", aligned(&rows))
}

/// A row for a deformed solid.
fn deformation_row(name: &str, s: &SoftMeasure, m: &Measurement) -> Vec<String> {
    let place = |x: &[f64; 3]| vector(&x[..m.dimension], "m");
    let strip = |tell: &dyn Fn(&Midline) -> String| s.strip.as_ref().map_or(NONE.into(), tell);
    vec![
        name.to_owned(),
        prefixed(s.largest_deflection, "m"),
        prefixed(s.mean_deflection, "m"),
        prefixed(s.largest_displacement, "m"),
        s.tip.as_ref().map_or(NONE.into(), place),
        s.tip_displacement.as_ref().map_or(NONE.into(), place),
        strip(&|x| format!("{:.2}° {:.2}°", x.slopes[0], x.slopes[1])),
        strip(&|x| format!("{:.2}°", x.fold_angle)),
        strip(&|x| format!("{}/m", four_digits(x.curvature))),
        s.wetted.map_or(NONE.into(), |w| format!("{:.1} %", 100.0 * w)),
        s.ridge.as_ref().map_or(NONE.into(), |r| prefixed(r.height, "m")),
    ]
}

/// The row of a drop with its centroid at `middle`, m, along the first axis, on a solid.
fn contact(c: &ContactMeasure, middle: f64, m: &Measurement) -> Vec<String> {
    let [angle, shape, residual] = c.angle.as_ref().map_or([NONE; 3].map(String::from), |a| {
        let shape = match a.shape {
            FitShape::Circle => "circle",
            FitShape::Ellipse => "ellipse",
            FitShape::Sphere => "sphere",
            FitShape::Spheroid => "spheroid",
        };
        [
            format!("{:.2} ± {:.2}°", a.value, a.uncertainty),
            shape.into(),
            format!("{:.3} dx", a.residual / m.dx),
        ]
    });
    let along = |l: &meniscus_view::LocalAngle| {
        format!("{:.2} ± {:.2}° ({:.1} to {:.1})", l.mean, l.std, l.min, l.max)
    };
    let area =
        if m.dimension == 2 { prefixed(c.contact_area, "m") } else { format!("{:.4e} m²", c.contact_area) };
    let first = [
        if c.wall { format!("wall {}", c.solid) } else { c.solid.clone() },
        angle,
        shape,
        residual,
        c.local_angle.as_ref().map_or(NONE.into(), along),
    ];
    let places = c.local_angle.as_ref().map(|l| &l.places).or_else(|| c.angle.as_ref().map(|a| &a.places));
    let end =
        |p: Option<&AngleAt>| p.map_or(NONE.into(), |p| format!("{:.2}° at {}", p.angle, vector(&p.at, "m")));
    let ends = match places.map_or(&[][..], |places| places) {
        [] => [None; 2],
        // A single point is on one side of the drop.
        [only] if only.at[0] <= middle => [Some(only), None],
        [only] => [None, Some(only)],
        [first, .., last] => [Some(first), Some(last)],
    };
    let ends = ends.map(end);
    let last = [c.base_radius.map_or(NONE.into(), |r| prefixed(r, "m")), prefixed(c.height, "m"), area];
    [&first[..], if m.dimension == 2 { &ends[..] } else { &[] }, &last[..]].concat()
}

fn solid(s: &SolidMeasure, m: &Measurement) -> Vec<String> {
    let unit = if m.dimension == 2 { "N/m" } else { "N" };
    let force = |f: &[f64]| vector(f, unit);
    let part = |f: Option<&Vec<f64>>| f.map_or(NONE.into(), |f| force(f));
    let forces = s.forces.as_ref();
    let floats = |f: fn(&meniscus_view::Floating) -> f64| {
        s.floating.as_ref().map_or(NONE.into(), |x| prefixed(f(x), "m"))
    };
    let touched: Vec<String> = s.touches.iter().map(touch).collect();
    vec![
        s.name.clone(),
        part(forces.map(|f| &f.net)),
        part(forces.and_then(|f| f.pressure.as_ref())),
        part(forces.and_then(|f| f.line.as_ref())),
        floats(|f| f.centre_above_level),
        floats(|f| f.depth),
        if touched.is_empty() { "never".into() } else { touched.join("; ") },
    ]
}

fn touch(t: &ContactInterval) -> String {
    let ends = format!("{} to {}", prefixed(t.start, "s"), prefixed(t.end, "s"));
    t.duration.map_or(ends.clone(), |d| format!("{ends}: for {}", prefixed(d, "s")))
}

/// Columns side by side, aligned to their widest cell.
fn aligned(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(s, w)| format!("{s:w$}")).collect();
        out += cells.join("  ").trim_end();
        out += "\n";
    }
    out
}

/// A vector with one prefix for all components; those negligible beside the largest are 0.
fn vector(v: &[f64], unit: &str) -> String {
    let largest = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let (scale, prefix) = prefix(largest);
    let part = |x: &f64| if x.abs() < 1e-6 * largest { "0".into() } else { four_digits(x / scale) };
    format!("({}) {prefix}{unit}", v.iter().map(part).collect::<Vec<_>>().join(", "))
}

/// A number with four digits, a fitting prefix and its unit: `1.612 mm`.
fn prefixed(x: f64, unit: &str) -> String {
    let (scale, prefix) = prefix(x);
    format!("{} {prefix}{unit}", four_digits(x / scale))
}

/// The prefix for a number, and its factor.
fn prefix(x: f64) -> (f64, &'static str) {
    const PREFIXES: [(f64, &str); 4] = [(1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n")];
    let fits = PREFIXES.into_iter().find(|(scale, _)| x.abs() >= scale * 0.999_95);
    if x == 0.0 { PREFIXES[0] } else { fits.unwrap_or(PREFIXES[3]) }
}

fn four_digits(x: f64) -> String {
    let whole = x.abs().max(1.0).log10().floor() as usize;
    let digits = 3usize.saturating_sub(whole);
    let text = format!("{x:.digits$}");
    let cut = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if cut == "-0" { "0".into() } else { cut.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_handy() {
        assert_eq!(prefixed(0.001_612_3, "m"), "1.612 mm");
        assert_eq!(prefixed(6.25e-5, "m"), "62.5 um");
        assert_eq!(prefixed(0.0, "s"), "0 s");
        assert_eq!(prefixed(-0.06, "s"), "-60 ms");
        assert_eq!(prefixed(1234.5, "m"), "1234 m");
        assert_eq!(vector(&[1e-20, -0.0211, 0.1], "N"), "(0, -21.1, 100) mN");
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [vec!["a".to_string(), "bb".into()], vec!["ccc".into(), "–".into()]];
        assert_eq!(aligned(&rows), "a    bb\nccc  –\n");
    }
}
