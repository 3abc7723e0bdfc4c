//! Every engine and the solver against a textbook Bellman–Ford, in every number type.

use cairn::geometry::Pose2;
use cairn::plan::{
    Cost, Engine, Graph, GraphCost, LayeredOptions, PlanError, PlanOptions, Steps, Values,
    graph_of_costs_f32, graph_of_free, plan_costs_f32, plan_free, plan_graph, plan_layered,
};
use cairn::world::{Cell, Grid, GridGeometry};
use proptest::prelude::*;

const OPTIMAL: [Engine; 3] = [Engine::Phased, Engine::Levelled, Engine::InPlace];

fn bellman_ford<C: Cost>(nodes: usize, edges: &[(usize, usize, C)], goals: &[usize]) -> Vec<C> {
    let mut values = vec![C::UNREACHABLE; nodes];
    goals.iter().for_each(|&goal| values[goal] = C::ZERO);
    for _ in 0..nodes {
        for &(from, to, cost) in edges {
            if values[to] < C::UNREACHABLE {
                let through = values[to].plus(cost).unwrap();
                values[from] = if through < values[from] { through } else { values[from] };
            }
        }
    }
    values
}

fn check<C: GraphCost>(
    nodes: usize,
    edges: &[(usize, usize, C)],
    goals: &[usize],
) -> Result<(), TestCaseError> {
    let truth = bellman_ford(nodes, edges, goals);
    let graph = Graph::from_edges(nodes, edges).unwrap();
    let solver = plan_graph(&graph, goals, None).unwrap();
    prop_assert_eq!(&solver.cost_to_go, &truth);
    for engine in OPTIMAL {
        let plan = plan_layered(&graph, goals, &LayeredOptions { engine, ..Default::default() }).unwrap();
        prop_assert_eq!(&plan.field.cost_to_go, &truth);
        for (start, &cost) in truth.iter().enumerate() {
            let path = plan.field.path(start);
            prop_assert_eq!(path.is_some(), cost < C::UNREACHABLE);
            if let Some(path) = path {
                prop_assert!(path.len() <= nodes && goals.contains(&path[path.len() - 1]));
            }
        }
    }
    Ok(())
}

fn edges() -> impl Strategy<Value = (usize, Vec<(usize, usize, u16)>, Vec<usize>)> {
    (1..9_usize).prop_flat_map(|nodes| {
        let edge = (0..nodes, 0..nodes, 0..50_u16);
        (Just(nodes), prop::collection::vec(edge, 0..30), prop::collection::vec(0..nodes, 1..3))
    })
}

fn grid<T>(rows: usize, cols: usize, values: Vec<T>) -> Grid<T> {
    Grid::new(GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY }, values)
}

proptest! {
    #[test]
    fn every_engine_finds_the_optimum_in_every_number_type((nodes, edges, goals) in edges()) {
        let of = |edges: &[(usize, usize, u16)]| edges.to_vec();
        let u32s: Vec<_> = of(&edges).into_iter().map(|(a, b, c)| (a, b, u32::from(c))).collect();
        let u64s: Vec<_> = of(&edges).into_iter().map(|(a, b, c)| (a, b, u64::from(c) << 40)).collect();
        let f32s: Vec<_> = of(&edges).into_iter().map(|(a, b, c)| (a, b, f32::from(c) / 7.0)).collect();
        let f64s: Vec<_> = of(&edges).into_iter().map(|(a, b, c)| (a, b, f64::from(c) / 7.0)).collect();
        check(nodes, &u32s, &goals)?;
        check(nodes, &u64s, &goals)?;
        check(nodes, &f32s, &goals)?;
        check(nodes, &f64s, &goals)?;
    }

    #[test]
    fn on_grids_the_engines_give_the_solvers_bits(
        (cols, cells) in (1..7_usize).prop_flat_map(|cols| {
            (Just(cols), prop::collection::vec(prop::option::weighted(0.75, 1..20_u8), cols * 5))
        }),
        corner_cutting: bool,
        paper: bool,
    ) {
        let steps = if paper { Steps::Paper } else { Steps::Fine };
        let options = PlanOptions { corner_cutting, steps, ..PlanOptions::default() };
        let Some(goal) = cells.iter().position(Option::is_some) else { return Ok(()) };
        let goals = [Cell::new(goal / cols, goal % cols)];
        let free = grid(5, cols, cells.iter().map(Option::is_some).collect());
        let costs = cells.iter().map(|cell| cell.map_or(f32::INFINITY, |c| f32::from(c) / 3.0)).collect();
        let costs = grid(5, cols, costs);
        let (free_field, cost_field) =
            (plan_free(&free, &goals, &options).unwrap(), plan_costs_f32(&costs, &goals, &options).unwrap());
        let (free_graph, cost_graph) =
            (graph_of_free(&free, &options).unwrap(), graph_of_costs_f32(&costs, &options).unwrap());
        for engine in OPTIMAL {
            let how = LayeredOptions { engine, ..Default::default() };
            let steps = plan_layered(&free_graph, &[goal], &how).unwrap().field.cost_to_go;
            prop_assert_eq!(free_field.native(), &Values::U32(steps));
            let costs = plan_layered(&cost_graph, &[goal], &how).unwrap().field.cost_to_go;
            prop_assert_eq!(cost_field.native(), &Values::F32(costs));
        }
    }
}

#[test]
fn integer_costs_that_might_overflow_are_refused_with_the_bound() {
    let graph = Graph::from_edges(3, &[(1, 0, u32::MAX / 2), (2, 1, 1)]).unwrap();
    let refused =
        PlanError::GraphCostOverflow { links: 3, dearest: f64::from(u32::MAX / 2), precision: "u32" };
    assert_eq!(plan_graph(&graph, &[0], None).unwrap_err(), refused);
    assert_eq!(plan_layered(&graph, &[0], &LayeredOptions::default()).unwrap_err(), refused);
}

#[test]
fn questions_outside_the_grid_have_no_answer_and_do_not_panic() {
    let field = plan_free(&grid(2, 2, vec![true; 4]), &[Cell::new(0, 0)], &PlanOptions::default()).unwrap();
    for cell in [Cell::new(2, 0), Cell::new(0, 2), Cell::new(usize::MAX, usize::MAX)] {
        assert_eq!(field.cost_to_go(cell), f64::INFINITY);
        assert_eq!((field.next(cell), field.path(cell)), (None, None));
    }
}
