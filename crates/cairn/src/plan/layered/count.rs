//! How many operations DP(i, j) a layered solution graph holds.

/// The printed equation (4) for K layers and N levels, valid for N >= K >= 1 and links that rise by
/// at most one layer: V = 3NK − 2N − 3K² + K + 3K(K−1)/2 + 3 [Maalouf06 (4)].
///
/// The graph as the text describes it has one vector link fewer for every K and N: level 1 has 1,
/// level i of 2..=K has 3i − 4, each level beyond K has 3K − 2. Term by term these sums are the
/// printed ones but for the constant, 2 instead of 3. The authors thus count two links at the top:
/// the unused link from G to layer 1 is the reading that gives the printed number for all K and N.
pub fn equation_4(layers: usize, levels: usize) -> Option<u64> {
    let (k, n) = (layers as i128, levels as i128);
    let printed = 3 * n * k - 2 * n - 3 * k * k + k + 3 * k * (k - 1) / 2 + 3;
    if n >= k && k >= 1 { u64::try_from(printed).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equation_4_gives_the_printed_numbers() {
        let printed =
            [(1, 1, 2), (2, 2, 4), (2, 3, 8), (3, 3, 9), (3, 5, 23), (4, 6, 37), (5, 9, 80), (6, 10, 106)];
        for (layers, levels, links) in printed {
            assert_eq!(equation_4(layers, levels), Some(links));
        }
        assert_eq!(equation_4(3, 2), None);
        assert_eq!(equation_4(0, 0), None);
    }
}
