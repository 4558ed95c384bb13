//! Values of `--vary`.

use meniscus_scene::error::nearest;

/// Most values of one parameter.
const MAX_VALUES: usize = 10_000;

/// Significant digits of values between the ends of a range.
const DIGITS: usize = 12;

/// A parameter with its values, as texts of `--set`.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Vary {
    /// Path of the parameter.
    pub path: String,
    /// Its values.
    pub values: Vec<String>,
}

/// A range of values with a unit, for `--find`.
#[derive(Clone, Debug, PartialEq)]
pub struct Interval {
    /// Path of the parameter.
    pub path: String,
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Unit of both; empty for numbers.
    pub unit: String,
}

/// An error in a value: the message, and the help that says which values are accepted.
pub type ValueError = (String, String);

const RANGE_HELP: &str = "write PATH=A:B:N for N values from A to B, such as liquid.density=\"1:2:5 g/cm^3\", or a list PATH=V1,V2";
const INTERVAL_HELP: &str = "write PATH=A:B, such as solid.ball.density=\"1:4 g/cm^3\"";

impl Vary {
    /// Reads `PATH=A:B:N`, with the unit after any of the numbers, or `PATH=V1,V2,…`, where a unit of the last value is that of all.
    ///
    /// # Errors
    /// A message and a help that says which values are accepted.
    pub fn parse(text: &str) -> Result<Self, ValueError> {
        let (path, values) = split_path(text, RANGE_HELP)?;
        let items = split_list(values);
        if items.len() > 1 {
            return Ok(Self { path, values: with_common_unit(&items) });
        }
        let parts: Vec<&str> = values.split(':').map(str::trim).collect();
        let [from, to, count] = parts[..] else {
            return Err(wrong(format!("`{values}` is neither a range A:B:N nor a list"), RANGE_HELP));
        };
        let (ends, unit) = ends([from, to], count, RANGE_HELP)?;
        let count = split_number(count).map(|(n, _)| n).filter(|n| n.fract() == 0.0 && *n >= 2.0);
        let Some(count) = count.filter(|n| *n <= MAX_VALUES as f64).map(|n| n as usize) else {
            let message = format!("`{}` is not a number of values from 2 to {MAX_VALUES}", parts[2]);
            return Err(wrong(message, RANGE_HELP));
        };
        let at = |k: usize| ends[0] + (ends[1] - ends[0]) * k as f64 / (count - 1) as f64;
        Ok(Self { path, values: (0..count).map(|k| value_text(at(k), &unit)).collect() })
    }
}

impl Interval {
    /// Reads `PATH=A:B`, with the unit after any of the numbers.
    ///
    /// # Errors
    /// [`ValueError`].
    pub fn parse(text: &str) -> Result<Self, ValueError> {
        let (path, values) = split_path(text, INTERVAL_HELP)?;
        let parts: Vec<&str> = values.split(':').map(str::trim).collect();
        let [from, to] = parts[..] else {
            return Err(wrong(format!("`{values}` is not a range A:B"), INTERVAL_HELP));
        };
        let ([from, to], unit) = ends([from, to], "", INTERVAL_HELP)?;
        Ok(Self { path, from, to, unit })
    }

    /// A value with the unit.
    pub fn text(&self, value: f64) -> String {
        value_text(value, &self.unit)
    }
}

fn wrong(message: String, help: &str) -> ValueError {
    (message, help.to_owned())
}

fn split_path<'a>(text: &'a str, help: &str) -> Result<(String, &'a str), ValueError> {
    let parts = text.split_once('=').map(|(path, values)| (path.trim(), values.trim()));
    let found = parts.filter(|(path, values)| !path.is_empty() && !values.is_empty());
    let (path, values) =
        found.ok_or_else(|| wrong(format!("`{text}` is not of the form PATH=VALUES"), help))?;
    Ok((path.to_owned(), values))
}

/// The numbers at the ends of a range, and their unit, which stands after one of them or after the number of values.
fn ends(texts: [&str; 2], count: &str, help: &str) -> Result<([f64; 2], String), ValueError> {
    let [(from, first), (to, second)] = [end(texts[0], help)?, end(texts[1], help)?];
    let last = split_number(count).map_or("", |(_, unit)| unit);
    let units: Vec<&str> = [first, second, last].into_iter().filter(|unit| !unit.is_empty()).collect();
    let unit = units.last().copied().unwrap_or_default();
    if units.iter().any(|other| *other != unit) {
        let message = format!("the ends of `{}:{}` have different units", texts[0], texts[1]);
        return Err(wrong(message, "write both in the same unit"));
    }
    if from == to {
        return Err(wrong(format!("`{}` and `{}` are the same value", texts[0], texts[1]), help));
    }
    Ok(([from, to], unit.to_owned()))
}

fn end<'a>(text: &'a str, help: &str) -> Result<(f64, &'a str), ValueError> {
    split_number(text).ok_or_else(|| wrong(format!("`{text}` does not start with a number"), help))
}

/// A number with its unit, in at most [`DIGITS`] digits.
pub fn value_text(value: f64, unit: &str) -> String {
    let rounded = rounded(value);
    if unit.is_empty() { format!("{rounded}") } else { format!("{rounded} {unit}") }
}

/// A number with [`DIGITS`] significant digits.
pub fn rounded(value: f64) -> f64 {
    rounded_to(value, DIGITS)
}

/// A number with so many significant digits.
pub fn rounded_to(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// A number at the start of a text, and what follows it.
pub fn split_number(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8()).take(40);
    let is_number = |end: &usize| {
        let start = &text[..*end];
        start.ends_with(|c: char| c.is_ascii_digit() || c == '.')
            && start.parse::<f64>().is_ok_and(f64::is_finite)
    };
    let end = ends.filter(is_number).last()?;
    Some((text[..end].parse().ok()?, text[end..].trim()))
}

