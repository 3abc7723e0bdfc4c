//! Solvers to be timed against one another. Each keeps its memory from run to run, and the time is
//! taken here, around the solver alone: no conversion, no array handed out.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use cairn::geometry::Pose2;
use cairn::plan::peers::{
    Buckets, CellPrice, FreeLinks, Heap, MeanLinks, Peer, Queue, SlopeLinks, slope_range,
};
use cairn::plan::terrain::{AnyTerrainLinks, LinkCost, TerrainLinks, TerrainModel};
use cairn::plan::{Field, GridPlanner, MOVES, NewCosts, PlanError, PlanOptions, Update, Values};
use cairn::world::{Cell, Grid, GridGeometry, perfect_maze};
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::convert::grid_of;
use crate::errors::{InputError, to_python};
use crate::terrain::model_of;

/// A map in one of the kinds that solvers take.
#[derive(FromPyObject)]
enum Map<'py> {
    /// True where free; steps of 985 and 1393.
    Free(PyReadonlyArray2<'py, bool>),
    /// 1..255, 0 blocked; links of (a + b) · 985 or 1393.
    Weights(PyReadonlyArray2<'py, u8>),
    /// Cost per unit length, infinite blocked; links of (a + b) · ½ or √½.
    Costs(PyReadonlyArray2<'py, f32>),
}

/// What can be run again and again on one map.
trait Timed: Send + Sync {
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError>;
    fn field(&self) -> (Native<'_>, &[i8]);
    /// Changes cells of the field that was found last; None if it cannot.
    fn update(&mut self, cells: &[Cell], new: &Changed<'_>) -> Option<Result<Update, PlanError>> {
        let _ = (cells, new);
        None
    }
}

/// New values of cells, in their kind.
#[derive(FromPyObject)]
enum Changed<'py> {
    Free(PyReadonlyArray1<'py, bool>),
    Costs(PyReadonlyArray1<'py, f32>),
}

/// The share of a full solution's work after which a repair gives up, as in `cairn.Field.update`.
const GIVE_UP: f64 = 0.1;

/// Costs-to-go in the number type they were found in.
enum Native<'a> {
    U32(&'a [u32]),
    U64(&'a [u64]),
    F32(&'a [f32]),
    F64(&'a [f64]),
}

type Solve<T> = fn(&mut GridPlanner, &Arc<Grid<T>>, &[Cell], &PlanOptions) -> Result<Field, PlanError>;

/// The production solver with its memory. The one place that knows how it is called.
struct Cairn<T> {
    grid: Arc<Grid<T>>,
    solve: Solve<T>,
    planner: GridPlanner,
    field: Option<Field>,
}

impl<T> Cairn<T> {
    fn boxed(grid: Grid<T>, solve: Solve<T>) -> Box<Self> {
        let grid = Arc::new(grid);
        Box::new(Self { grid, solve, planner: GridPlanner::default(), field: None })
    }
}

impl<T: Send + Sync> Timed for Cairn<T> {
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError> {
        if let Some(last) = self.field.take() {
            self.planner.recycle(last);
        }
        self.field = Some((self.solve)(&mut self.planner, &self.grid, goals, options)?);
        Ok(())
    }

    fn field(&self) -> (Native<'_>, &[i8]) {
        planned(self.field.as_ref())
    }

    fn update(&mut self, cells: &[Cell], new: &Changed<'_>) -> Option<Result<Update, PlanError>> {
        let new = match new {
            Changed::Free(free) => NewCosts::Free(free.as_slice().ok()?),
            Changed::Costs(costs) => NewCosts::F32(costs.as_slice().ok()?),
        };
        Some(self.field.as_mut()?.update(cells, new, GIVE_UP))
    }
}

/// A plain planner in whole numbers, in u64 from the first time that u32 was too small.
struct Whole<T, Q32, Q64> {
    grid: Grid<T>,
    padded: Vec<T>,
    narrow: Peer<u32, Q32>,
    broad: Option<Peer<u64, Q64>>,
    queue: fn() -> Q64,
}

impl<T, Q32: Queue<u32>, Q64: Queue<u64>> Whole<T, Q32, Q64> {
    fn boxed(grid: Grid<T>, narrow: Q32, queue: fn() -> Q64) -> Box<Self> {
        Box::new(Self { grid, padded: vec![], narrow: Peer::new(narrow), broad: None, queue })
    }

    fn planned(&self) -> (Native<'_>, &[i8]) {
        match &self.broad {
            None => (Native::U32(self.narrow.values()), self.narrow.next_codes()),
            Some(broad) => (Native::U64(broad.values()), broad.next_codes()),
        }
    }
}

impl<Q32: Queue<u32> + Send + Sync, Q64: Queue<u64> + Send + Sync> Timed for Whole<bool, Q32, Q64> {
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError> {
        let Self { grid: Grid { geometry, values }, narrow, broad, .. } = self;
        let (straight, diagonal) = options.steps.lengths();
        if broad.is_none() {
            let links = &mut FreeLinks::new(values, [straight, diagonal]);
            if narrow.plan(geometry, links, goals, options)? {
                return Ok(());
            }
        }
        let broad = broad.get_or_insert_with(|| Peer::new((self.queue)()));
        let links = &mut FreeLinks::new(values, [u64::from(straight), u64::from(diagonal)]);
        broad.plan(geometry, links, goals, options).map(|_| ())
    }

    fn field(&self) -> (Native<'_>, &[i8]) {
        self.planned()
    }
}

impl<Q32: Queue<u32> + Send + Sync, Q64: Queue<u64> + Send + Sync> Timed for Whole<u8, Q32, Q64> {
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError> {
        let Self { grid: Grid { geometry, values }, padded, narrow, broad, .. } = self;
        if broad.is_none() && narrow.plan(geometry, &mut MeanLinks::new(values, padded), goals, options)? {
            return Ok(());
        }
        let broad = broad.get_or_insert_with(|| Peer::new((self.queue)()));
        broad.plan(geometry, &mut MeanLinks::new(values, padded), goals, options).map(|_| ())
    }

    fn field(&self) -> (Native<'_>, &[i8]) {
        self.planned()
    }
}

/// A plain planner in single precision.
struct Single<Q> {
    grid: Grid<f32>,
    padded: Vec<f32>,
    peer: Peer<f32, Q>,
}

impl<Q: Queue<f32> + Send + Sync> Timed for Single<Q>
where
    f32: CellPrice<f32>,
{
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError> {
        let links = &mut MeanLinks::new(&self.grid.values, &mut self.padded);
        self.peer.plan(&self.grid.geometry, links, goals, options).map(|_| ())
    }

    fn field(&self) -> (Native<'_>, &[i8]) {
        (Native::F32(self.peer.values()), self.peer.next_codes())
    }
}

/// The production solver over terrain.
struct CairnOverTerrain {
    elevation: Grid<f32>,
    roughness: Grid<f32>,
    model: TerrainModel,
    planner: GridPlanner,
    field: Option<Field>,
}

impl Timed for CairnOverTerrain {
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError> {
        let Self { elevation, roughness, model, planner, field } = self;
        if let Some(last) = field.take() {
            planner.recycle(last);
        }
        *field = Some(planner.plan_terrain(elevation, Some(roughness), model, goals, options)?);
        Ok(())
    }

    fn field(&self) -> (Native<'_>, &[i8]) {
        planned(self.field.as_ref())
    }
}

/// A plain planner over terrain, which is given the allowed moves.
struct Slopes<M, Q> {
    elevation: Grid<f32>,
    roughness: Vec<f32>,
    allowed: Vec<u8>,
    model: M,
    range: (f32, f32),
    padded: [Vec<f32>; 2],
    peer: Peer<f32, Q>,
}

impl<M: LinkCost + 'static, Q: Queue<f32> + Send + Sync + 'static> Slopes<M, Q> {
    fn boxed(
        elevation: Grid<f32>,
        roughness: Vec<f32>,
        allowed: Vec<u8>,
        model: M,
        queue: Q,
    ) -> Box<dyn Timed> {
        let range = slope_range(&elevation.values, &roughness, &model, elevation.geometry.cols);
        let (padded, peer) = ([vec![], vec![]], Peer::new(queue));
        Box::new(Self { elevation, roughness, allowed, model, range, padded, peer })
    }
}

impl<M: LinkCost, Q: Queue<f32> + Send + Sync> Timed for Slopes<M, Q> {
    fn run(&mut self, goals: &[Cell], options: &PlanOptions) -> Result<(), PlanError> {
        let Self { elevation, roughness, allowed, model, range, padded, peer } = self;
        let links = &mut SlopeLinks::new(allowed, &elevation.values, roughness, *model, *range, padded);
        peer.plan(&elevation.geometry, links, goals, options).map(|_| ())
    }

    fn field(&self) -> (Native<'_>, &[i8]) {
        (Native::F32(self.peer.values()), self.peer.next_codes())
    }
}

fn planned(field: Option<&Field>) -> (Native<'_>, &[i8]) {
    let Some(field) = field else { return (Native::U32(&[]), &[]) };
    let native = match field.native() {
        Values::U32(values) => Native::U32(values),
        Values::U64(values) => Native::U64(values),
        Values::F32(values) => Native::F32(values),
        Values::F64(values) => Native::F64(values),
    };
    (native, field.next_codes())
}

fn timed_over_terrain(
    solver: &str,
    elevation: Grid<f32>,
    roughness: Grid<f32>,
    model: TerrainModel,
    corner_cutting: bool,
) -> Result<Option<Box<dyn Timed>>, PlanError> {
    if solver == "cairn" {
        let planner = GridPlanner::default();
        return Ok(Some(Box::new(CairnOverTerrain { elevation, roughness, model, planner, field: None })));
    }
    macro_rules! slopes {
        ($links:ident) => {{
            let (allowed, model) = ($links.allowed, $links.model);
            let roughness = roughness.values.clone();
            match solver {
                "dial" => Slopes::boxed(elevation.clone(), roughness, allowed, model, Buckets::wide()),
                "heap" => Slopes::boxed(elevation.clone(), roughness, allowed, model, Heap::default()),
                _ => return Ok(None),
            }
        }};
    }
    Ok(Some(match AnyTerrainLinks::new(&elevation, Some(&roughness), &model, corner_cutting)? {
        AnyTerrainLinks::P3atEnergy(links) => slopes!(links),
        AnyTerrainLinks::P3atTime(links) => slopes!(links),
        AnyTerrainLinks::Tobler(links) => slopes!(links),
    }))
}

fn grid<T: Element + Copy>(map: &PyReadonlyArray2<'_, T>) -> Grid<T> {
    grid_of(map, 1.0, Pose2::IDENTITY)
}

fn timed(solver: &str, map: &Map<'_>) -> Option<Box<dyn Timed>> {
    Some(match (solver, map) {
        ("cairn", Map::Free(map)) => {
            Cairn::boxed(grid(map), |planner, grid, goals, options| planner.plan_free(grid, goals, options))
        }
        ("cairn", Map::Costs(map)) => Cairn::boxed(grid(map), |planner, grid, goals, options| {
            planner.plan_costs_f32(Arc::clone(grid), goals, options)
        }),
        ("dial", Map::Free(map)) => Whole::boxed(grid(map), Buckets::unit_wide(), Buckets::unit_wide),
        ("dial-wide", Map::Free(map)) => Whole::boxed(grid(map), Buckets::wide(), Buckets::wide),
        ("heap", Map::Free(map)) => Whole::boxed(grid(map), Heap::default(), Heap::default),
        ("dial", Map::Weights(map)) => Whole::boxed(grid(map), Buckets::wide(), Buckets::wide),
        ("heap", Map::Weights(map)) => Whole::boxed(grid(map), Heap::default(), Heap::default),
        ("dial", Map::Costs(map)) => {
            Box::new(Single { grid: grid(map), padded: vec![], peer: Peer::new(Buckets::wide()) })
        }
        ("heap", Map::Costs(map)) => {
            Box::new(Single { grid: grid(map), padded: vec![], peer: Peer::new(Heap::default()) })
        }
        _ => return None,
    })
}

/// A solver and a map, ready to be run and timed.
#[pyclass(module = "cairn._brain")]
pub struct TimedSolver {
    solver: Box<dyn Timed>,
    goals: Vec<Cell>,
    options: PlanOptions,
    shape: [usize; 2],
}

#[pymethods]
impl TimedSolver {
    #[new]
    fn new(
        solver: &str,
        map: Map<'_>,
        goals: Vec<(usize, usize)>,
        corner_cutting: bool,
        threads: usize,
    ) -> PyResult<Self> {
        let shape = match &map {
            Map::Free(map) => map.as_array().dim(),
            Map::Weights(map) => map.as_array().dim(),
            Map::Costs(map) => map.as_array().dim(),
        };
        let solver = timed(solver, &map).ok_or_else(|| refused(solver))?;
        Ok(Self::made(solver, goals, corner_cutting, threads, shape))
    }

    /// A solver over terrain; `model` as `cairn.terrain` gives it.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn terrain(
        solver: &str,
        elevation: PyReadonlyArray2<'_, f32>,
        roughness: PyReadonlyArray2<'_, f32>,
        cell_size_m: f64,
        model: &Bound<'_, PyAny>,
        goals: Vec<(usize, usize)>,
        corner_cutting: bool,
        threads: usize,
    ) -> PyResult<Self> {
        let shape = elevation.as_array().dim();
        let laid = |map: &PyReadonlyArray2<'_, f32>| grid_of(map, cell_size_m, Pose2::IDENTITY);
        let (elevation, roughness, model) = (laid(&elevation), laid(&roughness), model_of(model)?);
        let found = timed_over_terrain(solver, elevation, roughness, model, corner_cutting);
        let solver = found.map_err(|e| to_python(&e))?.ok_or_else(|| refused(solver))?;
        Ok(Self::made(solver, goals, corner_cutting, threads, shape))
    }

    /// Solves, and returns how long it took [s].
    fn run(&mut self, py: Python<'_>) -> PyResult<f64> {
        let Self { solver, goals, options, .. } = self;
        let timed = py.detach(|| {
            let begin = Instant::now();
            solver.run(goals, options).map(|()| begin.elapsed().as_secs_f64())
        });
        timed.map_err(|e| to_python(&e))
    }

    /// Gives cells new values and repairs the field of the last run: how long that took [s], and whether it
    /// was solved anew after all.
    fn update(&mut self, cells: Vec<(usize, usize)>, new: Changed<'_>) -> PyResult<(f64, bool)> {
        let cells: Vec<Cell> = cells.into_iter().map(|(row, col)| Cell::new(row, col)).collect();
        let begin = Instant::now();
        let update = self.solver.update(&cells, &new);
        let took = begin.elapsed().as_secs_f64();
        let update = update.ok_or_else(|| refused("update"))?.map_err(|e| to_python(&e))?;
        Ok((took, update.anew))
    }

    /// A copy of the costs-to-go of the last run.
    fn native<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        match self.solver.field().0 {
            Native::U32(values) => shaped(py, values, self.shape),
            Native::U64(values) => shaped(py, values, self.shape),
            Native::F32(values) => shaped(py, values, self.shape),
            Native::F64(values) => shaped(py, values, self.shape),
        }
    }

    /// A copy of the next cells' codes of the last run.
    fn next_node<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        shaped(py, self.solver.field().1, self.shape)
    }
}

impl TimedSolver {
    fn made(
        solver: Box<dyn Timed>,
        goals: Vec<(usize, usize)>,
        corner_cutting: bool,
        threads: usize,
        (rows, cols): (usize, usize),
    ) -> Self {
        let goals = goals.into_iter().map(|(row, col)| Cell::new(row, col)).collect();
        let options = PlanOptions { corner_cutting, threads: Some(threads), ..PlanOptions::default() };
        Self { solver, goals, options, shape: [rows, cols] }
    }
}

fn refused(solver: &str) -> PyErr {
    let reason = format!("no solver `{solver}` for a map of this kind");
    to_python(&InputError::SettingsInvalid { part: "benchmark".to_owned(), reason })
}

fn shaped<'py, T: Element + Copy>(
    py: Python<'py>,
    values: &[T],
    shape: [usize; 2],
) -> PyResult<Bound<'py, PyAny>> {
    Ok(values.to_vec().into_pyarray(py).reshape(shape)?.into_any())
}

type ReversedLinks<'py> = (Bound<'py, PyArray1<i64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<f64>>);

/// CSR arrays of a terrain's links turned round: from each cell to those that may move to it, at the cost of
/// that move, for planners of graphs that search from the goal.
#[pyfunction]
fn reversed_terrain_links<'py>(
    py: Python<'py>,
    elevation: PyReadonlyArray2<'py, f32>,
    roughness: PyReadonlyArray2<'py, f32>,
    cell_size_m: f64,
    model: &Bound<'py, PyAny>,
    corner_cutting: bool,
) -> PyResult<ReversedLinks<'py>> {
    fn reversed<M: LinkCost>(links: &TerrainLinks<'_, M>) -> (Vec<i64>, Vec<i32>, Vec<f64>) {
        let cols = links.geometry.cols as isize;
        let (mut indptr, mut indices, mut costs) = (vec![0], vec![], vec![]);
        for head in 0..links.allowed.len() {
            for (code, (down, right)) in MOVES.into_iter().enumerate() {
                let (row, col) = (head as isize / cols - down, head as isize % cols - right);
                let inside = row >= 0 && col >= 0 && col < cols && row < links.geometry.rows as isize;
                let tail = (row * cols + col) as usize;
                if inside && links.allowed[tail] >> code & 1 == 1 {
                    indices.push(tail as i32);
                    costs.push(f64::from(links.cost(tail, code)));
                }
            }
            indptr.push(indices.len() as i64);
        }
        (indptr, indices, costs)
    }
    let laid = |map: &PyReadonlyArray2<'_, f32>| grid_of(map, cell_size_m, Pose2::IDENTITY);
    let (elevation, roughness, model) = (laid(&elevation), laid(&roughness), model_of(model)?);
    let links = AnyTerrainLinks::new(&elevation, Some(&roughness), &model, corner_cutting);
    let (indptr, indices, costs) = match &links.map_err(|e| to_python(&e))? {
        AnyTerrainLinks::P3atEnergy(links) => reversed(links),
        AnyTerrainLinks::P3atTime(links) => reversed(links),
        AnyTerrainLinks::Tobler(links) => reversed(links),
    };
    Ok((indptr.into_pyarray(py), indices.into_pyarray(py), costs.into_pyarray(py)))
}

