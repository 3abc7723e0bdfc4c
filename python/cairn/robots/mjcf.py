"""A scene and its robots as a MuJoCo model, written as MJCF text.

Collision bits: the floor meets wheels; walls and boxes meet chassis; chassis meet each other.
Nothing else collides, so a building of many walls costs no more than those near a robot. Wheels
stay within the outline, which makes the chassis box alone judge contact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from xml.sax.saxutils import quoteattr

from cairn.profile import Physics, Profile
from cairn.robots.rectangles import Floats
from cairn.robots.scene import Scene

TIMESTEP_S = 0.0025

# Where a box waits that does not stand: under the floor, out of every ray's and robot's way.
PARKED_Z_M = -20.0

_FLOOR, _STANDING, _CHASSIS = 1, 2, 4

# Geom groups, for rays: 0 floor, 1 standing things, 2 chassis, 3 wheels.
RAY_GROUPS = (0, 1, 1, 0, 0, 0)

_OPTION = (
    f'<option timestep="{TIMESTEP_S}" integrator="implicitfast" cone="elliptic" impratio="1" '
    'solver="Newton" iterations="30" tolerance="1e-10" gravity="0 0 -9.81"/>'
)

# Inertia of each geared motor, felt at its wheel. Far more than a wheel's own: the engine's contact
# solver does not know of the servo's implicit step and would answer its torque as if nothing held
# the wheel, rocking the body.
_ARMATURE_KGM2 = 0.5

WHEELS = ("front_left", "rear_left", "front_right", "rear_right")


def model_text(scene: Scene, robots: Sequence[tuple[Profile, Physics]]) -> str:
    """MJCF of a scene with robots `r0`, `r1`, ... at the origin.

    Static geoms are the walls and the boxes that stand throughout, named `wall<i>` and `box<i>`;
    the other boxes are mocap bodies of those names. Spare boxes are mocap bodies `spare<i>`.
    """
    lines = [
        '<mujoco model="cairn">',
        '<compiler angle="radian" autolimits="true"/>',
        _OPTION,
        '<size memory="64M"/>',
        "<worldbody>",
        f'<geom name="floor" type="plane" size="0 0 1" group="0" contype="{_FLOOR}" '
        'conaffinity="0"/>',
    ]
    for i, wall in enumerate(scene.walls):
        lines.append(_standing(f"wall{i}", wall, scene.wall_height_m))
    for i, box in enumerate(scene.boxes):
        if stands_throughout(scene, i):
            lines.append(_standing(f"box{i}", box.rectangle, box.height_m))
        else:
            half = box.height_m / 2
            lines.append(
                f'<body name="box{i}" mocap="true" pos="{box.x!r} {box.y!r} {PARKED_Z_M}" '
                f'euler="0 0 {box.heading!r}"><geom name="box{i}" type="box" group="1" '
                f'contype="{_STANDING}" conaffinity="0" friction="0.3 0.005 0.0001" '
                f'size="{box.length_m / 2!r} {box.width_m / 2!r} {half!r}"/></body>'
            )
    for i in range(scene.spares):
        # Apart from each other: nothing of them touches while they are parked.
        lines.append(
            f'<body name="spare{i}" mocap="true" pos="{2.0 * i!r} 0 {PARKED_Z_M}">'
            f'<geom name="spare{i}" type="box" group="1" contype="{_STANDING}" conaffinity="0" '
            'friction="0.3 0.005 0.0001" size="0.25 0.25 0.25"/></body>'
        )
    for i, (profile, physics) in enumerate(robots):
        lines.append(_robot(f"r{i}", profile, physics))
    lines.append("</worldbody><actuator>")
    for i, (_, physics) in enumerate(robots):
        for wheel in WHEELS:
            lines.append(
                f'<velocity name="r{i}_{wheel}" joint="r{i}_{wheel}" kv="{physics.servo_gain!r}"/>'
            )
    lines.append("</actuator><sensor>")
    for i in range(len(robots)):
        lines.append(f'<gyro name="r{i}_gyro" site="r{i}_centre"/>')
        for wheel in WHEELS:
            lines.append(f'<touch name="r{i}_{wheel}" site="r{i}_{wheel}"/>')
    lines.append("</sensor></mujoco>")
    return "\n".join(lines)


def stands_throughout(scene: Scene, index: int) -> bool:
    """Whether a box of the scene neither comes nor goes."""
    box = scene.boxes[index]
    return box.from_s <= 0 and math.isinf(box.until_s) and box.appears_within_m is None


def _standing(name: str, rectangle: Floats, height_m: float) -> str:
    x, y, half_length, half_width, c, s = (float(v) for v in rectangle)
    half = math.atan2(s, c) / 2
    return (
        f'<geom name={quoteattr(name)} type="box" group="1" '
        f'contype="{_STANDING}" conaffinity="0" friction="0.3 0.005 0.0001" '
        f'pos="{x!r} {y!r} {height_m / 2!r}" quat="{math.cos(half)!r} 0 0 {math.sin(half)!r}" '
        f'size="{half_length!r} {half_width!r} {height_m / 2!r}"/>'
    )


def _robot(name: str, profile: Profile, physics: Physics) -> str:
    footprint = profile.footprint
    radius = physics.wheel_radius_m
    body_mass = physics.mass_kg - 4 * physics.wheel_mass_kg
    body_z = physics.ground_clearance_m + physics.body_height_m / 2 - radius
    wheels = []
    for wheel in WHEELS:
        x = physics.wheelbase_m / 2 * (1 if wheel.startswith("front") else -1)
        y = physics.track_m / 2 * (1 if wheel.endswith("left") else -1)
        # An ellipsoid meets the floor in one point, so that the track is what the profile says;
        # the engine carries its load alone (condim 1), grip is the tyres' (`tyres.py`).
        wheels.append(
            f'<body name="{name}_{wheel}" pos="{x!r} {y!r} 0">'
            f'<joint name="{name}_{wheel}" type="hinge" axis="0 1 0" damping="0.01" '
            f'armature="{_ARMATURE_KGM2}"/>'
            f'<geom name="{name}_{wheel}" type="ellipsoid" group="3" '
            f'mass="{physics.wheel_mass_kg!r}" contype="0" '
            f'size="{radius!r} {physics.wheel_width_m / 2!r} {radius!r}" '
            f'conaffinity="{_FLOOR}" condim="1" priority="1"/>'
            f'<site name="{name}_{wheel}" size="{1.5 * radius!r}"/></body>'
        )
    return (
        f'<body name="{name}" pos="0 0 {radius!r}"><freejoint name="{name}"/>'
        f'<site name="{name}_centre"/>'
        f'<geom name="{name}_chassis" type="box" group="2" mass="{body_mass!r}" '
        f'pos="0 0 {body_z!r}" friction="0.3 0.005 0.0001" '
        f'size="{footprint.length_m / 2!r} {footprint.width_m / 2!r} '
        f'{physics.body_height_m / 2!r}" '
        f'contype="{_CHASSIS}" conaffinity="{_STANDING | _CHASSIS}"/>' + "".join(wheels) + "</body>"
    )
