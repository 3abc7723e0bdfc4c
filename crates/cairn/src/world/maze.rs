use super::random::SplitMix;
use super::{Grid, GridGeometry};

/// One cell in this many grows from a random place instead of the newest. Between depth-first mazes
/// (10 % dead ends) and Prim's (36 %): about 19 % dead ends, as the mazes of [Sturtevant12] have.
const NEWEST_IN: u64 = 8;

/// A perfect maze, true where free: corridors `corridor` cells wide between walls of one cell, exactly
/// one way between any two places, the same for the same seed.
///
/// Walls frame the grid; what does not fit a whole corridor is wall. The maze is grown as a tree from
/// the room in the middle, and takes a time linear in the number of cells. None if no room fits or
/// `corridor` is 0.
pub fn perfect_maze(geometry: GridGeometry, corridor: usize, seed: u64) -> Option<Grid<bool>> {
    let pitch = corridor.checked_add(1)?;
    let (down, across) = (geometry.rows.saturating_sub(1) / pitch, geometry.cols.saturating_sub(1) / pitch);
    if corridor == 0 || down == 0 || across == 0 {
        return None;
    }
    let cols = geometry.cols;
    let mut free = vec![false; geometry.len()];
    let mut carve = |top: usize, left: usize, height: usize, width: usize| {
        for row in top..top + height {
            free[row * cols + left..row * cols + left + width].fill(true);
        }
    };
    let mut random = SplitMix::new(seed);
    let mut seen = vec![false; down * across];
    let first = down / 2 * across + across / 2;
    seen[first] = true;
    let mut growing = vec![first];
    while !growing.is_empty() {
        let last = growing.len() - 1;
        let chosen =
            if random.below(NEWEST_IN) == 0 { random.below(growing.len() as u64) as usize } else { last };
        let room = growing[chosen];
        let (row, col) = (room / across, room % across);
        let (top, left) = (row * pitch + 1, col * pitch + 1);
        let mut ways = [(0, 0); 4];
        let mut count = 0;
        for (open, next, side) in [
            (row > 0, room.wrapping_sub(across), 0),
            (row + 1 < down, room + across, 1),
            (col > 0, room.wrapping_sub(1), 2),
            (col + 1 < across, room + 1, 3),
        ] {
            if open && !seen[next] {
                ways[count] = (next, side);
                count += 1;
            }
        }
        if count == 0 {
            carve(top, left, corridor, corridor);
            growing.swap_remove(chosen);
            continue;
        }
        let (next, side) = ways[random.below(count as u64) as usize];
        match side {
            0 => carve(top - 1, left, 1, corridor),
            1 => carve(top + corridor, left, 1, corridor),
            2 => carve(top, left - 1, corridor, 1),
            _ => carve(top, left + corridor, corridor, 1),
        }
        seen[next] = true;
        growing.push(next);
    }
    Some(Grid::new(geometry, free))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose2;

    fn geometry(rows: usize, cols: usize) -> GridGeometry {
        GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }
    }

    #[test]
    fn a_maze_is_one_tree_of_corridors() {
        for (rows, cols, corridor) in [(3, 3, 1), (64, 65, 1), (70, 41, 2), (121, 201, 4)] {
            let maze = perfect_maze(geometry(rows, cols), corridor, 5).unwrap();
            assert_eq!(maze, perfect_maze(geometry(rows, cols), corridor, 5).unwrap());
            let rooms = (rows - 1) / (corridor + 1) * ((cols - 1) / (corridor + 1));
            // A tree of n rooms has n - 1 doors.
            let free = maze.values.iter().filter(|&&free| free).count();
            assert_eq!(free, rooms * corridor * corridor + (rooms - 1) * corridor);
            let start = maze.values.iter().position(|&free| free).unwrap();
            let (mut seen, mut stack) = (vec![false; rows * cols], vec![start]);
            seen[start] = true;
            while let Some(cell) = stack.pop() {
                for next in [cell + 1, cell - 1, cell + cols, cell - cols] {
                    if maze.values[next] && !seen[next] {
                        seen[next] = true;
                        stack.push(next);
                    }
                }
            }
            assert_eq!(seen.iter().filter(|&&seen| seen).count(), free);
        }
        assert!(perfect_maze(geometry(2, 9), 1, 0).is_none());
        assert!(perfect_maze(geometry(9, 9), 0, 0).is_none());
    }

    #[test]
    fn dead_ends_are_as_frequent_as_in_published_mazes() {
        let size = 401;
        let maze = perfect_maze(geometry(size, size), 1, 9).unwrap();
        let rooms = (size / 2) * (size / 2);
        let mut dead = 0;
        for row in (1..size).step_by(2) {
            for col in (1..size).step_by(2) {
                let at = |row: usize, col: usize| usize::from(maze.values[row * size + col]);
                let doors = at(row - 1, col) + at(row + 1, col) + at(row, col - 1) + at(row, col + 1);
                dead += usize::from(doors == 1);
            }
        }
        let share = dead as f64 / rooms as f64;
        assert!((0.17..0.21).contains(&share), "{share}");
    }
}