/// How long it takes to copy this many u32, memory touched before [s].
#[pyfunction]
fn copy_seconds(py: Python<'_>, cells: usize) -> f64 {
    py.detach(|| {
        let (from, mut to) = (vec![1_u32; cells], vec![2_u32; cells]);
        let begin = Instant::now();
        to.copy_from_slice(std::hint::black_box(&from));
        let took = begin.elapsed().as_secs_f64();
        std::hint::black_box(&to);
        took
    })
}

/// A maze of one way between any two places, True where free; None where no room fits.
#[pyfunction(name = "perfect_maze")]
fn maze<'py>(
    py: Python<'py>,
    rows: usize,
    cols: usize,
    corridor: usize,
    seed: u64,
) -> PyResult<Option<Bound<'py, PyArray2<bool>>>> {
    let geometry = GridGeometry { rows, cols, resolution_m: 1.0, world_from_grid: Pose2::IDENTITY };
    let maze = py.detach(|| perfect_maze(geometry, corridor, seed));
    maze.map(|maze| maze.values.into_pyarray(py).reshape([rows, cols])).transpose()
}

/// How the brain was built, and what the processor could do beyond that.
#[pyfunction]
fn build_info() -> BTreeMap<&'static str, String> {
    let profile = if cfg!(debug_assertions) { "debug" } else { "release" };
    let compiled = if cfg!(target_feature = "avx512f") {
        "avx512"
    } else if cfg!(target_feature = "avx2") {
        "avx2"
    } else {
        "baseline"
    };
    #[cfg(target_arch = "x86_64")]
    let found = if std::arch::is_x86_feature_detected!("avx512f") {
        "avx512"
    } else if std::arch::is_x86_feature_detected!("avx2") {
        "avx2"
    } else {
        "baseline"
    };
    #[cfg(not(target_arch = "x86_64"))]
    let found = "baseline";
    BTreeMap::from([
        ("profile", profile.to_owned()),
        ("target", format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)),
        ("compiled_for", compiled.to_owned()),
        ("processor_has", found.to_owned()),
    ])
}

pub fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<TimedSolver>()?;
    module.add_function(wrap_pyfunction!(build_info, module)?)?;
    module.add_function(wrap_pyfunction!(reversed_terrain_links, module)?)?;
    module.add_function(wrap_pyfunction!(copy_seconds, module)?)?;
    module.add_function(wrap_pyfunction!(maze, module)?)
}
