//! GIF's variant of LZW: codes of growing width, least significant bits first.

/// Bits of a symbol: an index into 256 colours.
pub const SYMBOL_BITS: u8 = 8;
const CLEAR: u16 = 1 << SYMBOL_BITS;
const END: u16 = CLEAR + 1;
/// Codes have at most 12 bits.
const CODES: u16 = 4096;
/// Slots of the table of known strings: twice the codes, so that searches are short.
const SLOTS: usize = 8192;

/// Bits on their way into bytes.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    held: u32,
    count: u32,
}

impl Bits {
    fn put(&mut self, code: u16, width: u32) {
        self.held |= u32::from(code) << self.count;
        self.count += width;
        while self.count >= 8 {
            self.bytes.push(self.held as u8);
            self.held >>= 8;
            self.count -= 8;
        }
    }

    fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push(self.held as u8);
        }
        self.bytes
    }
}

/// Strings that have a code: the code of all but the last symbol, and that symbol.
struct Table {
    /// The string's key and its code; key 0 is an empty slot.
    slots: Vec<(u32, u16)>,
    next: u16,
}

impl Table {
    fn new() -> Self {
        Self { slots: vec![(0, 0); SLOTS], next: END + 1 }
    }

    fn clear(&mut self) {
        self.slots.fill((0, 0));
        self.next = END + 1;
    }

    /// The slot of a string: where it is, or where it belongs.
    fn slot(&self, prefix: u16, symbol: u8) -> (usize, u32) {
        let key = (u32::from(prefix) << 8 | u32::from(symbol)) + 1;
        let mut at = (key.wrapping_mul(0x9e37_79b1) >> 19) as usize % SLOTS;
        while self.slots[at].0 != 0 && self.slots[at].0 != key {
            at = (at + 1) % SLOTS;
        }
        (at, key)
    }
}

/// Compresses symbols.
pub fn compress(symbols: &[u8]) -> Vec<u8> {
    let mut bits = Bits::default();
    let mut table = Table::new();
    let mut width = u32::from(SYMBOL_BITS) + 1;
    bits.put(CLEAR, width);
    let mut symbols = symbols.iter();
    let Some(first) = symbols.next() else {
        bits.put(END, width);
        return bits.finish();
    };
    let mut prefix = u16::from(*first);
    for symbol in symbols {
        let (at, key) = table.slot(prefix, *symbol);
        if table.slots[at].0 == key {
            prefix = table.slots[at].1;
            continue;
        }
        bits.put(prefix, width);
        if table.next == CODES {
            bits.put(CLEAR, width);
            table.clear();
            width = u32::from(SYMBOL_BITS) + 1;
        } else {
            table.slots[at] = (key, table.next);
            if table.next == 1 << width {
                width += 1;
            }
            table.next += 1;
        }
        prefix = u16::from(*symbol);
    }
    bits.put(prefix, width);
    // A reader adds a string once it has the last code, which may widen the next.
    if table.next == 1 << width && table.next < CODES {
        width += 1;
    }
    bits.put(END, width);
    bits.finish()
}

/// What a reader makes of compressed symbols, written after the format and not after [`compress`].
#[cfg(test)]
pub fn expand(data: &[u8], symbol_bits: u8) -> Vec<u8> {
    let (clear, end) = (1usize << symbol_bits, (1usize << symbol_bits) + 1);
    let bit = |at: usize| data.get(at / 8).map_or(0, |byte| usize::from(byte >> (at % 8) & 1));
    let fresh = || (0..clear + 2).map(|i| if i < clear { vec![i as u8] } else { Vec::new() }).collect();
    let (mut strings, mut width, mut at): (Vec<Vec<u8>>, usize, usize) =
        (fresh(), usize::from(symbol_bits) + 1, 0);
    let (mut out, mut last): (Vec<u8>, Option<Vec<u8>>) = (Vec::new(), None);
    loop {
        let code = (0..width).map(|i| bit(at + i) << i).sum::<usize>();
        at += width;
        if code == clear {
            (strings, width, last) = (fresh(), usize::from(symbol_bits) + 1, None);
            continue;
        }
        if code == end || at > data.len() * 8 {
            return out;
        }
        let string = match (strings.get(code), &last) {
            (Some(known), _) => known.clone(),
            (None, Some(last)) => [&last[..], &last[..1]].concat(),
            (None, None) => panic!("code {code} before any string"),
        };
        if let Some(last) = &last
            && strings.len() < 4096
        {
            strings.push([&last[..], &string[..1]].concat());
            if strings.len() == 1 << width && width < 12 {
                width += 1;
            }
        }
        out.extend_from_slice(&string);
        last = Some(string);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_runs_noise_and_nothing_come_back() {
        let mut state = 1u32;
        let noise: Vec<u8> = (0..30_000)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as u8
            })
            .collect();
        for symbols in [Vec::new(), vec![7; 100_000], noise, (0..=255).cycle().take(20_000).collect()] {
            assert!(expand(&compress(&symbols), SYMBOL_BITS) == symbols, "{} symbols", symbols.len());
        }
    }
}
