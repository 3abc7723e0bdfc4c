use super::*;
use crate::geometry::Pose2;
use crate::plan::{Values, plan_costs_f32, plan_free};
use crate::world::Grid;

/// Numbers 0.. of a seeded row [Steele14: splitmix64].
fn random(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |below| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % below
    }
}

fn laid<T>(rows: usize, cols: usize, values: Vec<T>) -> Grid<T> {
    Grid::new(GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }, values)
}

#[test]
fn dial_and_heap_equal_the_solver_to_the_bit_field_and_policy() {
    let mut below = random(1);
    let mut dial = Peer::<u32, _>::new(Buckets::unit_wide());
    let mut wide = Peer::<u32, _>::new(Buckets::wide());
    let mut heap = Peer::<u32, _>::new(Heap::default());
    let mut dial_f32 = Peer::<f32, _>::new(Buckets::wide());
    let mut heap_f32 = Peer::<f32, _>::new(Heap::default());
    for round in 0..400 {
        let (rows, cols) = (1 + below(14) as usize, 1 + below(14) as usize);
        let options = PlanOptions { corner_cutting: round % 2 == 0, ..PlanOptions::default() };
        let blocked = below(45);
        let mut weights: Vec<u8> =
            (0..rows * cols).map(|_| if below(100) < blocked { 0 } else { 1 + below(255) as u8 }).collect();
        let goals = [below(rows as u64), below(cols as u64)].map(|i| i as usize);
        let goals = [Cell::new(goals[0], goals[1])];
        weights[goals[0].row * cols + goals[0].col] = 7;

        let free = laid(rows, cols, weights.iter().map(|&w| w > 0).collect());
        let field = plan_free(&free, &goals, &options).unwrap();
        let Values::U32(values) = field.native() else { panic!("fits in u32") };
        let links = || FreeLinks::new(&free.values, [985, 1393]);
        assert!(dial.plan(&free.geometry, &mut links(), &goals, &options).unwrap());
        assert!(wide.plan(&free.geometry, &mut links(), &goals, &options).unwrap());
        assert!(heap.plan(&free.geometry, &mut links(), &goals, &options).unwrap());
        for (found, codes) in [
            (dial.values(), dial.next_codes()),
            (wide.values(), wide.next_codes()),
            (heap.values(), heap.next_codes()),
        ] {
            assert_eq!((found, codes), (&values[..], field.next_codes()));
        }

        let costs =
            weights.iter().map(|&w| if w == 0 { f32::INFINITY } else { f32::from(w) / 3.0 }).collect();
        let costs = laid(rows, cols, costs);
        let field = plan_costs_f32(&costs, &goals, &options).unwrap();
        let Values::F32(values) = field.native() else { panic!("asked for f32") };
        let mut padded = vec![];
        for peer in 0..2 {
            let mut links = MeanLinks::new(&costs.values, &mut padded);
            let (found, codes) = if peer == 0 {
                assert!(dial_f32.plan(&costs.geometry, &mut links, &goals, &options).unwrap());
                (dial_f32.values(), dial_f32.next_codes())
            } else {
                assert!(heap_f32.plan(&costs.geometry, &mut links, &goals, &options).unwrap());
                (heap_f32.values(), heap_f32.next_codes())
            };
            assert_eq!((found, codes), (&values[..], field.next_codes()));
        }

        let mut padded = vec![];
        assert!(
            wide.plan(&free.geometry, &mut MeanLinks::new(&weights, &mut padded), &goals, &options).unwrap()
        );
        assert!(
            heap.plan(&free.geometry, &mut MeanLinks::new(&weights, &mut padded), &goals, &options).unwrap()
        );
        assert_eq!((wide.values(), wide.next_codes()), (heap.values(), heap.next_codes()));
    }
}

#[test]
fn dial_and_heap_over_terrain_equal_the_solver_to_the_bit_field_and_policy() {
    use crate::plan::terrain::{AnyTerrainLinks, P3at, TerrainModel, Tobler, plan_terrain, roughness_of};
    let mut below = random(2);
    let mut dial = Peer::<f32, _>::new(Buckets::wide());
    let mut heap = Peer::<f32, _>::new(Heap::default());
    for round in 0..300 {
        let (rows, cols) = (1 + below(14) as usize, 1 + below(14) as usize);
        let options = PlanOptions { corner_cutting: round % 2 == 0, ..PlanOptions::default() };
        let mut heights: Vec<f32> = (0..rows * cols)
            .map(|_| if below(9) == 0 { f32::NAN } else { below(900) as f32 / 1000.0 })
            .collect();
        let goals = [Cell::new(below(rows as u64) as usize, below(cols as u64) as usize)];
        heights[goals[0].row * cols + goals[0].col] = 0.5;
        let elevation = laid(rows, cols, heights);
        let roughness = roughness_of(&elevation).unwrap();
        let model = match round % 3 {
            0 => TerrainModel::P3atEnergy(P3at::default()),
            1 => TerrainModel::P3atTime(P3at::default()),
            _ => TerrainModel::Tobler(Tobler::default()),
        };
        let field = plan_terrain(&elevation, Some(&roughness), &model, &goals, &options).unwrap();
        let Values::F32(values) = field.native() else { panic!("terrain is f32") };
        let mut padded = [vec![], vec![]];
        macro_rules! equal {
            ($links:expr) => {{
                let (heights, rough) = (&elevation.values, &roughness.values);
                let range = slope_range(heights, rough, &$links.model, cols);
                let mut links =
                    SlopeLinks::new(&$links.allowed, heights, rough, $links.model, range, &mut padded);
                dial.plan(&elevation.geometry, &mut links, &goals, &options).unwrap();
                heap.plan(&elevation.geometry, &mut links, &goals, &options).unwrap();
            }};
        }
        match AnyTerrainLinks::new(&elevation, Some(&roughness), &model, options.corner_cutting).unwrap() {
            AnyTerrainLinks::P3atEnergy(links) => equal!(links),
            AnyTerrainLinks::P3atTime(links) => equal!(links),
            AnyTerrainLinks::Tobler(links) => equal!(links),
        }
        assert_eq!((dial.values(), dial.next_codes()), (&values[..], field.next_codes()));
        assert_eq!((heap.values(), heap.next_codes()), (&values[..], field.next_codes()));
    }
}

#[test]
fn a_cost_to_go_too_large_for_u32_is_told_by_both_queues() {
    let weights = vec![255_u8; 100_000];
    let geometry = laid(1, weights.len(), weights.clone()).geometry;
    let (goals, options) = ([Cell::new(0, 0)], PlanOptions::default());
    let mut padded = vec![];
    let mut links = MeanLinks::new(&weights, &mut padded);
    let mut narrow = Peer::<u32, _>::new(Buckets::wide());
    assert!(!narrow.plan(&geometry, &mut links, &goals, &options).unwrap());
    let mut narrow = Peer::<u32, _>::new(Heap::default());
    assert!(!narrow.plan(&geometry, &mut links, &goals, &options).unwrap());
    let mut broad = Peer::<u64, _>::new(Buckets::wide());
    assert!(broad.plan(&geometry, &mut links, &goals, &options).unwrap());
    assert_eq!(broad.values()[99_999], 99_999 * 510 * 985);
}
