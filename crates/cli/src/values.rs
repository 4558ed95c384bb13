//! Values on the command line: times, ranges of frames, sizes of pictures, colours, formats.

use meniscus_scene::output::frame::Format;
use std::time::Duration;

/// `10:20` → (10, 20); an open end stands for the first or last frame.
pub fn frame_range(text: &str) -> Result<(u64, u64), String> {
    let (a, b) = text.split_once(':').ok_or("expected first:last, such as 10:20")?;
    let number = |s: &str, open: u64| {
        if s.is_empty() {
            Ok(open)
        } else {
            s.parse::<u64>().map_err(|_| format!("`{s}` is not a frame number"))
        }
    };
    let (a, b) = (number(a, 0)?, number(b, u64::MAX)?);
    if a > b { Err(format!("frame {a} comes after frame {b}")) } else { Ok((a, b)) }
}

/// `55m`, `90s`, `1h30m`, `90` (seconds).
pub fn wall_time(text: &str) -> Result<Duration, String> {
    let help = "expected a time such as 55m, 90s or 1h30m";
    let (mut seconds, mut number) = (0.0, String::new());
    for c in text.chars().filter(|c| !c.is_whitespace()).chain(['s']) {
        if c.is_ascii_digit() || c == '.' {
            number.push(c);
            continue;
        }
        let factor = match c {
            'd' => 86400.0,
            'h' => 3600.0,
            'm' => 60.0,
            's' => 1.0,
            _ => return Err(help.into()),
        };
        if !number.is_empty() {
            seconds += factor * number.parse::<f64>().map_err(|_| help)?;
            number.clear();
        }
    }
    Duration::try_from_secs_f64(seconds).ok().filter(|d| !d.is_zero()).ok_or_else(|| help.to_string())
}

/// `7` → (7, 7), otherwise as [`frame_range`].
pub fn picture_range(text: &str) -> Result<(u64, u64), String> {
    match text.parse::<u64>() {
        Ok(one) => Ok((one, one)),
        Err(_) if !text.contains(':') => {
            Err("expected a number, or first:last, such as 20 or 10:20".to_owned())
        }
        Err(_) => frame_range(text),
    }
}

/// `ff8000` or `#ff8000` → 0xff8000.
pub fn hex_color(text: &str) -> Result<u32, String> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let color = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6);
    color.ok_or_else(|| "expected six hexadecimal digits for red, green and blue, such as ff8000".to_owned())
}

/// `640x360` → (640, 360).
pub fn picture_size(text: &str) -> Result<(u32, u32), String> {
    let help = "expected width x height in pixels, such as 640x360";
    let (w, h) = text.split_once('x').ok_or(help)?;
    let side = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (16..=8192).contains(n)).ok_or(help);
    Ok((side(w)?, side(h)?))
}

/// `0.01,0,2e-3` → [0.01, 0.0, 0.002], a point in metres.
pub fn picture_target(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let point = numbers.filter(|n| n.iter().all(|x| x.is_finite())).and_then(|n| n.try_into().ok());
    point.ok_or_else(|| "expected three coordinates in metres, such as 0.01,0,0.002".to_owned())
}

/// A format to which stored frames can be converted.
pub fn export_format(text: &str) -> Result<Format, String> {
    let has_surfaces = |f: &Format| f.frame_writer().is_some_and(|writer| !writer.parts().fields);
    let instead = match Format::ALL.into_iter().find(|f| f.name() == text) {
        Some(Format::Page) => "`meniscus page DIR` makes the page of a run; accepted here".to_owned(),
        Some(_) => format!(
            "stored frames have no fields on the grid: run the scene with output.formats = [\"{text}\"]; accepted here"
        ),
        None => "accepted".to_owned(),
    };
    let found = Format::ALL.into_iter().filter(has_surfaces).find(|f| f.name() == text);
    let names: Vec<&str> = Format::ALL.into_iter().filter(has_surfaces).map(Format::name).collect();
    found.ok_or_else(|| format!("{instead}: {}", names.join(", ")))
}

/// A positive number.
pub fn scale_factor(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|s| s.is_finite() && *s > 0.0);
    number.ok_or_else(|| "expected a number above 0, such as 100 for centimetres".to_owned())
}

/// A relative tolerance.
pub fn relative_tolerance(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|x| *x >= 1e-6 && *x < 1.0);
    number.ok_or_else(|| "expected a number from 1e-6 to below 1, such as 0.02".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values() {
        assert_eq!(wall_time("55m"), Ok(Duration::from_secs(3300)));
        assert_eq!(wall_time("1h30m"), Ok(Duration::from_secs(5400)));
        assert_eq!(wall_time("0.5"), Ok(Duration::from_millis(500)));
        assert!(wall_time("soon").is_err() && wall_time("").is_err());
        assert_eq!(frame_range("3:7"), Ok((3, 7)));
        assert_eq!(frame_range(":7"), Ok((0, 7)));
        assert!(frame_range("7:3").is_err() && frame_range("7").is_err());
        assert_eq!(picture_size("640x360"), Ok((640, 360)));
        assert!(picture_size("0x360").is_err());
        assert_eq!(picture_target("0.01, -1, 2e-3"), Ok([0.01, -1.0, 0.002]));
        assert!(picture_target("0.01,0").is_err() && picture_target("0,0,inf").is_err());
        assert_eq!((picture_range("7"), picture_range("3:7")), (Ok((7, 7)), Ok((3, 7))));
        assert_eq!((scale_factor("1e3"), export_format("vtk")), (Ok(1000.0), Ok(Format::Vtk)));
        assert!(["0", "-1", "inf", "nan", "1 m"].iter().all(|s| scale_factor(s).is_err()));
        assert_eq!(export_format("usd"), Ok(Format::Usd));
        assert!(export_format("gltf").is_err_and(|e| e.contains("accepted: ply, vtk, obj, glb, usd, csv")));
        for fields in ["vti", "vdb"] {
            assert!(export_format(fields).is_err_and(|e| e.contains(&format!("[\"{fields}\"]"))));
        }
        assert!(["0", "1", "nan", "2 %"].iter().all(|s| relative_tolerance(s).is_err()));
        assert_eq!(hex_color("#ff8000"), Ok(0xff8000));
        assert!(hex_color("red").is_err() && hex_color("fff").is_err());
    }
}
