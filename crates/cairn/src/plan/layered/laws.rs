//! What the task graphs of the engines keep to.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

use super::layers::Layers;
use super::schedule::{Board, waits};
use super::{
    Engine, LayeredOptions, LayeredPlan, Schedule, Task, Timed, plan_layered, play_out, trace_layered,
};
use crate::plan::Graph;

const ENGINES: [Engine; 2] = [Engine::Levelled, Engine::InPlace];
const SCHEDULES: [Schedule; 2] = [Schedule::Fronts, Schedule::Wavefront];

struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % limit
    }
}

/// Nodes in a long row with some links further: many layers, one-way links that rise by several.
fn random_graph(random: &mut Random, most_nodes: usize) -> Graph<u64> {
    let nodes = 1 + random.below(most_nodes);
    let reach = 1 + random.below(6);
    let edges: Vec<_> = (0..random.below(5 * nodes))
        .map(|_| {
            let from = random.below(nodes);
            let to = match random.below(10) {
                0 => random.below(nodes),
                _ => (from + random.below(2 * reach + 1)).saturating_sub(reach).min(nodes - 1),
            };
            (from, to, random.below(20) as u64)
        })
        .collect();
    Graph::from_edges(nodes, &edges).unwrap()
}

fn all_options(random: &mut Random) -> Vec<LayeredOptions> {
    let max_levels = (random.below(2) == 0).then(|| 1 + random.below(12));
    let early_stop = random.below(3) > 0;
    let mut all = Vec::new();
    for engine in ENGINES {
        for schedule in SCHEDULES {
            all.push(LayeredOptions {
                engine,
                schedule,
                max_levels,
                early_stop,
                record_sequence: true,
                record_walks: true,
                threads: None,
            });
        }
    }
    all
}

#[test]
fn the_task_graph_gives_the_serial_engines_bits_for_every_schedule_and_number_of_threads() {
    let mut random = Random(1);
    for _ in 0..250 {
        let graph = random_graph(&mut random, 40);
        let goals = [random.below(graph.nodes()), random.below(graph.nodes())];
        for options in all_options(&mut random) {
            let serial = plan_layered(&graph, &goals, &options).unwrap();
            for threads in 1..=3 {
                let threads = Some(threads);
                let several = LayeredOptions { threads, ..options.clone() };
                assert_eq!(plan_layered(&graph, &goals, &several).unwrap(), serial, "{several:?}");
            }
        }
    }
}

/// Begin and end of every task, (level, layer).
type Times = HashMap<(u32, u32), (u64, u64)>;

/// That the first, if it ran, ended before the second, if it ran, began.
fn before(times: &Times, first: (u32, u32), second: (u32, u32)) {
    if let (Some(&(_, end)), Some(&(begin, _))) = (times.get(&first), times.get(&second)) {
        assert!(end < begin, "{second:?} began at {begin}, {first:?} ended at {end}");
    }
}

fn check_order(graph: &Graph<u64>, plan: &LayeredPlan<u64>, engine: Engine, tasks: &[Timed]) {
    let times: Times = tasks.iter().map(|t| ((t.task.level, t.task.layer), (t.begin, t.end))).collect();
    assert_eq!(times.len(), tasks.len(), "no task runs twice");
    for level in 1..=plan.levels as u32 {
        for layer in 1..=level.min(plan.layers as u32) {
            assert!(times.contains_key(&(level, layer)), "no task is left out");
            before(&times, (level, layer), (level + 1, layer));
        }
    }
    let most = times.keys().map(|key| key.0).max().unwrap_or(0);
    for node in 0..graph.nodes() {
        for (next, _) in graph.links_from(node) {
            let (Some(from), Some(to)) = (plan.layer[node], plan.layer[next]) else { continue };
            if from == 0 || to == 0 || from == to {
                continue;
            }
            for level in 1..=most {
                // What is read of `to` is final, and is read before it is overwritten.
                let (read, overwritten) = match engine {
                    Engine::InPlace if to < from => (level, level + 1),
                    Engine::InPlace => (level - 1, level),
                    _ => (level - 1, level + 1),
                };
                before(&times, (read, to), (level, from));
                before(&times, (level, from), (overwritten, to));
            }
        }
    }
}

