//! Up to 255 colours for a picture: median cut over the colours that occur (Heckbert 1982).

/// Index of the colour that shows what was there before.
pub const TRANSPARENT: u8 = 255;
const MOST: usize = 255;
/// Bits of each channel that colours are told apart by.
const BITS: u32 = 5;
const BINS: usize = 1 << (3 * BITS);

/// The colours and, for every bin of colours that occurs, the index of its colour.
pub struct Palette {
    colors: Vec<[u8; 3]>,
    index: Vec<u8>,
}

/// Colours that fall together.
#[derive(Clone, Copy, Default)]
struct Bin {
    count: u32,
    sum: [u64; 3],
}

impl Bin {
    fn mean(&self, channel: usize) -> u8 {
        (self.sum[channel] / u64::from(self.count.max(1))) as u8
    }
}

fn bin_of(color: [u8; 3]) -> usize {
    color.iter().fold(0, |bin, channel| bin << BITS | usize::from(channel >> (8 - BITS)))
}

impl Palette {
    /// The colours that suit these best.
    pub fn of(colors: impl Iterator<Item = [u8; 3]>) -> Self {
        let mut bins = vec![Bin::default(); BINS];
        for color in colors {
            let bin = &mut bins[bin_of(color)];
            bin.count += 1;
            (0..3).for_each(|c| bin.sum[c] += u64::from(color[c]));
        }
        let mut used: Vec<usize> = (0..BINS).filter(|bin| bins[*bin].count > 0).collect();
        let mut palette = Self { colors: Vec::new(), index: vec![0; BINS] };
        for group in cut(&bins, &mut used) {
            let mut all = Bin::default();
            for bin in &group {
                all.count += bins[*bin].count;
                (0..3).for_each(|c| all.sum[c] += bins[*bin].sum[c]);
                palette.index[*bin] = palette.colors.len() as u8;
            }
            palette.colors.push([0, 1, 2].map(|c| all.mean(c)));
        }
        palette
    }

    /// Index of the colour that stands for `color`, which was among those that the palette was made of.
    pub fn index(&self, color: [u8; 3]) -> u8 {
        self.index[bin_of(color)]
    }

    /// The table as it stands in the file: 256 colours.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.colors.as_flattened().to_vec();
        bytes.resize(256 * 3, 0);
        bytes
    }
}

/// Cuts the bins into at most 255 groups, always the group whose colours spread the most over the most pixels.
fn cut(bins: &[Bin], used: &mut [usize]) -> Vec<Vec<usize>> {
    if used.is_empty() {
        return Vec::new();
    }
    let mut groups = vec![Group::of(bins, used.to_vec())];
    while groups.len() < MOST {
        let widest = (0..groups.len()).max_by(|a, b| groups[*a].weight.total_cmp(&groups[*b].weight));
        let Some(widest) = widest.filter(|group| groups[*group].bins.len() > 1) else { break };
        let (low, high) = groups.swap_remove(widest).halves(bins);
        groups.extend([low, high]);
    }
    groups.into_iter().map(|group| group.bins).collect()
}

struct Group {
    bins: Vec<usize>,
    /// The channel along which its colours differ most.
    channel: usize,
    /// How much it is worth to be cut; 0 for a single bin.
    weight: f32,
}

impl Group {
    fn of(bins: &[Bin], of: Vec<usize>) -> Self {
        let spread = |channel: usize| {
            let means = || of.iter().map(|bin| bins[*bin].mean(channel));
            means().max().unwrap_or(0) - means().min().unwrap_or(0)
        };
        let channel = (0..3).max_by_key(|channel| spread(*channel)).unwrap_or(0);
        let pixels: u32 = of.iter().map(|bin| bins[*bin].count).sum();
        let weight = if of.len() > 1 { f32::from(spread(channel)) * (pixels as f32).sqrt() } else { 0.0 };
        Self { bins: of, channel, weight }
    }

    /// Both halves at the median pixel; neither is empty.
    fn halves(self, bins: &[Bin]) -> (Self, Self) {
        let mut low = self.bins;
        low.sort_by_key(|bin| (bins[*bin].mean(self.channel), *bin));
        let pixels: u32 = low.iter().map(|bin| bins[*bin].count).sum();
        let mut below = 0;
        let at = low.iter().position(|bin| {
            below += bins[*bin].count;
            2 * below >= pixels
        });
        let at = at.map_or(1, |at| at + 1).clamp(1, low.len() - 1);
        let high = low.split_off(at);
        (Self::of(bins, low), Self::of(bins, high))
    }
}
