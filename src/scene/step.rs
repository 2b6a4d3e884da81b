//! How the long functions of this module tell how far they are and learn that nobody wants their result:
//! they ask in pieces of a few thousand items, so that a cancel takes effect in far less than 200 ms even in
//! rooms of a million triangles. Knows no geometry.

use std::ops::ControlFlow;

use rayon::prelude::*;

/// Progress of a long function: called at least every 50 ms with `(done, total)`; `Break` stops it.
pub type Step<'a> = &'a (dyn Fn(usize, usize) -> ControlFlow<()> + Sync);

/// The caller's [`Step`] broke off the work; nothing was changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped on request before it was done; start it again to get a result")]
pub struct Stopped;

/// Calls `step` and turns `Break` into an error.
pub(in crate::scene) fn report(step: Step, done: usize, total: usize) -> Result<(), Stopped> {
    if step(done, total).is_break() { Err(Stopped) } else { Ok(()) }
}

/// A step that nobody watches and that never stops anything.
pub(in crate::scene) fn unwatched(_: usize, _: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Items between two questions of a [`Pace`]: at a microsecond each, a few milliseconds.
const ITEMS: usize = 4096;

/// Asks once in a few thousand items of a plain loop.
pub(in crate::scene) struct Pace<'a> {
    step: Step<'a>,
    done: usize,
    total: usize,
    asked: usize,
}

impl<'a> Pace<'a> {
    /// A loop over `total` items, or 0 where nobody knows.
    pub fn new(step: Step<'a>, total: usize) -> Self {
        Self { step, done: 0, total, asked: 0 }
    }

    /// One more item.
    #[inline]
    pub fn item(&mut self) -> Result<(), Stopped> {
        self.items(1)
    }

    /// `count` more items; for loops whose rounds differ in their work.
    #[inline]
    pub fn items(&mut self, count: usize) -> Result<(), Stopped> {
        self.done += count;
        if self.done - self.asked < ITEMS { Ok(()) } else { self.ask() }
    }

    fn ask(&mut self) -> Result<(), Stopped> {
        self.asked = self.done;
        report(self.step, self.done, self.total)
    }
}

/// Items of one task of [`fill`]: a few milliseconds of the costliest work that it is used for.
const FILL: usize = 1 << 14;

/// Sets every element to `value(index)`, on all threads.
pub(in crate::scene) fn fill<T: Send>(
    out: &mut [T],
    step: Step,
    value: impl Fn(usize) -> T + Sync,
) -> Result<(), Stopped> {
    let tasks = out.len().div_ceil(FILL);
    out.par_chunks_mut(FILL).enumerate().try_for_each(|(task, part)| {
        report(step, task, tasks)?;
        part.iter_mut().enumerate().for_each(|(i, slot)| *slot = value(task * FILL + i));
        Ok(())
    })
}

/// Elements that are sorted in one go: a few milliseconds.
const SORTED: usize = 1 << 14;

/// Sorts on all threads, in pieces by `key`, so that equal elements stand together, which is all that grouping
/// needs: each piece is in order, the pieces among themselves are in none. Equal elements must have equal keys.
pub(in crate::scene) fn group<T: Ord + Copy + Send + Sync>(
    items: Vec<T>,
    step: Step,
    key: impl Fn(&T) -> u64 + Sync,
) -> Result<Vec<Vec<T>>, Stopped> {
    let pieces = items.len().div_ceil(SORTED).next_power_of_two();
    let mut groups: Vec<Vec<T>> = Vec::new();
    groups.resize_with(pieces, || Vec::with_capacity(SORTED));
    let mut pace = Pace::new(step, items.len());
    for item in items {
        pace.item()?;
        // Fibonacci hashing: the upper bits of the product are well mixed.
        let place = key(&item).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        groups[place as usize & (pieces - 1)].push(item);
    }
    groups.par_iter_mut().enumerate().try_for_each(|(done, piece)| {
        report(step, done, pieces)?;
        piece.sort_unstable();
        Ok(())
    })?;
    Ok(groups)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn a_loop_is_asked_every_few_thousand_items_and_ends_when_told() {
        let asked = AtomicUsize::new(0);
        let third_time = |_: usize, _: usize| match asked.fetch_add(1, Ordering::Relaxed) {
            2 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let mut pace = Pace::new(&third_time, 100_000);
        let went = (0..100_000).take_while(|_| pace.item().is_ok()).count();
        assert_eq!(went, 3 * ITEMS - 1);
        assert!(fill(&mut [0_u8; 5], &|_, _| ControlFlow::Break(()), |_| 1).is_err());
    }

    #[test]
    fn equal_elements_stand_together_and_none_is_lost() {
        let items: Vec<u32> = (0..300_000_u32).map(|i| i.wrapping_mul(2_654_435_761) % 1000).collect();
        let groups = group(items, &unwatched, |&i| u64::from(i)).expect("not stopped");
        let mut seen = std::collections::BTreeMap::new();
        for run in groups.iter().flat_map(|piece| piece.chunk_by(|a, b| a == b)) {
            assert!(seen.insert(run[0], run.len()).is_none(), "{} stands in two places", run[0]);
        }
        assert_eq!(seen.values().sum::<usize>(), 300_000);
    }
}
