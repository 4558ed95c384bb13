//! Values from the time series: bounds of its columns, growth of energy, and rates of oscillations.

use crate::file::{SeriesBound, SeriesValue};
use crate::output::time_series::TimeSeries;

/// Deviation of a tip's height from its mean, over the largest deviation, below which a crossing of the mean counts as noise. Chosen without
/// experiment.
const NOISE_FRACTION: f64 = 0.1;

/// The value of a column that is bounded; `None` where no row that counts has one.
pub fn bounded_value(series: &TimeSeries, bound: &SeriesBound) -> Option<f64> {
    let (time, column) = (series.column("time"), series.column(&bound.column));
    let [from, until] = [bound.from.unwrap_or(0.0), bound.until.unwrap_or(f64::INFINITY)];
    let rows = time.iter().zip(column).filter(|(t, value)| (from..=until).contains(*t) && !value.is_nan());
    let values: Vec<f64> = rows.map(|(_, value)| *value).collect();
    let (first, last) = (*values.first()?, *values.last()?);
    match bound.of {
        SeriesValue::End => Some(last),
        SeriesValue::Least => values.into_iter().reduce(f64::min),
        SeriesValue::Largest => values.into_iter().reduce(f64::max),
        SeriesValue::Change => Some(last - first),
        SeriesValue::Ratio => (first != 0.0).then(|| last / first),
    }
}

/// The words for a bounded value of a column.
pub fn quantity(bound: &SeriesBound) -> String {
    let of = match bound.of {
        SeriesValue::End => "at the end",
        SeriesValue::Least => "least value",
        SeriesValue::Largest => "largest value",
        SeriesValue::Change => "change",
        SeriesValue::Ratio => "ratio of the end to the start",
    };
    let from = bound.from.map_or(String::new(), |t| format!(" from {t} s"));
    let until = bound.until.map_or(String::new(), |t| format!(" until {t} s"));
    format!("{} ({of}{from}{until})", bound.column)
}

/// Largest rise of the total energy, with the energy that left through open sides, above its initial value, relative to the largest kind
/// of energy at the start.
pub fn energy_growth(series: &TimeSeries) -> Option<f64> {
    let names = ["kinetic_energy", "surface_energy", "elastic_energy", "potential_energy"];
    let kinds = names.map(|name| series.column(name));
    let left = ["outflow_kinetic_energy", "outflow_stored_energy"].map(|name| series.column(name));
    let left = |row: usize| left.iter().filter_map(|kind| kind.get(row)).sum::<f64>();
    let total = |row: usize| kinds.iter().map(|kind| kind[row]).sum::<f64>() + left(row);
    let rows = kinds.iter().map(|kind| kind.len()).min().filter(|&n| n > 0)?;
    let scale = kinds.iter().map(|kind| kind[0].abs()).fold(0.0, f64::max);
    let start = total(0);
    let growth = (0..rows).map(|row| total(row) - start).fold(0.0, f64::max);
    if scale > 0.0 { Some(growth / scale) } else { None }
}

/// Period of an oscillation, s: twice the mean distance of the maxima of the kinetic energy, of which each period has two. A maximum lies
/// midway between the crossings of half its height, which noise in a few steps does not move. None with fewer than two maxima.
pub fn period(series: &TimeSeries) -> Option<f64> {
    let (time, energy) = (series.column("time"), series.column("kinetic_energy"));
    let peaks = peaks(time, energy);
    let (first, last) = (peaks.first()?, peaks.last()?);
    let gaps = peaks.len().checked_sub(1).filter(|&n| n > 0)?;
    Some(2.0 * (last - first) / gaps as f64)
}

/// Times of the maxima on both sides of which the curve falls below half of them.
fn peaks(time: &[f64], curve: &[f64]) -> Vec<f64> {
    let mut times = Vec::new();
    let mut start = 0;
    while let Some((top, end)) = next_peak(curve, start) {
        let half = 0.5 * curve[top];
        let rise = (start..top).rev().find(|&i| curve[i] < half);
        if let Some(rise) = rise {
            let before = crossing(time, curve, rise, half);
            let after = crossing(time, curve, end - 1, half);
            times.push(0.5 * (before + after));
        }
        start = end;
    }
    times
}

/// The largest value from `start` on before the curve falls below half of it, and the index where it does so. It must be twice the
/// smallest value before it, so a curve that only falls from the start has no peak.
fn next_peak(curve: &[f64], start: usize) -> Option<(usize, usize)> {
    let (mut valley, mut top) = (start, start);
    for i in start..curve.len() {
        let risen = curve[top] > 2.0 * curve[valley];
        if risen && curve[i] < 0.5 * curve[top] {
            return Some((top, i));
        }
        if !risen && curve[i] <= curve[valley] {
            (valley, top) = (i, i);
        } else if curve[i] > curve[top] {
            top = i;
        }
    }
    None
}

/// Period of the height of a solid's tip, s: the mean time between upward crossings of its mean, from below [`NOISE_FRACTION`] of the
/// largest deviation to above it. None with fewer than two crossings.
pub fn tip_period(series: &TimeSeries, solid: &str, dimension: usize) -> Option<f64> {
    let axis = if dimension == 2 { "y" } else { "z" };
    let (time, height) = (series.column("time"), series.column(&format!("tip_{solid}_{axis}")));
    let rows = time.len().min(height.len());
    let span = time.get(rows.checked_sub(1)?)? - time[0];
    let area = |i: usize| 0.5 * (height[i] + height[i + 1]) * (time[i + 1] - time[i]);
    let mean = (0..rows - 1).map(area).sum::<f64>() / span;
    let swing = height[..rows].iter().map(|h| (h - mean).abs()).fold(0.0, f64::max);
    let noise = NOISE_FRACTION * swing;
    let (mut crossings, mut below, mut at) = (Vec::new(), false, 0);
    for (i, &h) in height[..rows].iter().enumerate() {
        below |= h < mean - noise;
        if below && h <= mean {
            at = i;
        }
        if below && h > mean + noise {
            crossings.push(crossing(time, height, at, mean));
            below = false;
        }
    }
    let gaps = crossings.len().checked_sub(1).filter(|&n| n > 0)?;
    Some((crossings[gaps] - crossings[0]) / gaps as f64)
}

