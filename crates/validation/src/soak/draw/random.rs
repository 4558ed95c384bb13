//! Random numbers of the soak: SplitMix64 (Steele, Lea and Flood 2014) as a function of a key and a counter, so that a seed, a case and
//! an attempt give the same stream on every machine.

/// Increment of the counter: the golden ratio in 64 bits.
const GOLDEN_GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream with the given keys.
    pub fn of(keys: &[u64]) -> Self {
        Self { state: keys.iter().fold(0, |state, key| mix(state ^ mix(key.wrapping_add(GOLDEN_GAMMA)))) }
    }

    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN_GAMMA);
        mix(self.state)
    }

    /// A uniform number in [0, 1).
    pub fn uniform_unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A uniform number between two bounds.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform_unit()
    }

    /// A log-uniform number between two positive bounds.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.uniform_unit())
    }

    /// A uniform integer in [0, `count`).
    pub fn index_below(&mut self, count: usize) -> usize {
        ((self.uniform_unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// True with the given probability.
    pub fn bernoulli(&mut self, probability: f64) -> bool {
        self.uniform_unit() < probability
    }

    /// A random index with the given weights.
    pub fn weighted_index(&mut self, weights: &[f64]) -> usize {
        let mut rest = self.uniform_unit() * weights.iter().sum::<f64>();
        let within = |weight: &f64| {
            rest -= weight;
            rest < 0.0
        };
        weights.iter().position(within).unwrap_or(weights.len().saturating_sub(1))
    }

    /// A uniformly distributed direction.
    pub fn direction(&mut self, dimension: usize) -> Vec<f64> {
        loop {
            let v: Vec<f64> = (0..dimension).map(|_| self.uniform(-1.0, 1.0)).collect();
            let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.1..=1.0).contains(&norm) {
                return v.iter().map(|x| x / norm).collect();
            }
        }
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
