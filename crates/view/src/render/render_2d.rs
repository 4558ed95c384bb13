//! Pictures of runs in two dimensions.

use meniscus_numerics::mesh::ply::PlyMesh;

use super::coverage::coverage;
use super::image::{Canvas, ImageSize};
use super::legend::ColorMapping;
use super::setup::round_length;
use super::{Appearance, label};
use crate::color_map::linear_from_srgb;
use crate::folder::{Bounds, Frame, RunFolder, V3};
use crate::wetted::{self, Depths};

/// Magnification of the liquid above which the window shows less than the whole domain.
const ZOOM_THRESHOLD: f64 = 1.7;

/// Colour of the domain where there is no liquid.
const PAPER: u32 = 0x00fb_fcfd;

/// Window of the plane and its mapping to the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Viewport {
    center: [f64; 2],
    /// Pixels per metre.
    scale: f64,
    size: ImageSize,
    domain: Option<[f64; 2]>,
    /// Cell size, m, if known.
    dx: Option<f64>,
}

/// Encodes a linear colour as 8-bit sRGB without tone mapping.
pub(crate) fn encode_srgb(c: &V3) -> [u8; 3] {
    [c.x, c.y, c.z].map(|x| {
        let s = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (s.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    })
}

impl Viewport {
    /// A window that shows the domain, or only the bounds `seen` if these are much smaller.
    pub(crate) fn new(folder: &RunFolder, seen: &Bounds, size: ImageSize) -> Self {
        let domain = folder.domain.map(|d| [d[0], d[1]]);
        let [w, h] = size.into();
        let border = 0.12 * w.min(h);
        let scale = |lower: &V3, upper: &V3| {
            let fit =
                |a: usize, pixels: f64| (pixels - 2.0 * border).max(1.0) / (upper[a] - lower[a]).max(1e-12);
            fit(0, w).min(fit(1, h))
        };
        let margin = V3::repeat(0.12 * seen.size().norm().max(1e-12));
        let (mut lower, mut upper) = (seen.lower - margin, seen.upper + margin);
        if let Some(d) = domain {
            let whole = (V3::zeros(), V3::new(d[0], d[1], 0.0));
            (lower, upper) = if scale(&lower, &upper) > ZOOM_THRESHOLD * scale(&whole.0, &whole.1) {
                (lower.sup(&whole.0), upper.inf(&whole.1))
            } else {
                whole
            };
        }
        let center = [0.5 * (lower.x + upper.x), 0.5 * (lower.y + upper.y)];
        Self { center, scale: scale(&lower, &upper), size, domain, dx: folder.dx }
    }

    /// Width and height of the picture in pixels.
    pub(crate) fn size(&self) -> [f64; 2] {
        self.size.into()
    }

    /// Position of a point in the picture, in pixels.
    pub(crate) fn place(&self, p: &[f64]) -> [f64; 2] {
        let [w, h] = self.size();
        [0.5 * w + (p[0] - self.center[0]) * self.scale, 0.5 * h - (p[1] - self.center[1]) * self.scale]
    }

    fn segments(&self, mesh: &PlyMesh) -> Vec<[[f64; 2]; 2]> {
        mesh.edges.iter().map(|e| e.map(|i| self.place(&mesh.positions[i as usize]))).collect()
    }
}

/// Renders one frame.
pub(crate) fn picture(
    window: &Viewport,
    frame: &Frame,
    set: &Appearance,
    shading: Option<&ColorMapping>,
) -> Canvas {
    let mut canvas = Canvas::new(window.size, linear_from_srgb(set.background.unwrap_or(0x00e9_edf1)));
    let thick = (f64::from(window.size.height) / 240.0).max(1.0);
    let air = linear_from_srgb(set.background.unwrap_or(PAPER));
    if let Some(d) = window.domain.filter(|_| set.domain) {
        let p = [[0.0, 0.0], [d[0], 0.0], [d[0], d[1]], [0.0, d[1]]].map(|p| window.place(&p));
        let walls: Vec<_> = (0..4).map(|k| [p[k], p[(k + 1) % 4]]).collect();
        fill(&mut canvas, &walls, &air, &air);
        strokes(&mut canvas, &walls, thick * 1.2, &linear_from_srgb(0x0055_5f69));
    }
    // The solids are drawn over the liquid, whose wetted vertices lie below the solids' surfaces.
    let mut sunk = frame.clone();
    window.dx.into_iter().for_each(|dx| wetted::sink::<2>(&mut sunk, &Depths::of_drawing(dx)));
    let outline = window.segments(&sunk.liquid);
    let [top, bottom, edge] = fill_and_edge_colors(set.liquid, [0x0062_b0e8, 0x0023_74bf, 0x0010_4b86]);
    fill(&mut canvas, &outline, &top, &bottom);
    strokes(&mut canvas, &outline, thick, &edge);
    let [top, bottom, edge] = fill_and_edge_colors(set.solids, [0x00c9_b49c, 0x00b3_9a80, 0x0070_5b46]);
    for solid in frame.solids.values() {
        let outline = window.segments(solid);
        fill(&mut canvas, &outline, &top, &bottom);
        strokes(&mut canvas, &outline, thick * 0.9, &edge);
        let places = shading.map_or_else(Vec::new, |shading| shading.places(solid));
        for (edge, [a, b]) in solid.edges.iter().zip(&outline).filter(|_| !places.is_empty()) {
            let place = 0.5 * edge.iter().map(|v| places[*v as usize]).sum::<f64>();
            let color = shading.map_or_else(V3::zeros, |shading| shading.shade.color(place));
            canvas.line(*a, *b, thick * 3.0, &color, |_, _, _| 1.0);
        }
    }
    if let Some(line) = frame.contact_line.as_ref().filter(|_| set.line) {
        for p in &line.positions {
            let at = window.place(p);
            canvas.line(at, at, thick * 5.4, &linear_from_srgb(PAPER), |_, _, _| 1.0);
            canvas.line(at, at, thick * 4.0, &linear_from_srgb(0x00d6_2718), |_, _, _| 1.0);
        }
    }
    labels(window, frame, &mut canvas);
    shading.iter().for_each(|shading| shading.legend(&mut canvas));
    canvas
}

/// Colours at the top, at the bottom and of the edge: shades of a given colour, or the defaults.
fn fill_and_edge_colors(given: Option<u32>, usual: [u32; 3]) -> [V3; 3] {
    given.map_or(usual.map(linear_from_srgb), |color| {
        [1.0, 0.75, 0.35].map(|part| linear_from_srgb(color) * part)
    })
}

/// Fills an outline with a vertical gradient from `top` to `bottom`.
fn fill(canvas: &mut Canvas, outline: &[[[f64; 2]; 2]], top: &V3, bottom: &V3) {
    let heights = || outline.iter().flatten().map(|p| p[1]);
    let (high, low) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    let cover = coverage(outline, canvas.width, canvas.height);
    for (i, c) in cover.into_iter().enumerate().filter(|(_, c)| *c > 0.0) {
        let (x, y) = (i % canvas.width, i / canvas.width);
        let t = ((y as f64 - high) / (low - high).max(1.0)).clamp(0.0, 1.0);
        canvas.blend(x, y, &(top * (1.0 - t) + bottom * t), c);
    }
}

/// Draws an outline. Overlapping segments are combined by their maximum, so that joints show no dots.
fn strokes(canvas: &mut Canvas, outline: &[[[f64; 2]; 2]], width: f64, color: &V3) {
    let mut mask = Canvas { pixels: vec![V3::zeros(); canvas.pixels.len()], ..*canvas };
    for [a, b] in outline {
        mask.cover(*a, *b, width);
    }
    for (i, m) in mask.pixels.iter().enumerate().filter(|(_, m)| m.x > 0.0) {
        canvas.blend(i % canvas.width, i / canvas.width, color, m.x);
    }
}

/// Draws the scale bar and the time.
fn labels(window: &Viewport, frame: &Frame, canvas: &mut Canvas) {
    let [w, h] = window.size();
    let (ink, height) = (linear_from_srgb(0x0033_3d47), (h / 28.0).max(8.0));
    let length = round_length(0.22 * w / window.scale);
    let (right, low) = (w - 1.2 * height, h - 0.9 * height);
    let left = right - length * window.scale;
    let thick = (height * 0.16).max(1.2);
    for [a, b] in
        [[[left, low], [right, low]], [[left, low - 4.0], [left, low]], [[right, low - 4.0], [right, low]]]
    {
        canvas.line(a, b, thick, &ink, |_, _, _| 1.0);
    }
    let text = label::quantity(length, 'm');
    let middle = 0.5 * (left + right - label::width(&text, height));
    label::draw(canvas, &text, [middle, low - 0.7 * height], height, &ink);
    if let Some(time) = frame.time {
        let text = format!("t = {}", label::quantity(time, 's'));
        label::draw(canvas, &text, [1.2 * height, 2.0 * height], height, &ink);
    }
}
