//! Parses values with units into SI.
//!
//! The number is shifted by the unit's power of ten in its decimal text, so `"72.8 mN/m"` is exactly the double nearest to 0.0728.

use std::f64::consts::PI;

/// Physical dimension of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Metres, or multiples of the cell size (`dx`).
    Length,
    /// Seconds.
    Time,
    /// Metres per second.
    Speed,
    /// Kilograms per cubic metre.
    Density,
    /// Square metres per second.
    KinematicViscosity,
    /// Pascal seconds.
    DynamicViscosity,
    /// Metres per second squared.
    Acceleration,
    /// Newtons per metre: surface tension and spring stiffness.
    Tension,
    /// Pascals.
    Pressure,
    /// Kilograms.
    Mass,
    /// Radians.
    Angle,
    /// Radians per second.
    AngularVelocity,
    /// Hertz.
    Frequency,
    /// Joules.
    Energy,
    /// Newtons.
    Force,
}

/// Exponents of kg, m, s, rad, dx.
type Exponents = [i32; 5];

/// Name with article, SI unit, accepted units shown to the user, exponents.
type Row = (Dimension, &'static str, &'static str, &'static str, Exponents);

const DIMENSIONS: [Row; 15] = [
    (Dimension::Length, "a length", "m", "m, cm, mm, um, dx (cells)", [0, 1, 0, 0, 0]),
    (Dimension::Time, "a time", "s", "s, ms, us, min", [0, 0, 1, 0, 0]),
    (Dimension::Speed, "a speed", "m/s", "m/s, cm/s, mm/s", [0, 1, -1, 0, 0]),
    (Dimension::Density, "a density", "kg/m^3", "kg/m^3, g/cm^3", [1, -3, 0, 0, 0]),
    (
        Dimension::KinematicViscosity,
        "a kinematic viscosity",
        "m^2/s",
        "m^2/s, cm^2/s, mm^2/s, cSt",
        [0, 2, -1, 0, 0],
    ),
    (Dimension::DynamicViscosity, "a dynamic viscosity", "Pa s", "Pa s, mPa s, cP", [1, -1, -1, 0, 0]),
    (Dimension::Acceleration, "an acceleration", "m/s^2", "m/s^2, cm/s^2", [0, 1, -2, 0, 0]),
    (Dimension::Tension, "a tension", "N/m", "N/m, mN/m, mN/cm, dyn/cm", [1, 0, -2, 0, 0]),
    (Dimension::Pressure, "a pressure", "Pa", "Pa, kPa, MPa, GPa, bar", [1, -1, -2, 0, 0]),
    (Dimension::Mass, "a mass", "kg", "kg, g, mg", [1, 0, 0, 0, 0]),
    (Dimension::Angle, "an angle", "rad", "deg, rad", [0, 0, 0, 1, 0]),
    (Dimension::AngularVelocity, "an angular velocity", "rad/s", "rad/s, deg/s, rpm", [0, 0, -1, 1, 0]),
    (Dimension::Frequency, "a frequency", "Hz", "Hz, kHz, 1/s", [0, 0, -1, 0, 0]),
    (Dimension::Energy, "an energy", "J", "J, mJ, uJ, nJ", [1, 2, -2, 0, 0]),
    (Dimension::Force, "a force", "N", "N, mN, uN, dyn", [1, 1, -2, 0, 0]),
];

impl Dimension {
    fn row(self) -> &'static Row {
        &DIMENSIONS[self as usize]
    }

    /// Name with its article: `a length`.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// The SI unit: `m`.
    pub fn si(self) -> &'static str {
        self.row().2
    }

    /// The usual unit in scenes, for examples: `mm`.
    pub fn usual(self) -> &'static str {
        match self {
            Self::Length => "mm",
            Self::Time => "ms",
            Self::Angle => "deg",
            Self::AngularVelocity => "deg/s",
            Self::Density => "g/cm^3",
            Self::Tension => "mN/m",
            Self::Pressure => "kPa",
            Self::KinematicViscosity => "mm^2/s",
            Self::DynamicViscosity => "mPa s",
            other => other.si(),
        }
    }

    /// The usual units, separated by commas.
    pub fn accepted(self) -> &'static str {
        self.row().3
    }

    /// Help text, in one sentence.
    pub fn advice(self) -> String {
        format!("{} is written as text with a unit, one of: {}", self.name(), self.accepted())
    }
}

