//! Short labels (numbers and units) drawn as strokes.

use super::image::Canvas;
use crate::folder::V3;

/// Strokes of a character on a grid 4 wide and 6 high: points as digit pairs, strokes separated by spaces. The baseline is at
/// 0; y points up.
fn strokes(sign: char) -> &'static str {
    match sign {
        '0' => "10304145361605 0110 0105",
        '1' => "052620 0040",
        '2' => "05163645440040",
        '3' => "0516364544334241301001 2333",
        '4' => "30360242",
        '5' => "4606033342413010 1001",
        '6' => "45361605011030414233 3303 0302",
        '7' => "064610",
        '8' => "13040516364544331302011030414233",
        '9' => "01103041453616050413 1343",
        '.' => "1010",
        '-' => "0343",
        '=' => "0242 0444",
        's' => "43341403 03123241 41301001",
        't' => "1611203041 0434",
        'c' => "4334140301103041",
        'k' => "0006 0144 1240",
        'n' => "0004 03143443 4340",
        'a' => "043443401001022242",
        'd' => "4640 4314040130 4130",
        'e' => "024243341403011030",
        'h' => "0600 03143443 4340",
        'i' => "1410 1516",
        'l' => "1610",
        'r' => "0400 021434",
        '_' => "0040",
        'u' => "040110304144 4440",
        _ => "",
    }
}

/// The polylines of a character.
fn polylines(sign: char) -> Vec<Vec<[f64; 2]>> {
    if sign == 'm' {
        let arch = |x: f64| vec![[x, 3.0], [x + 0.6, 4.0], [x + 1.4, 4.0], [x + 2.0, 3.0], [x + 2.0, 0.0]];
        return vec![vec![[0.0, 0.0], [0.0, 4.0]], arch(0.0), arch(2.0)];
    }
    if sign == 'p' {
        return vec![
            vec![[0.0, -2.0], [0.0, 4.0]],
            vec![[0.0, 4.0], [3.0, 4.0], [4.0, 3.0], [4.0, 1.0], [3.0, 0.0], [0.0, 0.0]],
        ];
    }
    let mut lines = Vec::new();
    for word in strokes(sign).split(' ') {
        let digits: Vec<f64> = word.chars().filter_map(|c| c.to_digit(10)).map(f64::from).collect();
        let line: Vec<[f64; 2]> = digits.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

/// Width of a text of the given height.
pub(crate) fn width(text: &str, height: f64) -> f64 {
    text.chars().map(advance).sum::<f64>() * height / 6.0
}

fn advance(sign: char) -> f64 {
    match sign {
        ' ' => 3.0,
        '.' => 3.4,
        _ => 5.8,
    }
}

/// Draws a text with its lower left corner at `at`.
pub(crate) fn draw(canvas: &mut Canvas, text: &str, at: [f64; 2], height: f64, color: &V3) {
    let unit = height / 6.0;
    let mut x = at[0];
    for sign in text.chars() {
        for line in polylines(sign) {
            for pair in line.windows(2) {
                let place = |p: [f64; 2]| [x + p[0] * unit, at[1] - p[1] * unit];
                canvas.line(place(pair[0]), place(pair[1]), (height * 0.13).max(1.1), color, |_, _, _| 1.0);
            }
        }
        x += advance(sign) * unit;
    }
}

/// A length or a time with a suitable SI prefix, such as `12.5 mm`.
pub(crate) fn quantity(x: f64, unit: char) -> String {
    const PREFIXES: [(f64, &str); 5] = [(1e-9, "n"), (1e-6, "u"), (1e-3, "m"), (1.0, ""), (1e3, "k")];
    if unit == 'm' && (0.01..1.0).contains(&x.abs()) {
        return format!("{} cm", round(x * 100.0));
    }
    let fits = PREFIXES.iter().rev().find(|(scale, _)| x.abs() >= *scale * 0.9995);
    let (scale, prefix) = fits.copied().unwrap_or((1.0, ""));
    format!("{} {prefix}{unit}", round(x / scale))
}

/// A number, with its unit if it has one.
pub(crate) fn value(x: f64, unit: Option<char>) -> String {
    match unit {
        Some(_) if x == 0.0 => "0".into(),
        Some(unit) => quantity(x, unit),
        None => round(x),
    }
}

/// A number with at most four significant digits.
fn round(x: f64) -> String {
    let decimals = if x.abs() >= 99.95 { 1 } else { 2 };
    let text = format!("{x:.decimals$}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_short() {
        assert_eq!(quantity(0.0125, 's'), "12.5 ms");
        assert_eq!(quantity(0.05, 'm'), "5 cm");
        assert_eq!(quantity(0.002, 'm'), "2 mm");
        assert_eq!(quantity(0.0, 's'), "0 s");
        assert_eq!(quantity(0.2, 's'), "200 ms");
    }

    #[test]
    fn all_signs_have_strokes() {
        for sign in "0123456789.-=mstcknphi_strain displacement".chars().filter(|c| *c != ' ') {
            assert!(!polylines(sign).is_empty(), "{sign}");
        }
    }
}