/// The items of a list: its parts between commas that are in no brackets and quotes.
fn split_list(text: &str) -> Vec<&str> {
    let (mut items, mut start, mut depth, mut quote) = (Vec::new(), 0, 0i32, None);
    for (at, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth -= 1,
            (None, ',') if depth == 0 => {
                items.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    items.push(text[start..].trim());
    items
}

/// Items; numbers without a unit get that of the last one.
fn with_common_unit(items: &[&str]) -> Vec<String> {
    let unit = items.last().and_then(|item| plain_number(item)).map_or("", |(_, unit)| unit);
    let text = |item: &&str| match plain_number(item) {
        Some((_, "")) if !unit.is_empty() => format!("{item} {unit}"),
        _ => (*item).to_owned(),
    };
    items.iter().map(text).collect()
}

/// A number that is in no brackets and quotes, and what follows it.
fn plain_number(item: &str) -> Option<(f64, &str)> {
    split_number(item).filter(|_| !item.contains(['"', '\'', '[', '{']))
}

/// The place of a check among the names of all: the whole name, or a key that only one has; `expect.` may stand before it.
///
/// # Errors
/// [`ValueError`] if no check has the name, or several.
pub fn find_check(names: &[String], wanted: &str) -> Result<usize, ValueError> {
    let wanted = wanted.trim().strip_prefix("expect.").unwrap_or(wanted.trim());
    let places = |matches: &dyn Fn(&str) -> bool| -> Vec<usize> {
        names.iter().enumerate().filter(|(_, name)| matches(name)).map(|(i, _)| i).collect()
    };
    let exact = places(&|name| name == wanted);
    let found = if exact.is_empty() { places(&|name| name.split('.').next() == Some(wanted)) } else { exact };
    let list = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    match found[..] {
        [one] => Ok(one),
        [] => {
            let near = nearest(wanted, names.iter().map(String::as_str));
            let near = near.map_or_else(String::new, |name| format!("did you mean `{name}`? "));
            let message = format!("[expect] of the scene has no check `{wanted}`");
            Err((message, format!("{near}checks of this scene: {list}")))
        }
        _ => Err((format!("several checks are named `{wanted}`"), format!("checks of this scene: {list}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Vary::parse(text).unwrap().values
    }

    #[test]
    fn ranges_and_lists() {
        let angles = ["60 deg", "90 deg", "120 deg"];
        for text in ["a.b=60:120:3 deg", "a.b=60deg:120deg:3", " a.b = 60 : 120 deg : 3", "a.b=60,90,120 deg"]
        {
            let vary = Vary::parse(text).unwrap();
            assert_eq!(
                (vary.path.as_str(), vary.values),
                ("a.b", angles.map(String::from).to_vec()),
                "{text}"
            );
        }
        assert_eq!(values("n=32:96:3"), ["32", "64", "96"]);
        assert_eq!(values("n=0:1:4"), ["0", "0.333333333333", "0.666666666667", "1"]);
        assert_eq!(values("n=0.1:0.3:3"), ["0.1", "0.2", "0.3"]);
        assert_eq!(values("n=-1:1e-3:2 m/s^2"), ["-1 m/s^2", "0.001 m/s^2"]);
        assert_eq!(values("n=1 mm,2 cm"), ["1 mm", "2 cm"]);
        assert_eq!(values("n=[1, 2],[3, 4]"), ["[1, 2]", "[3, 4]"]);
        assert_eq!(values("n=\"a, b\",'c'"), ["\"a, b\"", "'c'"]);
    }

    #[test]
    fn wrong_values_are_told() {
        for (text, part) in [
            ("a", "PATH=VALUES"),
            ("=1:2:3", "PATH=VALUES"),
            ("a=", "PATH=VALUES"),
            ("a=1", "neither a range"),
            ("a=1:2", "neither a range"),
            ("a=x:2:3", "`x` does not start with a number"),
            ("a=1:2:1", "number of values"),
            ("a=1:2:2.5", "number of values"),
            ("a=1:2:1e9", "number of values"),
            ("a=1 mm:2 cm:3", "different units"),
            ("a=1:1:3", "the same value"),
        ] {
            let (message, _) = Vary::parse(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        assert!(Interval::parse("a=1:2:3").unwrap_err().0.contains("not a range A:B"));
    }

    #[test]
    fn intervals_and_numbers() {
        let interval = Interval::parse("solid.ball.density=1:4 g/cm^3").unwrap();
        assert_eq!((interval.from, interval.to, interval.unit.as_str()), (1.0, 4.0, "g/cm^3"));
        assert_eq!(interval.text(1.0 / 3.0), "0.333333333333 g/cm^3");
        assert_eq!(split_number("5e4 mN/cm"), Some((5e4, "mN/cm")));
        assert_eq!(split_number("60deg"), Some((60.0, "deg")));
        assert_eq!((split_number("inf"), split_number("deg"), split_number("")), (None, None, None));
    }

    #[test]
    fn checks_are_found_by_name() {
        let names: Vec<String> = ["drops", "wetted.a", "wetted.b", "floats.ball"].map(String::from).to_vec();
        assert_eq!(find_check(&names, "expect.floats"), Ok(3));
        assert_eq!(find_check(&names, "wetted.b"), Ok(2));
        assert!(find_check(&names, "wetted").unwrap_err().0.contains("several"));
        let (message, help) = find_check(&names, "drop").unwrap_err();
        assert!(message.contains("`drop`") && help.contains("did you mean `drops`?"), "{message} {help}");
    }
}
