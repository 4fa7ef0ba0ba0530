//! Random numbers that are the same on every machine.

/// SplitMix64 (Steele, Lea & Flood 2014, *Fast splittable pseudorandom number generators*).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `lower..upper`.
    #[allow(clippy::cast_precision_loss)] // 53 bits fit
    pub fn between(&mut self, lower: f64, upper: f64) -> f64 {
        lower + (upper - lower) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the ball of radius one, not too near its centre: good for directions and quaternions.
    pub fn in_ball<const N: usize>(&mut self) -> [f64; N] {
        loop {
            let point = std::array::from_fn(|_| self.between(-1.0, 1.0));
            let norm = point.iter().map(|c: &f64| c * c).sum::<f64>();
            if (0.01..=1.0).contains(&norm) {
                return point;
            }
        }
    }
}
