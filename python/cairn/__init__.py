"""Cairn plans, tracks, avoids and arrives: navigation for mobile robots that explains itself."""

from cairn import errors, maps, missions, robots, terrain
from cairn._brain import __version__
from cairn.avoidance import Cvm
from cairn.graphs import (
    GraphField,
    LayeredResult,
    graph_from_edges,
    grid_graph,
    plan_graph,
    plan_layered,
)
from cairn.localisation import Localiser
from cairn.navigator import Decision, Navigator
from cairn.planning import Field, plan, plan_grid
from cairn.profile import Profile
from cairn.terrain import plan_terrain
from cairn.tracking import FuzzySystem, Tracker
from cairn.weights import plan_weights
from cairn.world import World, costmap, distance_to_occupied

__all__ = [
    "Cvm",
    "Decision",
    "Field",
    "FuzzySystem",
    "GraphField",
    "LayeredResult",
    "Localiser",
    "Navigator",
    "Profile",
    "Tracker",
    "World",
    "__version__",
    "costmap",
    "distance_to_occupied",
    "errors",
    "graph_from_edges",
    "grid_graph",
    "maps",
    "missions",
    "plan",
    "plan_graph",
    "plan_grid",
    "plan_layered",
    "plan_terrain",
    "plan_weights",
    "robots",
    "terrain",
]
