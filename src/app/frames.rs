//! How smoothly the window runs while it works: how long frames take and how far apart they are.

use std::time::Instant;

/// Frame times of a run, milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// From the beginning of each frame to that of the next one.
    pub apart_ms: Vec<f32>,
    /// What each frame took of the window's thread.
    pub busy_ms: Vec<f32>,
}

impl FrameTimes {
    /// Median, 95th percentile and the largest of `times`; zeros when there are none.
    pub fn summary(times: &[f32]) -> [f32; 3] {
        let mut sorted = times.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |share: f32| sorted.get(((sorted.len() as f32 - 1.0) * share).round() as usize).copied();
        [at(0.5), at(0.95), at(1.0)].map(Option::unwrap_or_default)
    }
}

impl std::fmt::Display for FrameTimes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let frames = self.apart_ms.len();
        let [apart, apart_95, gap] = Self::summary(&self.apart_ms);
        let [busy, busy_95, longest] = Self::summary(&self.busy_ms);
        write!(
            f,
            "{frames} frames while people were made: {apart:.0} ms apart (median), {apart_95:.0} ms (95 %), longest \
             gap {gap:.0} ms; the window's thread was busy for {busy:.0} ms a frame (median), {busy_95:.0} ms (95 %), \
             {longest:.0} ms at most"
        )
    }
}

/// Takes the times of one run.
#[derive(Debug, Default)]
pub struct FrameClock {
    began: Option<Instant>,
    times: FrameTimes,
}

impl FrameClock {
    /// A frame begins; it counts while there is `work`.
    pub fn begin(&mut self, work: bool) {
        let now = Instant::now();
        if let Some(before) = self.began.filter(|_| work) {
            self.times.apart_ms.push((now - before).as_secs_f32() * 1e3);
        }
        self.began = Some(now);
    }

    /// The same frame ends.
    pub fn end(&mut self, work: bool) {
        if let Some(began) = self.began.filter(|_| work) {
            self.times.busy_ms.push(began.elapsed().as_secs_f32() * 1e3);
        }
    }

    /// What was taken.
    pub fn times(&self) -> &FrameTimes {
        &self.times
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_is_median_95th_percentile_and_largest() {
        let times: Vec<f32> = (0..=100).rev().map(|i| i as f32).collect();
        assert_eq!(FrameTimes::summary(&times), [50.0, 95.0, 100.0]);
        assert_eq!(FrameTimes::summary(&[]), [0.0; 3]);
    }
}