/// A number with four digits and a fitting SI prefix: `1.612 mm`. Only for units of power one.
pub fn format_si(x: f64, unit: &str) -> String {
    const STEPS: [(f64, &str); 7] =
        [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "u"), (1e-9, "n")];
    let fits = STEPS.into_iter().find(|(scale, _)| x.abs() >= scale * 0.999_95);
    let (scale, prefix) = if x == 0.0 { (1.0, "") } else { fits.unwrap_or(STEPS[6]) };
    format!("{} {prefix}{unit}", format_four_digits(x / scale))
}

/// A number with at least four digits, without trailing zeros.
pub(crate) fn format_four_digits(x: f64) -> String {
    let whole = x.abs().max(1.0).log10().floor() as usize;
    let digits = 3usize.saturating_sub(whole);
    let text = format!("{x:.digits$}");
    let cut = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if cut == "-0" { "0".into() } else { cut.into() }
}

/// An area (2D) or a volume (3D) in SI as text: `3.142 mm^2`.
pub fn format_volume(x: f64, dimension: usize) -> String {
    let size = x.abs().powf(1.0 / dimension as f64);
    let (step, unit): (f64, &str) = match size {
        s if s >= 1.0 => (1.0, "m"),
        s if s >= 0.1 => (1e-2, "cm"),
        s if s >= 1e-4 => (1e-3, "mm"),
        _ => (1e-6, "um"),
    };
    format!("{} {unit}^{dimension}", format_four_digits(x / step.powi(dimension as i32)))
}

/// Why a value was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitError {
    /// What was found.
    pub message: String,
    /// What is accepted.
    pub help: String,
}

/// A number in SI, or in multiples of the cell size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parsed {
    /// The number: SI, or cells if `in_cells`.
    pub value: f64,
    /// Whether the unit was `dx`.
    pub in_cells: bool,
}

/// Symbol, factor that is not a power of ten, power of ten, exponents, whether it takes prefixes.
type Atom = (&'static str, f64, i32, Exponents, bool);

const ATOMS: [Atom; 20] = [
    ("m", 1.0, 0, [0, 1, 0, 0, 0], true),
    ("s", 1.0, 0, [0, 0, 1, 0, 0], true),
    ("g", 1.0, -3, [1, 0, 0, 0, 0], true),
    ("N", 1.0, 0, [1, 1, -2, 0, 0], true),
    ("Pa", 1.0, 0, [1, -1, -2, 0, 0], true),
    ("J", 1.0, 0, [1, 2, -2, 0, 0], true),
    ("Hz", 1.0, 0, [0, 0, -1, 0, 0], true),
    ("rad", 1.0, 0, [0, 0, 0, 1, 0], true),
    ("deg", PI / 180.0, 0, [0, 0, 0, 1, 0], false),
    ("min", 60.0, 0, [0, 0, 1, 0, 0], false),
    ("h", 3600.0, 0, [0, 0, 1, 0, 0], false),
    ("dyn", 1.0, -5, [1, 1, -2, 0, 0], false),
    ("erg", 1.0, -7, [1, 2, -2, 0, 0], false),
    ("P", 1.0, -1, [1, -1, -1, 0, 0], true),
    ("St", 1.0, -4, [0, 2, -1, 0, 0], true),
    ("bar", 1.0, 5, [1, -1, -2, 0, 0], true),
    ("rpm", PI / 30.0, 0, [0, 0, -1, 1, 0], false),
    ("L", 1.0, -3, [0, 3, 0, 0, 0], true),
    ("dx", 1.0, 0, [0, 0, 0, 0, 1], false),
    ("1", 1.0, 0, [0, 0, 0, 0, 0], false),
];

const PREFIXES: [(char, i32); 9] =
    [('n', -9), ('u', -6), ('m', -3), ('c', -2), ('d', -1), ('h', 2), ('k', 3), ('M', 6), ('G', 9)];

/// A unit: factor, power of ten, exponents.
#[derive(Clone, Copy)]
struct Unit {
    factor: f64,
    ten: i32,
    exponents: Exponents,
}

/// Parses a value with a unit into SI.
///
/// # Errors
/// [`UnitError`] if there is no number, no unit, an unknown unit, one of another dimension, or a number that is not
/// finite.
pub fn parse(text: &str, dimension: Dimension) -> Result<Parsed, UnitError> {
    let fail = |message: String| UnitError { message, help: dimension.advice() };
    let shown = shorten(text);
    let Some((mantissa, exponent, rest)) = split_number(text.trim()) else {
        return Err(fail(format!("`{shown}` does not start with a number")));
    };
    let unit_text = normalise(rest);
    let unit = if unit_text.is_empty() {
        let zero = format!("{mantissa}e{exponent}").parse::<f64>().is_ok_and(|v| v == 0.0);
        if !zero {
            return Err(fail(format!("`{shown}` has no unit")));
        }
        Unit { factor: 1.0, ten: 0, exponents: dimension.row().4 }
    } else {
        parse_unit(&unit_text).map_err(|bad| fail(format!("unknown unit `{}`", shorten(&bad))))?
    };
    let in_cells = dimension == Dimension::Length && unit.exponents == [0, 0, 0, 0, 1];
    if unit.exponents != dimension.row().4 && !in_cells {
        let found = describe(unit.exponents);
        return Err(fail(format!("`{shown}` is {found}, but {} is wanted", dimension.name())));
    }
    let power = exponent.saturating_add(i64::from(unit.ten));
    let value = format!("{mantissa}e{power}").parse::<f64>().map_or(f64::NAN, |v| v * unit.factor);
    if !value.is_finite() {
        return Err(fail(format!("`{shown}` is too large a number")));
    }
    if value == 0.0 && mantissa.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        return Err(fail(format!("`{shown}` is too small a number")));
    }
    Ok(Parsed { value, in_cells })
}

