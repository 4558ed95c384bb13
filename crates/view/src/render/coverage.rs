//! Antialiased fill of outlines in the plane.

use rayon::prelude::*;

/// Scan lines per pixel row.
const SCANLINES_PER_PIXEL: usize = 16;

/// The share of each pixel inside an outline (even-odd rule). Segments are in pixels, y down.
pub(crate) fn coverage(segments: &[[[f64; 2]; 2]], width: usize, height: usize) -> Vec<f64> {
    let mut rows: Vec<Vec<u32>> = vec![Vec::new(); height];
    for (i, s) in segments.iter().enumerate() {
        let (low, high) = (s[0][1].min(s[1][1]), s[0][1].max(s[1][1]));
        if high >= 0.0 && low < height as f64 {
            let last = (high as usize).min(height - 1);
            rows[low.max(0.0) as usize..=last].iter_mut().for_each(|r| r.push(i as u32));
        }
    }
    let mut cover = vec![0.0; width * height];
    cover.par_chunks_mut(width.max(1)).zip(rows).enumerate().for_each(|(y, (pixels, own))| {
        let mut cuts = Vec::new();
        for k in 0..SCANLINES_PER_PIXEL {
            let line = y as f64 + (k as f64 + 0.5) / SCANLINES_PER_PIXEL as f64;
            cuts.clear();
            cuts.extend(own.iter().filter_map(|&i| scanline_crossing(&segments[i as usize], line)));
            cuts.sort_by(f64::total_cmp);
            cuts.chunks_exact(2)
                .for_each(|pair| add_span(pixels, pair[0], pair[1], 1.0 / SCANLINES_PER_PIXEL as f64));
        }
    });
    cover
}

/// Crossing of a segment with a horizontal line. The upper end is included, the lower is not.
fn scanline_crossing([a, b]: &[[f64; 2]; 2], y: f64) -> Option<f64> {
    if (a[1] <= y) == (b[1] <= y) {
        return None;
    }
    Some(a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1])))
}

/// Adds `weight` times the covered share to the pixels between two positions in a row.
fn add_span(pixels: &mut [f64], from: f64, to: f64, weight: f64) {
    let end = pixels.len() as f64;
    let (from, to) = (from.clamp(0.0, end), to.clamp(0.0, end));
    if to <= from {
        return;
    }
    let (first, last) = (from as usize, (to as usize).min(pixels.len() - 1));
    if first == last {
        pixels[first] += (to - from) * weight;
        return;
    }
    pixels[first] += (first as f64 + 1.0 - from) * weight;
    pixels[first + 1..last].iter_mut().for_each(|p| *p += weight);
    pixels[last] += (to - last as f64) * weight;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disc_with_a_hole_has_its_area() {
        let circle = |r: f64, turn: f64| -> Vec<[[f64; 2]; 2]> {
            let at = |k: usize| {
                let angle = turn * k as f64 * std::f64::consts::TAU / 400.0;
                [50.3 + r * angle.cos(), 47.9 + r * angle.sin()]
            };
            (0..400).map(|k| [at(k), at(k + 1)]).collect()
        };
        let mut outline = circle(31.7, 1.0);
        outline.extend(circle(11.2, -1.0));
        let area: f64 = coverage(&outline, 100, 90).iter().sum();
        let exact = std::f64::consts::PI * (31.7 * 31.7 - 11.2 * 11.2);
        assert!((area / exact - 1.0).abs() < 1e-3, "{area} {exact}");
        assert!(coverage(&outline, 100, 90).iter().all(|&c| (-1e-9..=1.0 + 1e-9).contains(&c)));
    }

    #[test]
    fn outlines_beyond_the_picture_are_cut() {
        let p = [[-50.0, -50.0], [200.0, -50.0], [200.0, 200.0], [-50.0, 200.0]];
        let outline: Vec<_> = (0..4).map(|k| [p[k], p[(k + 1) % 4]]).collect();
        let cover = coverage(&outline, 20, 10);
        assert!(cover.iter().all(|&c| (c - 1.0).abs() < 1e-12));
    }
}
