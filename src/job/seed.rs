use rand::SeedableRng as _;

/// The random stream of one seed: ChaCha8, the same on every platform and in every version.
pub type Rng = rand_chacha::ChaCha8Rng;

/// A node of the seed tree. A child is named by what it is for and by a number, never by a clock, so the
/// same job gives the same result whatever the order and number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Seed(u64);

impl Seed {
    /// The root that the user's `--seed` names.
    pub fn root(seed: u64) -> Self {
        Self(mix(seed))
    }

    /// The seed of part `index` of what `name` says.
    #[must_use]
    pub fn child(self, name: &str, index: u64) -> Self {
        let named = name.bytes().fold(self.0, |h, b| mix(h ^ u64::from(b)));
        Self(mix(named ^ mix(index)))
    }

    /// A fresh random stream.
    pub fn rng(self) -> Rng {
        Rng::seed_from_u64(self.0)
    }

    /// The number itself, for reports.
    pub fn value(self) -> u64 {
        self.0
    }

    /// The node that a report names by its [`Seed::value`].
    pub fn from_value(value: u64) -> Self {
        Self(value)
    }
}

/// SplitMix64's finaliser (Steele, Lea and Flood 2014): every input bit reaches every output bit.
fn mix(x: u64) -> u64 {
    let mut z = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn children_differ_by_name_and_by_index_and_repeat() {
        let root = Seed::root(1);
        assert_eq!(root.child("body", 3), Seed::root(1).child("body", 3));
        assert_ne!(root.child("body", 3), root.child("body", 4));
        assert_ne!(root.child("body", 3), root.child("ydob", 3));
        assert_ne!(root, Seed::root(2));
    }
}
