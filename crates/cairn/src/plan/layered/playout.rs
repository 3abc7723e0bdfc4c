use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::schedule::{Board, Schedule, Task, Wait};

/// The begin and end of each of `tasks` (with its duration) when so many workers play a schedule out:
/// whoever is free takes the earliest task by (level, layer) that the schedule offers, as the threads do.
///
/// `tasks` are all of levels 1..=N. `slope` is the r + 1 of the in-place engine's fronts, 0 for the
/// levelled engine. None if tasks are missing, given twice or of layers that `waits` does not have.
pub fn play_out(
    waits: &[Vec<Wait>],
    schedule: Schedule,
    slope: usize,
    tasks: &[(Task, u64)],
    workers: usize,
) -> Option<Vec<(u64, u64)>> {
    let count = waits.len() as u32;
    let levels = tasks.iter().map(|(task, _)| task.level).max().unwrap_or(0);
    let mut order: Vec<usize> = (0..tasks.len()).collect();
    order.sort_by_key(|&at| tasks[at].0);
    let expected =
        (1..=levels).flat_map(|level| (1..=level.min(count)).map(move |layer| Task { level, layer }));
    let known = waits.iter().flatten().all(|wait| (1..=count).contains(&wait.layer));
    if workers == 0 || !known || !order.iter().map(|&at| tasks[at].0).eq(expected) {
        return None;
    }
    let mut board = Board::new(waits.to_vec(), schedule, slope, levels as usize, false);
    let mut times = vec![(0, 0); tasks.len()];
    let mut running: BinaryHeap<Reverse<(u64, usize)>> = BinaryHeap::new();
    let (mut now, mut free) = (0, workers);
    while !board.finished {
        while free > 0
            && let Some(task) = board.take()
        {
            let found = order.binary_search_by_key(&task, |&at| tasks[at].0).ok()?;
            let at = order[found];
            times[at] = (now, now + tasks[at].1);
            running.push(Reverse((times[at].1, at)));
            free -= 1;
        }
        let Reverse((end, at)) = running.pop()?;
        (now, free) = (end, free + 1);
        board.complete(tasks[at].0, true);
    }
    Some(times)
}