/// The time between rows `i` and `i + 1` at which the curve takes the value `level`.
fn crossing(time: &[f64], curve: &[f64], i: usize, level: f64) -> f64 {
    let fraction = (level - curve[i]) / (curve[i + 1] - curve[i]);
    time[i] + fraction.clamp(0.0, 1.0) * (time[i + 1] - time[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn damped(decay: f64, noise: f64) -> TimeSeries {
        let mut text = String::from("time,kinetic_energy\n");
        let mut random = 1u64;
        for i in 0..400 {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let t = f64::from(i) * 0.01 + 1e-9 * (random >> 40) as f64;
            let jitter = 1.0 + noise * ((random >> 33) as f64 / 2f64.powi(31) - 0.5);
            text += &format!("{t},{}\n", (-2.0 * decay * t).exp() * (2.0 * t * 2.5).sin().powi(2) * jitter);
        }
        TimeSeries::parse(&text)
    }

    #[test]
    fn period_from_kinetic_energy() {
        let expected = 2.0 * std::f64::consts::PI / 5.0;
        let measured = period(&damped(0.0, 0.0)).unwrap();
        assert!((measured / expected - 1.0).abs() < 1e-3, "{measured} {expected}");
        let measured = period(&damped(0.1, 0.02)).unwrap();
        assert!((measured / expected - 1.0).abs() < 5e-3, "{measured} {expected}");
        assert_eq!(period(&TimeSeries::default()), None);
    }

    #[test]
    fn an_impact_is_no_peak() {
        let mut text = String::from("time,kinetic_energy\n");
        for i in 0..200 {
            let t = f64::from(i) * 0.01;
            let impact = if i < 20 { 5.0 + t } else { 0.0 };
            text += &format!("{t},{}\n", impact + (5.0 * t).sin().powi(2));
        }
        let measured = period(&TimeSeries::parse(&text));
        let expected = 0.4 * std::f64::consts::PI;
        // With 60 samples per maximum, the midpoints of its flanks are off by less than a sample.
        assert!(measured.is_some_and(|m| (m / expected - 1.0).abs() < 5e-3), "{measured:?}");
    }

    #[test]
    fn a_tip_swings_about_its_mean() {
        let mut text = String::from("time,tip_beam_z\n");
        for i in 0..500 {
            let t = f64::from(i) * 1e-4;
            let height = 0.03 - 1e-4 * (-20.0 * t).exp() * (400.0 * t).sin() + 1e-6 * (9e4 * t).sin();
            text += &format!("{t},{height}\n");
        }
        let series = TimeSeries::parse(&text);
        let measured = tip_period(&series, "beam", 3).unwrap();
        let expected = 2.0 * std::f64::consts::PI / 400.0;
        assert!((measured / expected - 1.0).abs() < 5e-3, "{measured} {expected}");
        assert_eq!(tip_period(&series, "leaf", 3), None);
        assert_eq!(tip_period(&TimeSeries::default(), "beam", 3), None);
    }

    #[test]
    fn energy_growth_is_relative() {
        let table = TimeSeries::parse(
            "kinetic_energy,surface_energy,elastic_energy,potential_energy\n0,2,0,0\n1,1.5,0,0\n0,1,1.2,0\n",
        );
        assert_eq!(energy_growth(&table), Some(0.25));
        let bent = TimeSeries::parse(
            "kinetic_energy,surface_energy,elastic_energy,potential_energy\n0,2,0,0\n0,1.5,1.5,0\n",
        );
        assert_eq!(energy_growth(&bent), Some(0.5));
        let drained = TimeSeries::parse(
            "kinetic_energy,surface_energy,elastic_energy,potential_energy,outflow_kinetic_energy,outflow_stored_energy\n\
             0,2,0,0,0,0\n0,1,0,0,1,0.5\n",
        );
        assert_eq!(energy_growth(&drained), Some(0.25));
    }

    #[test]
    fn values_of_a_column_in_a_time_window() {
        let series = TimeSeries::parse("time,line_loops_cow\n0,\n1,2\n2,5\n3,1\n4,\n");
        let bound = |of, from, until| SeriesBound {
            column: "line_loops_cow".to_owned(),
            of,
            from,
            until,
            min: None,
            max: Some(1.0),
        };
        let value = |of| bounded_value(&series, &bound(of, None, None));
        let all = [SeriesValue::End, SeriesValue::Least, SeriesValue::Largest].map(value);
        assert_eq!(all, [Some(1.0), Some(1.0), Some(5.0)]);
        assert_eq!([SeriesValue::Change, SeriesValue::Ratio].map(value), [Some(-1.0), Some(0.5)]);
        assert_eq!(bounded_value(&series, &bound(SeriesValue::End, None, Some(2.0))), Some(5.0));
        assert_eq!(bounded_value(&series, &bound(SeriesValue::Largest, Some(2.5), None)), Some(1.0));
        assert_eq!(bounded_value(&series, &bound(SeriesValue::End, Some(4.0), None)), None);
        let words = quantity(&bound(SeriesValue::Largest, Some(2.5), None));
        assert_eq!(words, "line_loops_cow (largest value from 2.5 s)");
    }
}
