//! Times of the frames, and the step length that meets them.

/// Frames at exact times `0, interval, 2 interval, …` and at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    interval: f64,
    end: f64,
}

impl Schedule {
    /// Frames every `interval` seconds until `end`.
    pub fn new(interval: f64, end: f64) -> Self {
        Self { interval: if interval > 0.0 { interval.min(end) } else { end }, end }
    }

    /// End of the run, s.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// Number of the last frame.
    pub fn last_frame(&self) -> u64 {
        if self.interval > 0.0 { (self.end / self.interval - 1e-9).ceil().max(0.0) as u64 } else { 0 }
    }

    /// Time of a frame, s.
    pub fn time(&self, frame: u64) -> f64 {
        if frame >= self.last_frame() { self.end } else { frame as f64 * self.interval }
    }

    /// The longest step (s) allowed at `time` on the way to `frame`. The solver divides it into equal steps, so no very short step
    /// remains.
    pub fn longest_step(&self, time: f64, frame: u64) -> f64 {
        self.time(frame) - time
    }

    /// Whether `time` equals that of `frame` up to rounding.
    pub fn is_frame_time(&self, time: f64, frame: u64) -> bool {
        (time - self.time(frame)).abs() <= 1e-9 * self.interval
    }

    /// Whether `time` is that of `frame` or later.
    pub fn has_reached_frame(&self, time: f64, frame: u64) -> bool {
        time >= self.time(frame) - 1e-9 * self.interval
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_end_exactly() {
        let s = Schedule::new(0.01, 1.0);
        assert_eq!((s.last_frame(), s.time(100), s.time(50)), (100, 1.0, 0.5));
        let s = Schedule::new(0.3, 1.0);
        assert_eq!((s.last_frame(), s.time(3), s.time(4)), (4, 0.9 - 1.1102230246251565e-16, 1.0));
        assert_eq!(Schedule::new(5.0, 1.0).last_frame(), 1);
        assert_eq!(Schedule::new(0.1, 0.0).last_frame(), 0);
    }
}
