const DIGIT: u32 = 10;
const RADIX: usize = 1 << DIGIT;
const WORDS: usize = RADIX / 64;

/// A queue for keys that never fall below the last one taken: buckets of one key each near it, of 1024
/// keys further off, and so on up; an entry moves down at most once per level. A radix heap of base
/// 1024 [Ahuja90], \[Denardo79\].
pub struct Buckets<E> {
    levels: Vec<Level<E>>,
    current: u64,
}

struct Level<E> {
    buckets: Vec<Vec<E>>,
    occupied: [u64; WORDS],
}

impl<E> Level<E> {
    fn new() -> Self {
        Self { buckets: (0..RADIX).map(|_| Vec::new()).collect(), occupied: [0; WORDS] }
    }

    #[inline]
    fn push(&mut self, digit: usize, entry: E) {
        self.occupied[digit / 64] |= 1 << (digit % 64);
        self.buckets[digit].push(entry);
    }

    fn first(&self) -> Option<usize> {
        let word = self.occupied.iter().position(|&word| word != 0)?;
        Some(word * 64 + self.occupied[word].trailing_zeros() as usize)
    }

    fn clear(&mut self, digit: usize) {
        self.occupied[digit / 64] &= !(1 << (digit % 64));
    }
}

impl<E> Buckets<E> {
    pub fn new() -> Self {
        Self { levels: vec![Level::new()], current: 0 }
    }

    /// Adds an entry; its key is not below the one last taken.
    #[inline]
    pub fn push(&mut self, key: u64, entry: E) {
        let differ = key ^ self.current;
        if differ < RADIX as u64 {
            self.levels[0].push(key as usize % RADIX, entry);
        } else {
            self.push_far(key, differ, entry);
        }
    }

    fn push_far(&mut self, key: u64, differ: u64, entry: E) {
        let level = (differ.ilog2() / DIGIT) as usize;
        while self.levels.len() <= level {
            self.levels.push(Level::new());
        }
        self.levels[level].push((key >> (DIGIT * level as u32)) as usize % RADIX, entry);
    }

    /// A key that no entry is below: that of an entry, or the first of a bucket further off.
    pub fn least(&self) -> Option<u64> {
        self.levels.iter().enumerate().find_map(|(level, here)| {
            let below = DIGIT * level as u32;
            let above = u64::MAX.checked_shl(below + DIGIT).unwrap_or(0);
            Some((self.current & above) | ((here.first()? as u64) << below))
        })
    }

    /// Makes `key` the current one. No entry is below it, and it is not above `least`.
    pub fn move_to(&mut self, key: u64, key_of: impl Fn(&E) -> u64) {
        let differ = key ^ self.current;
        self.current = key;
        if differ < RADIX as u64 {
            return;
        }
        // Of the buckets further off, only the one that begins with this key can hold entries near it.
        let level = (differ.ilog2() / DIGIT) as usize;
        let digit = (key >> (DIGIT * level as u32)) as usize % RADIX;
        if let Some(far) = self.levels.get_mut(level) {
            far.clear(digit);
            for entry in std::mem::take(&mut far.buckets[digit]) {
                self.push(key_of(&entry), entry);
            }
        }
    }

    /// Makes the least key of any entry the current one; false if there is no entry.
    pub fn advance(&mut self, key_of: impl Fn(&E) -> u64) -> bool {
        while let Some(key) = self.least() {
            self.move_to(key, &key_of);
            if self.waiting() > 0 {
                return true;
            }
        }
        false
    }

    /// Number of entries of the current key.
    #[inline]
    pub fn waiting(&self) -> usize {
        self.levels[0].buckets[self.current as usize % RADIX].len()
    }

    /// Swaps the entries of the current key for the (empty) `batch`; false if there are none.
    pub fn take(&mut self, batch: &mut Vec<E>) -> bool {
        let digit = self.current as usize % RADIX;
        self.levels[0].clear(digit);
        std::mem::swap(&mut self.levels[0].buckets[digit], batch);
        !batch.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_come_out_in_the_order_of_their_keys_near_and_far() {
        let mut state = 1_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 11
        };
        let (mut queue, mut batch) = (Buckets::new(), Vec::new());
        let (mut added, mut taken, mut last) = (0, 0, 0);
        let push = |queue: &mut Buckets<u64>, key: u64| queue.push(key, key);
        push(&mut queue, 0);
        added += 1;
        while queue.advance(|&key| key) {
            while queue.take(&mut batch) {
                taken += batch.len();
                for key in batch.drain(..) {
                    assert!(key >= last);
                    last = key;
                    for _ in 0..if added < 5000 { 2 } else { 0 } {
                        let ahead = random() >> (random() % 53);
                        push(&mut queue, key.saturating_add(ahead));
                        added += 1;
                    }
                }
            }
        }
        assert_eq!(taken, added);
        assert!(last > 1 << 40);
    }

    #[test]
    fn the_largest_key_is_no_exception() {
        let (mut queue, mut batch) = (Buckets::new(), Vec::new());
        for key in [u64::MAX, 5, u64::MAX - 1, 1 << 63] {
            queue.push(key, key);
        }
        let mut seen = Vec::new();
        while queue.advance(|&key| key) {
            while queue.take(&mut batch) {
                seen.append(&mut batch);
            }
        }
        assert_eq!(seen, [5, 1 << 63, u64::MAX - 1, u64::MAX]);
    }
}
