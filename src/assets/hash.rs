use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Odd constants without structure: the first bits of the golden ratio and of pi's fraction.
const LANE_KEYS: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0x243f_6a88_85a3_08d3];

/// A 128-bit hash of bytes for naming cached results: the same on every machine, fast, not cryptographic.
///
/// Two 64-bit lanes take eight bytes a step and fold the 128-bit product of each step.
#[derive(Clone, Debug)]
pub struct ContentHasher {
    lanes: [u64; 2],
    length: u64,
}

impl Default for ContentHasher {
    fn default() -> Self {
        Self { lanes: LANE_KEYS, length: 0 }
    }
}

impl ContentHasher {
    /// Takes in `bytes` and their length, so that `ab` + `c` differs from `a` + `bc`.
    pub fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks::<8>();
        for word in words {
            self.step(u64::from_le_bytes(*word));
        }
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        self.step(u64::from_le_bytes(last));
        self.write_number(bytes.len() as u64);
    }

    /// Takes in one number.
    pub fn write_number(&mut self, number: u64) {
        self.step(number);
        self.length = self.length.wrapping_add(1);
    }

    /// The hash of all that was written.
    pub fn finish(&self) -> u128 {
        let mut end = self.clone();
        end.step(self.length);
        end.step(LANE_KEYS[1]);
        (u128::from(end.lanes[0]) << 64) | u128::from(end.lanes[1])
    }

    fn step(&mut self, word: u64) {
        for (lane, key) in self.lanes.iter_mut().zip(LANE_KEYS) {
            *lane = fold(*lane ^ word, key).wrapping_add(lane.rotate_left(23)) ^ word.wrapping_mul(key);
        }
    }
}

/// Both halves of a 128-bit product, combined.
fn fold(a: u64, b: u64) -> u64 {
    let product = u128::from(a) * u128::from(b);
    (product >> 64) as u64 ^ product as u64
}

/// A map for millions of small keys made of numbers: faster than the standard one, and for files of honest
/// people only slower, never wrong, when somebody chooses keys that collide.
pub type NumberMap<K, V> = HashMap<K, V, BuildHasherDefault<NumberHasher>>;

/// Hashes a few numbers; see [`NumberMap`].
#[derive(Clone, Copy, Debug, Default)]
pub struct NumberHasher(u64);

impl Hasher for NumberHasher {
    fn finish(&self) -> u64 {
        fold(self.0, LANE_KEYS[1])
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = fold(self.0.rotate_left(23) ^ word, LANE_KEYS[0]);
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(u64::from(word));
    }

    fn write_usize(&mut self, word: usize) {
        self.write_u64(word as u64);
    }
}

/// The [`ContentHasher`] hash of one run of bytes.
pub fn content_hash(bytes: &[u8]) -> u128 {
    let mut hasher = ContentHasher::default();
    hasher.write(bytes);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn contents_that_differ_in_one_bit_or_in_length_get_different_hashes() {
        let mut seen = HashSet::from([content_hash(b"")]);
        for length in 1..200 {
            let mut bytes = vec![0u8; length];
            assert!(seen.insert(content_hash(&bytes)));
            for bit in 0..length * 8 {
                bytes[bit / 8] ^= 1 << (bit % 8);
                assert!(seen.insert(content_hash(&bytes)), "{length} bytes, bit {bit}");
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        }
    }

    #[test]
    fn a_hash_is_the_same_on_every_machine_and_depends_on_where_writes_end() {
        assert_eq!(content_hash(b"inhabit"), content_hash(b"inhabit"));
        let parts = |a: &[u8], b: &[u8]| {
            let mut hasher = ContentHasher::default();
            hasher.write(a);
            hasher.write(b);
            hasher.finish()
        };
        assert_ne!(parts(b"ab", b"c"), parts(b"a", b"bc"));
    }
}
