/// Random numbers of one path: what they are depends on the seed of the picture, the pixel and the
/// number of the sample alone, so a picture does not depend on who traced which path when.
///
/// A permuted congruential generator with 64 bits of state and 32 bits of output (O'Neill 2014,
/// PCG-XSH-RR), begun at a hash of the three.
#[derive(Debug, Clone)]
pub struct PathRandom {
    state: u64,
}

impl PathRandom {
    /// The numbers of the sample number `sample` of a pixel, in a picture of a seed.
    #[must_use]
    pub fn new(seed: u64, pixel: u64, sample: u64) -> Self {
        Self { state: mixed(mixed(mixed(seed) ^ pixel) ^ sample) }
    }

    /// The next number, even in `[0, 1)`, a multiple of `2^-32`.
    #[inline]
    pub fn number(&mut self) -> f64 {
        let state = self.state;
        self.state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(INCREMENT);
        let xor = ((state >> 18) ^ state) >> 27;
        let [a, b, c, d, ..] = xor.to_le_bytes();
        let bits = u32::from_le_bytes([a, b, c, d]).rotate_right((state >> 59) as u32);
        f64::from(bits) * (1.0 / 4_294_967_296.0)
    }

    /// The next two numbers.
    #[inline]
    pub fn pair(&mut self) -> [f64; 2] {
        [self.number(), self.number()]
    }
}

/// What is added in every step of the generator, any odd number.
const INCREMENT: u64 = 1_442_695_040_888_963_407;

/// A hash of 64 bits (the finalizer of splitmix64, Steele et al. 2014).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