/// At most 40 characters of a text, for messages.
fn shorten(text: &str) -> String {
    if text.chars().count() <= 40 { text.to_owned() } else { text.chars().take(39).chain(['…']).collect() }
}

/// Splits `-1.5e3 cm` into `-1.5`, 3 and ` cm`.
fn split_number(text: &str) -> Option<(&str, i64, &str)> {
    let b = text.as_bytes();
    let digits = |mut i: usize| {
        while b.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let first = usize::from(matches!(b.first(), Some(b'+' | b'-')));
    let whole = digits(first);
    let (end, count) = match b.get(whole) {
        Some(b'.') => (digits(whole + 1), digits(whole + 1) - first - 1),
        _ => (whole, whole - first),
    };
    if count == 0 {
        return None;
    }
    let mantissa = text.get(..end)?;
    if matches!(b.get(end), Some(b'e' | b'E')) {
        let sign = end + 1 + usize::from(matches!(b.get(end + 1), Some(b'+' | b'-')));
        let stop = digits(sign);
        if stop > sign {
            let exponent = text.get(end + 1..stop)?.parse::<i64>().unwrap_or(if b[end + 1] == b'-' {
                -1_000_000
            } else {
                1_000_000
            });
            return Some((mantissa, exponent.clamp(-1_000_000, 1_000_000), text.get(stop..)?));
        }
    }
    Some((mantissa, 0, text.get(end..)?))
}

/// Replaces typographic variants in a unit by plain ones.
fn normalise(unit: &str) -> String {
    let mut out = String::new();
    for c in unit.trim().chars().take(200) {
        match c {
            'µ' | 'μ' => out.push('u'),
            '²' => out.push_str("^2"),
            '³' => out.push_str("^3"),
            '°' => out.push_str("deg"),
            '·' | '*' => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Parses products and quotients of atoms; the error is the part not understood.
fn parse_unit(text: &str) -> Result<Unit, String> {
    let mut unit = Unit { factor: 1.0, ten: 0, exponents: [0; 5] };
    for (i, part) in text.split('/').enumerate() {
        if part.trim().is_empty() {
            return Err(text.to_owned());
        }
        for (j, word) in part.split_whitespace().enumerate() {
            let (atom, power) = parse_power(word).ok_or_else(|| word.to_owned())?;
            let sign = if i > 0 && j == 0 { -power } else { power };
            unit.factor *= atom.factor.powi(sign);
            unit.ten += atom.ten * sign;
            for (e, a) in unit.exponents.iter_mut().zip(atom.exponents) {
                *e += a * sign;
            }
        }
    }
    Ok(unit)
}

/// `cm^2` or `cm2`.
fn parse_power(word: &str) -> Option<(Unit, i32)> {
    if word == "1" {
        return Some((parse_atom("1")?, 1));
    }
    let (symbol, power) = match word.split_once('^') {
        Some((s, p)) => (s, p.parse::<i32>().ok()?),
        None => match word.find(|c: char| c.is_ascii_digit() || c == '-') {
            Some(i) if i > 0 => (&word[..i], word[i..].parse::<i32>().ok()?),
            _ => (word, 1),
        },
    };
    ((-9..=9).contains(&power)).then_some((parse_atom(symbol)?, power))
}

fn parse_atom(symbol: &str) -> Option<Unit> {
    let find = |s: &str| ATOMS.iter().find(|a| a.0 == s);
    if let Some(a) = find(symbol) {
        return Some(Unit { factor: a.1, ten: a.2, exponents: a.3 });
    }
    let first = symbol.chars().next()?;
    let prefix = PREFIXES.iter().find(|p| p.0 == first)?;
    let a = find(&symbol[first.len_utf8()..])?;
    a.4.then_some(Unit { factor: a.1, ten: a.2 + prefix.1, exponents: a.3 })
}

/// The name of the quantity with these exponents.
fn describe(exponents: Exponents) -> String {
    if exponents == [0, 0, 0, 0, 1] {
        return "a number of cells".to_owned();
    }
    if let Some(row) = DIMENSIONS.iter().find(|r| r.4 == exponents) {
        return row.1.to_owned();
    }
    let parts: Vec<String> = ["kg", "m", "s", "rad", "dx"]
        .iter()
        .zip(exponents)
        .filter(|(_, e)| *e != 0)
        .map(|(n, e)| if e == 1 { (*n).to_owned() } else { format!("{n}^{e}") })
        .collect();
    if parts.is_empty() { "a pure number".to_owned() } else { format!("in {}", parts.join(" ")) }
}

#[cfg(test)]
mod tests {
    use super::Dimension as D;
    use super::*;

    #[test]
    fn reads_units_exactly() {
        for (text, dimension, value) in [
            ("72.8 mN/m", D::Tension, 0.0728),
            ("1.2 mN/cm", D::Tension, 0.12),
            ("100 dyn/cm", D::Tension, 0.1),
            ("1 g/cm^3", D::Density, 1000.0),
            ("0.01 cm^2/s", D::KinematicViscosity, 1e-6),
            ("1 mm²/s", D::KinematicViscosity, 1e-6),
            ("500 cm/s", D::Speed, 5.0),
            ("10 kPa", D::Pressure, 1e4),
            ("0.3 Pa s", D::DynamicViscosity, 0.3),
            ("1 cP", D::DynamicViscosity, 1e-3),
            ("90 deg", D::Angle, PI / 2.0),
            ("2 min", D::Time, 120.0),
            ("5e4 mN/cm", D::Tension, 5000.0),
            ("-9.81 m/s^2", D::Acceleration, -9.81),
            ("7 um", D::Length, 7e-6),
            ("7µm", D::Length, 7e-6),
            ("0", D::Length, 0.0),
            ("30 1/s", D::Frequency, 30.0),
            ("60 rpm", D::AngularVelocity, 2.0 * PI),
        ] {
            let got = parse(text, dimension).unwrap_or_else(|e| panic!("{text}: {e:?}"));
            assert_eq!(got, Parsed { value, in_cells: false }, "{text}");
        }
        assert_eq!(parse("3 dx", D::Length).unwrap(), Parsed { value: 3.0, in_cells: true });
    }

    #[test]
    fn refuses_with_reason() {
        let m = |text, d| parse(text, d).unwrap_err().message;
        assert_eq!(m("1.5 furlong", D::Length), "unknown unit `furlong`");
        assert_eq!(m("5 cm", D::Density), "`5 cm` is a length, but a density is wanted");
        assert_eq!(m("3 dx", D::Time), "`3 dx` is a number of cells, but a time is wanted");
        assert_eq!(m("5", D::Length), "`5` has no unit");
        for bad in ["inf m", "nan m", "", "m", "--1 m", "1e m e", "1/m", "1 m/", "1 /", "1 m^99", "1 m^", "."]
        {
            assert!(parse(bad, D::Length).is_err(), "{bad}");
        }
        for bad in ["1e999 m", "1e99999999999999999999 m", "1e-999 m", "9e308 km"] {
            assert!(m(bad, D::Length).contains("too"), "{bad}");
        }
        assert!(parse("m", D::Time).unwrap_err().help.contains("ms, us, min"));
    }

    #[test]
    fn rows_are_in_order() {
        for (i, row) in DIMENSIONS.iter().enumerate() {
            assert_eq!(row.0 as usize, i);
            assert!(parse(&format!("1 {}", row.2), row.0).is_ok(), "{}", row.2);
            for unit in row.3.split(", ") {
                let unit = unit.trim_end_matches(" (cells)");
                assert!(parse(&format!("1 {unit}"), row.0).is_ok(), "{unit}");
            }
        }
    }
}
