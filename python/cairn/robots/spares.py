"""Boxes put down during a run, in a physics engine whose bodies are all made beforehand.

Spare bodies are parked under the floor. To put a box down, one of them is given its size and moved
to its place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cairn.robots import mjcf
from cairn.robots.scene import Box, Stage


@dataclass
class _Spare:
    body: int
    geom: int
    mocap: int
    plays: int | None = None  # number of the stage's box


class Spares:
    """The spare bodies of one model."""

    def __init__(self, model: Any, count: int) -> None:
        """Find the `count` bodies that `mjcf.model_text` has parked."""
        self._model = model
        self._spares = []
        for i in range(count):
            body, geom = model.body(f"spare{i}"), model.geom(f"spare{i}")
            self._spares.append(_Spare(int(body.id), int(geom.id), int(body.mocapid[0])))

    def follow(self, stage: Stage, data: Any) -> dict[int, str]:
        """Let a spare body stand wherever a box does that was put down during the run.

        Returns:
            Names of the boxes by geom, for geoms that play another box than before.
        """
        names: dict[int, str] = {}
        for spare in self._spares:
            if spare.plays is not None and stage.gone[spare.plays]:
                spare.plays = None
                data.mocap_pos[spare.mocap, 2] = mjcf.PARKED_Z_M
        playing = {spare.plays for spare in self._spares}
        waiting = [spare for spare in self._spares if spare.plays is None]
        for i in range(len(stage.scene.boxes), len(stage.boxes)):
            if i not in playing and not stage.gone[i]:
                # The stage puts no more boxes down than there are spares.
                spare = waiting.pop()
                spare.plays = i
                self._shape(spare, stage.boxes[i], data)
                names[spare.geom] = stage.boxes[i].name
        for spare in self._spares:
            if spare.plays is not None:
                height_m = stage.boxes[spare.plays].height_m
                z = height_m / 2 if stage.standing[spare.plays] else mjcf.PARKED_Z_M
                data.mocap_pos[spare.mocap, 2] = z
        return names

    def _shape(self, spare: _Spare, box: Box, data: Any) -> None:
        """Give a body the box's size and place, with all bounds that the engine keeps of it."""
        model = self._model
        half = np.array([box.length_m, box.width_m, box.height_m]) / 2
        model.geom_size[spare.geom] = half
        model.geom_rbound[spare.geom] = float(np.linalg.norm(half))
        model.geom_aabb[spare.geom] = (0.0, 0.0, 0.0, *half)
        first = int(model.body_bvhadr[spare.body])
        model.bvh_aabb[first : first + int(model.body_bvhnum[spare.body])] = (0.0, 0.0, 0.0, *half)
        data.mocap_pos[spare.mocap] = (box.x, box.y, mjcf.PARKED_Z_M)
        turn = box.heading / 2
        data.mocap_quat[spare.mocap] = (math.cos(turn), 0.0, 0.0, math.sin(turn))
