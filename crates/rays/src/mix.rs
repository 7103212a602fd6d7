//! A small deterministic source of numbers, for pads and test rays. Sample streams are `ambient`'s.

/// SplitMix64 from a seed: Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014.
pub struct Mix(pub u64);

impl Mix {
    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The next number in 0..1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_numbers_from_seed_0_are_those_of_the_authors() {
        let mut mix = Mix(0);
        let first: [u64; 3] = std::array::from_fn(|_| mix.bits());
        assert_eq!(
            first,
            [
                0xe220_a839_7b1d_cdaf,
                0x6e78_9e6a_a1b9_65f4,
                0x06c4_5d18_8009_454f
            ]
        );
    }
}