#[test]
fn no_task_begins_before_its_inputs_are_final_or_overwrites_what_is_still_to_be_read() {
    let mut random = Random(2);
    let ticks = AtomicU64::new(0);
    for _ in 0..150 {
        let graph = random_graph(&mut random, 60);
        let goals = [random.below(graph.nodes())];
        for options in all_options(&mut random) {
            let engine = options.engine;
            let options = LayeredOptions { threads: Some(1 + random.below(4)), ..options };
            let tick = || ticks.fetch_add(1, Ordering::SeqCst);
            let (plan, trace) = trace_layered(&graph, &goals, &options, &tick).unwrap();
            check_order(&graph, &plan, engine, &trace.tasks);
        }
    }
}

#[test]
fn a_wavefront_takes_up_a_level_before_the_one_above_is_complete_and_fronts_do_not() {
    let both_ways = (1..=6_usize).flat_map(|node| [(node, node - 1, 1_u64), (node - 1, node, 1)]);
    let graph = Graph::from_edges(7, &both_ways.collect::<Vec<_>>()).unwrap();
    let layers = Layers::new(&graph, &[0]);
    for schedule in SCHEDULES {
        let mut board = Board::new(waits(&layers, Engine::Levelled), schedule, 0, 60, false);
        while board.levels < 6 {
            let task = board.take().unwrap();
            board.complete(task, true);
        }
        for layer in 1..=2 {
            assert_eq!(board.take(), Some(Task { level: 7, layer }));
            board.complete(Task { level: 7, layer }, true);
        }
        let offered: Vec<Task> = std::iter::from_fn(|| board.take()).collect();
        let early = offered.contains(&Task { level: 8, layer: 1 });
        assert_eq!(early, schedule == Schedule::Wavefront);
    }
}

#[test]
fn played_out_a_schedule_takes_the_sum_on_one_worker_and_keeps_to_the_order_on_many() {
    let mut random = Random(4);
    for _ in 0..60 {
        let graph = random_graph(&mut random, 40);
        for options in all_options(&mut random) {
            let (engine, schedule) = (options.engine, options.schedule);
            let options = LayeredOptions { threads: Some(1), ..options };
            let (plan, trace) = trace_layered(&graph, &[0], &options, &|| 0).unwrap();
            let slope = if engine == Engine::InPlace { plan.greatest_rise + 1 } else { 0 };
            let done = trace.tasks.iter().filter(|timed| timed.task.level <= plan.levels as u32);
            let tasks: Vec<(Task, u64)> =
                done.map(|timed| (timed.task, 1 + random.below(9) as u64)).collect();
            let sum: u64 = tasks.iter().map(|task| task.1).sum();
            for workers in [1, 2, 7, 100] {
                let times = play_out(&trace.waits, schedule, slope, &tasks, workers).unwrap();
                let last = times.iter().map(|time| time.1).max().unwrap_or(0);
                assert!(last <= sum && last * workers as u64 >= sum);
                assert!(workers > 1 || last == sum);
                let timed: Vec<Timed> = tasks
                    .iter()
                    .zip(&times)
                    // A tick between end and begin, as the check wants what follows to be later.
                    .map(|(task, &(begin, end))| Timed {
                        task: task.0,
                        thread: 0,
                        begin: 2 * begin + 1,
                        end: 2 * end,
                    })
                    .collect();
                check_order(&graph, &plan, engine, &timed);
            }
            assert!(tasks.len() < 2 || play_out(&trace.waits, schedule, slope, &tasks[1..], 1).is_none());
        }
    }
}
