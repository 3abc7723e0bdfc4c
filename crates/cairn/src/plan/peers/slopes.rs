use super::ground::Ground;
use super::links::LinkCosts;
use crate::plan::terrain::LinkCost;

/// Links over terrain, priced on the fly by a cost model; they differ there and back.
///
/// The moves that cells allow are given, not found: a plain planner is not to wait for that.
pub struct SlopeLinks<'a, M> {
    allowed: &'a [u8],
    heights: &'a [f32],
    roughness: &'a [f32],
    model: M,
    padded: &'a mut [Vec<f32>; 2],
    range: (f32, f32),
}

impl<'a, M: LinkCost> SlopeLinks<'a, M> {
    /// Heights \[m\] and roughness row-major, and the bits of the allowed moves of each cell; `padded` is
    /// memory to work in, `range` that of [`slope_range`].
    pub fn new(
        allowed: &'a [u8],
        heights: &'a [f32],
        roughness: &'a [f32],
        model: M,
        range: (f32, f32),
        padded: &'a mut [Vec<f32>; 2],
    ) -> Self {
        Self { allowed, heights, roughness, model, padded, range }
    }
}

/// (cheapest, dearest): bounds of what links cost: of rises between the steepest ones down and up, on the smoothest and the
/// roughest ground. Both models are steepest at the ends of what they are given.
pub fn slope_range<M: LinkCost>(heights: &[f32], roughness: &[f32], model: &M, cols: usize) -> (f32, f32) {
    let larger = |a: f32, b: f32| if b > a { b } else { a };
    let steepest = [1, cols - usize::from(cols > 1), cols, cols + 1].map(|apart| {
        let pairs = heights.iter().zip(heights.iter().skip(apart));
        pairs.fold(0.0, |most, (a, b)| larger(most, (b - a).abs()))
    });
    let steepest = steepest.into_iter().fold(0.0, larger);
    let roughest = roughness.iter().fold(0.0, |most, &rough| larger(most, rough));
    let (mut low, mut high) = (f32::INFINITY, 0.0_f32);
    for step in -256..=256 {
        let rise = steepest * step as f32 / 256.0;
        low = low.min(model.link::<false>(rise, 0.0, 0.0)).min(model.link::<true>(rise, 0.0, 0.0));
        let dear = model.link::<false>(rise, roughest, roughest);
        high = high.max(dear).max(model.link::<true>(rise, roughest, roughest));
    }
    (low, high * 1.01)
}

impl<M: LinkCost> LinkCosts<f32> for SlopeLinks<'_, M> {
    fn free_row(&self, row: usize, cols: usize, free: &mut [u8]) {
        for (to, height) in free.iter_mut().zip(&self.heights[row * cols..]) {
            *to = u8::from(!height.is_nan());
        }
    }

    fn moves(&self) -> Option<&[u8]> {
        Some(self.allowed)
    }

    fn pad(&mut self, ground: &Ground) {
        for (padded, values) in self.padded.iter_mut().zip([self.heights, self.roughness]) {
            padded.clear();
            padded.resize(ground.len(), 0.0);
            for (row, line) in values.chunks_exact(ground.cols).enumerate() {
                let begin = ground.index(row, 0);
                padded[begin..begin + ground.cols].copy_from_slice(line);
            }
        }
    }

    #[inline(always)]
    fn cost(&self, tail: usize, head: usize, code: usize) -> f32 {
        let [heights, roughness] = &*self.padded;
        let rise = heights[head] - heights[tail];
        let (here, there) = if M::USES_ROUGHNESS { (roughness[tail], roughness[head]) } else { (0.0, 0.0) };
        if code % 2 == 1 {
            self.model.link::<true>(rise, here, there)
        } else {
            self.model.link::<false>(rise, here, there)
        }
    }

    fn range(&self) -> (f32, f32) {
        self.range
    }

    fn match_row(&self, tail: usize, head: usize, code: usize, values: &[f32], equal: &mut [u8]) {
        let count = equal.len();
        let [heights, roughness] = &*self.padded;
        let (low, high) = (&heights[tail..tail + count], &heights[head..head + count]);
        let (here, there) = (&roughness[tail..tail + count], &roughness[head..head + count]);
        let (value, next) = (&values[tail..tail + count], &values[head..head + count]);
        for i in 0..count {
            let rise = high[i] - low[i];
            let link = if code % 2 == 1 {
                self.model.link::<true>(rise, here[i], there[i])
            } else {
                self.model.link::<false>(rise, here[i], there[i])
            };
            equal[i] = u8::from((next[i] + link == value[i]) & (value[i] < f32::INFINITY));
        }
    }
}
