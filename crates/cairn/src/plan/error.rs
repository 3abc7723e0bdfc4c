use serde::Serialize;

use super::tiles::Simd;

/// Everything that can be wrong with what a planner is given. No path is not an error.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize)]
pub enum PlanError {
    /// The grid has no cell.
    #[error("the grid is empty: {rows} x {cols} cells; give at least one row and one column")]
    EmptyGrid {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// More cells than a 32-bit index can name.
    #[error("the grid has {cells} cells; the solver takes at most {most}")]
    GridTooLarge {
        /// Number of cells.
        cells: usize,
        /// The most it takes.
        most: usize,
    },
    /// No goal was given.
    #[error("no goal was given; give at least one")]
    NoGoal,
    /// A goal cell is not in the grid.
    #[error(
        "goal cell ({row}, {col}) is outside the grid: it has {rows} rows and {cols} columns, counted from 0"
    )]
    GoalOutsideGrid {
        /// Row asked for.
        row: i64,
        /// Column asked for.
        col: i64,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// A goal point is not on the map.
    #[error("goal ({x_m}, {y_m}) m is outside the map of {rows} x {cols} cells of {resolution_m} m")]
    GoalOutsideMap {
        /// World x \[m\].
        x_m: f64,
        /// World y \[m\].
        y_m: f64,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
        /// Side of a cell \[m\].
        resolution_m: f64,
    },
    /// A goal lies in a cell that cannot be entered.
    #[error("goal cell ({row}, {col}) is blocked; choose a free cell")]
    GoalBlocked {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
    },
    /// A start cell is not in the grid.
    #[error(
        "start cell ({row}, {col}) is outside the grid: it has {rows} rows and {cols} columns, counted from 0"
    )]
    StartOutsideGrid {
        /// Row asked for.
        row: i64,
        /// Column asked for.
        col: i64,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// A start point is not on the map.
    #[error("start ({x_m}, {y_m}) m is outside the map of {rows} x {cols} cells of {resolution_m} m")]
    StartOutsideMap {
        /// World x \[m\].
        x_m: f64,
        /// World y \[m\].
        y_m: f64,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
        /// Side of a cell \[m\].
        resolution_m: f64,
    },
    /// A cell cost is not a number.
    #[error("the cost of cell ({row}, {col}) is NaN; a cost is > 0, or inf for a blocked cell")]
    CellCostNan {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// The value found.
        value: f64,
    },
    /// A cell cost is below zero.
    #[error("the cost of cell ({row}, {col}) is {value}, negative; a cost is > 0, or inf for a blocked cell")]
    CellCostNegative {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// The value found.
        value: f64,
    },
    /// A cell cost is zero, so that going round in circles would be free.
    #[error("the cost of cell ({row}, {col}) is zero; a cost is > 0, or inf for a blocked cell")]
    CellCostZero {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// The value found.
        value: f64,
    },
    /// A finite cell cost cannot be written as f32: it would become zero or infinite.
    #[error("the cost of cell ({row}, {col}) is {value}, beyond single precision; ask for precision f64")]
    CellCostBeyondPrecision {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// The value found.
        value: f64,
    },
    /// A link is so cheap beside the cost-to-go that adding it changes nothing.
    #[error(
        "at cell ({row}, {col}) a link vanishes beside the cost-to-go {cost_to_go} ({precision}): the costs \
         differ too much in size; scale them, or ask for precision f64"
    )]
    LinkCostAbsorbed {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// Cost-to-go of the cell.
        cost_to_go: f64,
        /// Number type of the field.
        precision: &'static str,
    },
    /// A cost-to-go is larger than the number type can hold.
    #[error(
        "the cost-to-go of cell ({row}, {col}) is larger than {precision} can hold; scale the costs down, \
         or ask for precision f64"
    )]
    CostToGoOverflow {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// Number type of the field.
        precision: &'static str,
    },
    /// A cell size of a terrain that is not usable.
    #[error("a cell size of {value} m; give one between {least} and {most} m")]
    CellSizeOutOfRange {
        /// The value given.
        value: f64,
        /// Least size.
        least: f64,
        /// Greatest size.
        most: f64,
    },
    /// A parameter of a terrain model that is not usable.
    #[error("terrain model: {key} = {value}, but it must lie between {least} and {most}")]
    TerrainValueOutOfRange {
        /// The parameter.
        key: String,
        /// Its value.
        value: f64,
        /// Least value.
        least: f64,
        /// Greatest value.
        most: f64,
    },
    /// An elevation is infinite (in single precision).
    #[error("the elevation of cell ({row}, {col}) is {value}; give metres, or NaN where there is no data")]
    ElevationInfinite {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// The value found.
        value: f64,
    },
    /// Roughness and elevation differ in shape.
    #[error(
        "roughness has {rows} x {cols} cells, elevation {elevation_rows} x {elevation_cols}; give the same shape"
    )]
    RoughnessShape {
        /// Rows of the roughness.
        rows: usize,
        /// Columns of the roughness.
        cols: usize,
        /// Rows of the elevation.
        elevation_rows: usize,
        /// Columns of the elevation.
        elevation_cols: usize,
    },
    /// A roughness is negative or infinite.
    #[error("the roughness of cell ({row}, {col}) is {value}; it is >= 0 and finite, or NaN for no data")]
    RoughnessOutOfRange {
        /// Row.
        row: usize,
        /// Column.
        col: usize,
        /// The value found.
        value: f64,
    },
    /// There are not eight weights for every cell.
    #[error("{weights} weights for {rows} x {cols} cells; give one for each of the 8 moves of every cell")]
    WeightCount {
        /// Number of weights.
        weights: usize,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// The weight of a move is not a number.
    #[error(
        "the weight of move {code} out of cell ({row}, {col}) is NaN; a weight is > 0, or inf for no move"
    )]
    WeightNan {
        /// Row of the cell it leaves.
        row: usize,
        /// Column of the cell it leaves.
        col: usize,
        /// Code of the move.
        code: usize,
        /// The value found.
        value: f64,
    },
    /// The weight of a move is below zero.
    #[error(
        "the weight of move {code} out of cell ({row}, {col}) is {value}, negative; a weight is > 0, \
         or inf for no move"
    )]
    WeightNegative {
        /// Row of the cell it leaves.
        row: usize,
        /// Column of the cell it leaves.
        col: usize,
        /// Code of the move.
        code: usize,
        /// The value found.
        value: f64,
    },
    /// The weight of a move is zero, so that going round in circles could be free.
    #[error(
        "the weight of move {code} out of cell ({row}, {col}) is zero; a weight is > 0, or inf for no move"
    )]
    WeightZero {
        /// Row of the cell it leaves.
        row: usize,
        /// Column of the cell it leaves.
        col: usize,
        /// Code of the move.
        code: usize,
        /// The value found.
        value: f64,
    },
    /// A path to be priced has no cell.
    #[error("the path is empty; give at least one cell")]
    PathWithoutCells,
    /// A cell of a path is not in the grid.
    #[error(
        "cell {index} of the path, ({row}, {col}), is outside the grid: it has {rows} rows and {cols} columns, \
         counted from 0"
    )]
    PathOutsideGrid {
        /// Number of the cell in the path.
        index: usize,
        /// Its row.
        row: i64,
        /// Its column.
        col: i64,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// A cell of a path is no neighbour of the one before.
    #[error(
        "the path breaks after its cell {index}: ({next_row}, {next_col}) is no neighbour of ({row}, {col})"
    )]
    PathBroken {
        /// Number of the cell in the path.
        index: usize,
        /// Its row.
        row: usize,
        /// Its column.
        col: usize,
        /// Row of the next cell.
        next_row: usize,
        /// Column of the next cell.
        next_col: usize,
    },
    /// Zero threads were asked for.
    #[error("threads = 0: give at least 1, or none to let the solver choose")]
    NoThreads,
    /// A cell to be changed is not in the grid.
    #[error("cell ({row}, {col}) is outside the grid of {rows} x {cols} cells")]
    CellOutsideGrid {
        /// Row given.
        row: i64,
        /// Column given.
        col: i64,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
    /// There are not as many new costs as cells to be changed.
    #[error("{costs} costs for {cells} cells; give one cost for each cell")]
    UpdateLengthMismatch {
        /// Number of cells.
        cells: usize,
        /// Number of costs.
        costs: usize,
    },
    /// A field cannot take the change asked for.
    #[error("this field cannot be updated: {reason}")]
    FieldNotUpdatable {
        /// Why not, and what can be done.
        reason: &'static str,
    },
    /// Instructions were asked for that this processor does not have.
    #[error("simd = {simd}: this processor does not have it; the widest it has is {widest}")]
    SimdNotAvailable {
        /// What was asked for.
        simd: Simd,
        /// The widest level there is.
        widest: Simd,
    },
    /// A graph's `indptr` does not start at 0, end at the number of links, or have any entry.
    #[error(
        "indptr runs from {first} to {last}, but must run from 0 to the number of links, {links}, \
         with one entry more than there are nodes"
    )]
    IndptrEnds {
        /// First entry (-1 when there is none).
        first: i64,
        /// Last entry (-1 when there is none).
        last: i64,
        /// Number of links.
        links: usize,
    },
    /// A graph's `indptr` falls.
    #[error("indptr falls from {begin} to {end} at node {node}; it must never fall")]
    IndptrFalls {
        /// The node whose links these would be.
        node: usize,
        /// Its first link.
        begin: i64,
        /// One past its last link.
        end: i64,
    },
    /// There is not one cost for every link.
    #[error("{costs} costs for {links} links; give one cost for every link")]
    LinkCostCount {
        /// Number of costs.
        costs: usize,
        /// Number of links.
        links: usize,
    },
    /// A link leads from or to a node that does not exist.
    #[error("link {link} names node {node}, but there are {nodes} nodes, counted from 0")]
    NodeOutOfRange {
        /// Number of the link.
        link: usize,
        /// The node it names.
        node: i64,
        /// Number of nodes.
        nodes: usize,
    },
    /// More nodes or links than a 32-bit index can name.
    #[error("the graph has {nodes} nodes and {links} links; at most {most} of each are taken")]
    GraphTooLarge {
        /// Number of nodes.
        nodes: usize,
        /// Number of links.
        links: usize,
        /// The most of each.
        most: usize,
    },
    /// A link cost is not a number.
    #[error(
        "link {link} ({source_node} -> {target_node}) has the cost NaN; a cost is >= 0, or inf for no link"
    )]
    LinkCostNan {
        /// Number of the link.
        link: usize,
        /// Node it leaves.
        source_node: usize,
        /// Node it enters.
        target_node: usize,
        /// The value found.
        value: f64,
    },
    /// A link cost is below zero.
    #[error(
        "link {link} ({source_node} -> {target_node}) has the cost {value}, negative; a cost is >= 0, or inf for no link"
    )]
    LinkCostNegative {
        /// Number of the link.
        link: usize,
        /// Node it leaves.
        source_node: usize,
        /// Node it enters.
        target_node: usize,
        /// The value found.
        value: f64,
    },
    /// The longest way through a graph may not fit into the cost type.
    #[error(
        "{links} links at the dearest cost {dearest} could exceed what {precision} holds; \
         scale the costs down or use floating point"
    )]
    GraphCostOverflow {
        /// Most links of a walk that is looked at.
        links: usize,
        /// The dearest link.
        dearest: f64,
        /// Number type of the costs.
        precision: &'static str,
    },
    /// A goal is not a node of the graph.
    #[error("goal {node} is not a node: there are {nodes} nodes, counted from 0")]
    GoalNotANode {
        /// The goal asked for.
        node: i64,
        /// Number of nodes.
        nodes: usize,
    },
    /// A start is not a node of the graph.
    #[error("start {node} is not a node: there are {nodes} nodes, counted from 0")]
    StartNotANode {
        /// The start asked for.
        node: i64,
        /// Number of nodes.
        nodes: usize,
    },
    /// The layered solution graph was given no level.
    #[error("max_levels = 0: the layered solution graph needs at least one level")]
    NoLevels,
}
