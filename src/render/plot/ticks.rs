/// Round numbers that span a range: the steps are 1, 2 or 5 times a power of ten.
pub fn nice(low: f64, high: f64, about: usize) -> Vec<f64> {
    let span = high - low;
    if !span.is_finite() || span <= 0.0 {
        return vec![low];
    }
    let rough = span / about.max(1) as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * power).find(|s| *s >= rough * 0.999);
    let step = step.unwrap_or(power * 10.0);
    let first = (low / step - 1e-6).ceil() as i64;
    let last = (high / step + 1e-6).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

/// Ticks of a logarithmic axis (values, not their logarithms): powers of ten, and 2 and 5 times them where few
/// powers fit.
pub fn decades(low: f64, high: f64) -> Vec<f64> {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let every = ((last - first) / 8 + 1).max(1);
    let factors: &[f64] = if last - first <= 3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let powers = (first..=last).filter(|p| (p - first) % every == 0).map(|p| 10f64.powi(p));
    let ticks = powers.flat_map(|p| factors.iter().map(move |f| f * p));
    ticks.filter(|t| (low * 0.999..=high * 1.001).contains(t)).collect()
}

/// A tick's text with as many digits as its neighbours need.
pub fn text(value: f64, step: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{value:.0e}");
    }
    let digits = (-(step.abs().max(1e-12)).log10() + 1e-9).ceil().clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') { "0".into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        assert_eq!(nice(0.0, 1.0, 5), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert_eq!(nice(0.0, 30.0, 6), [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0]);
        assert_eq!(nice(2.0, 2.0, 5), [2.0]);
        assert_eq!(decades(0.02, 3.0), [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]);
        assert_eq!(text(0.6000000000000001, 0.2), "0.6");
        assert_eq!(text(25.0, 5.0), "25");
        assert_eq!(text(0.0, 0.2), "0");
    }
}
