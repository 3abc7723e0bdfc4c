"""Skid-steer robots with real physics: four driven wheels on a floor, contact and slip by MuJoCo.

One world may hold several robots. Time is the world's: it moves on as far as every robot has been
advanced.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cairn import errors
from cairn.profile import Noise, Physics, Profile
from cairn.robots import mjcf
from cairn.robots import rectangles as rect
from cairn.robots.firmware import Firmware
from cairn.robots.kinematic import require_noise
from cairn.robots.rectangles import Floats
from cairn.robots.robot import (
    Contact,
    Pose,
    Readings,
    Sill,
    Twist,
    as_twist,
    displaced,
    positive_scale,
    wrap_angle,
)
from cairn.robots.scene import Scene, Stage, outline_at
from cairn.robots.sensors import Firing, Gyroscope, RangeSensors, WheelEncoders
from cairn.robots.spares import Spares
from cairn.robots.tyres import Tyres

# The firmware sets wheel speeds every so many physics steps: 10 ms.
_FIRMWARE_STEPS = 4
_SETTLE_S = 0.5
# A sill gives by millimetres under all that the tyres can push, without rocking the robot.
_SILL_N_PER_M, _SILL_NS_PER_M = 2e4, 1e3
# A touch is over when the outline is this far from everything.
_RELEASE_M = 0.005


@dataclass(frozen=True)
class RobotSpec:
    """One robot of a `MujocoWorld`; fields as the arguments of `MujocoP3AT`."""

    profile: Profile
    start: Sequence[float]
    seed: int = 0
    noise: Noise | None = None
    firing: Firing = "all"
    name: str = ""


class MujocoWorld:
    """A scene and the robots in it, in one physics."""

    def __init__(self, scene: Scene, specs: Sequence[RobotSpec]) -> None:
        """Build the world and stand every robot at its start.

        Raises:
            SimulationNotInstalled: no `mujoco`.
            ProfileTableMissing: a profile without `[physics]` or without noise.
            StandsInObstacle: something stands at a start.
        """
        self._build(scene, specs, None)

    def _build(self, scene: Scene, specs: Sequence[RobotSpec], first: MujocoP3AT | None) -> None:
        self.mujoco = _mujoco()
        physics = [_require_physics(spec.profile) for spec in specs]
        text = mjcf.model_text(scene, [(s.profile, p) for s, p in zip(specs, physics, strict=True)])
        self.model = self.mujoco.MjModel.from_xml_string(text)
        self.data = self.mujoco.MjData(self.model)
        self.stage = scene.stage()
        self._steps = 0
        self._mocap = {
            i: int(self.model.body(f"box{i}").mocapid[0])
            for i in range(len(scene.boxes))
            if not mjcf.stands_throughout(scene, i)
        }
        self._spares = Spares(self.model, scene.spares)
        self._names = self._geom_names(scene, specs)
        self.robots: list[MujocoP3AT] = []
        for i, spec in enumerate(specs):
            robot = first if i == 0 and first is not None else MujocoP3AT.__new__(MujocoP3AT)
            robot._join(self, i, spec, physics[i])
            self.robots.append(robot)
        self._settle([Pose(*map(float, spec.start)) for spec in specs])
        self._asked = [0] * len(specs)
        self._update_stage()

    @property
    def time_s(self) -> float:
        """The world's clock."""
        return self._steps * mjcf.TIMESTEP_S

    def advance(self, dt_s: float) -> None:
        """Let time pass for every robot."""
        for robot in self.robots:
            robot.advance(dt_s)

    def outlines(self, besides: int) -> Floats:
        """Outlines of all robots but one, (n, 6)."""
        others = [
            outline_at(r.truth, r.profile.footprint)
            for i, r in enumerate(self.robots)
            if i != besides
        ]
        return np.array(others).reshape(-1, 6)

    def _ask(self, index: int, steps: int) -> None:
        self._asked[index] += steps
        target = min(self._asked)
        while self._steps < target:
            self._run(min(_FIRMWARE_STEPS - self._steps % _FIRMWARE_STEPS, target - self._steps))

    def _run(self, steps: int) -> None:
        self._update_stage()
        dt_s = steps * mjcf.TIMESTEP_S
        for robot in self.robots:
            robot._drive(self.time_s, dt_s)
        # A list: every robot spends its own margin.
        watch = not all([robot._clear_for(dt_s) for robot in self.robots])
        for _ in range(steps):
            for robot in self.robots:
                robot._grip()
            self.mujoco.mj_step(self.model, self.data)
            self._steps += 1
            for robot in self.robots:
                robot._turned += float(robot._gyro[0]) * mjcf.TIMESTEP_S
            if watch:
                self._note_contacts()

    def _note_contacts(self) -> None:
        pairs = self.data.contact.geom
        for robot in self.robots:
            rows, sides = np.nonzero(pairs == robot._chassis)
            for other in pairs[rows, 1 - sides]:
                robot._touch(self._names[int(other)], self.time_s)

    def _update_stage(self) -> None:
        bodies = [(robot.truth, robot.profile.footprint) for robot in self.robots]
        if self.stage.update(self.time_s, bodies):
            for robot in self.robots:
                robot._margin_m = 0.0
        for i, mocap in self._mocap.items():
            box = self.stage.boxes[i]
            z = box.height_m / 2 if self.stage.standing[i] else mjcf.PARKED_Z_M
            self.data.mocap_pos[mocap, 2] = z
        self._names |= self._spares.follow(self.stage, self.data)

    def _settle(self, starts: Sequence[Pose]) -> None:
        """Let wheels and floor come to rest far from everything, then stand at the start."""
        for i, robot in enumerate(self.robots):
            robot._put(Pose(1000.0 + 10.0 * i, 1000.0, 0.0))
        for _ in range(round(_SETTLE_S / mjcf.TIMESTEP_S)):
            for robot in self.robots:
                robot._grip()
            self.mujoco.mj_step(self.model, self.data)
        self.data.qvel[:] = 0
        for robot, start in zip(self.robots, starts, strict=True):
            robot._refuse_if_taken(start)
            robot._put(Pose(start.x, start.y, wrap_angle(start.heading)))
        self.mujoco.mj_forward(self.model, self.data)
        for robot in self.robots:
            robot._zero()

    def _geom_names(self, scene: Scene, specs: Sequence[RobotSpec]) -> dict[int, str]:
        names = {self.model.geom(f"wall{i}").id: "wall" for i in range(len(scene.walls))}
        for i, box in enumerate(scene.boxes):
            names[self.model.geom(f"box{i}").id] = box.name
        for i, spec in enumerate(specs):
            names[self.model.geom(f"r{i}_chassis").id] = spec.name or f"robot {i}"
        return names


class MujocoP3AT:
    """A four-wheel skid-steer robot in MuJoCo; the P3-AT with the shipped profile.

    The firmware ramps side speeds V ∓ ω·b/2 [Maalouf06 §2] and holds each wheel at its speed. How
    fast the robot then turns is up to friction.
    """

    def __init__(
        self,
        profile: Profile,
        scene: Scene,
        start: Sequence[float],
        *,
        seed: int = 0,
        noise: Noise | None = None,
        firing: Firing = "all",
        name: str = "",
    ) -> None:
        """Stand alone in a scene, at `start` (x, y, heading) [m, m, rad], world frame.

        For arguments and errors see `KinematicRobot` and `MujocoWorld`; `name` is what another
        robot's contacts call it.
        """
        world = MujocoWorld.__new__(MujocoWorld)
        world._build(scene, [RobotSpec(profile, start, seed, noise, firing, name)], self)

    @property
    def time_s(self) -> float:
        """The clock of its world."""
        return self.world.time_s

    @property
    def truth(self) -> Pose:
        """Where it really is."""
        x, y, _, w, i, j, k = (float(v) for v in self._qpos)
        return Pose(x, y, math.atan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k)))

    @property
    def velocity(self) -> Twist:
        """How it really moves."""
        heading = self.truth.heading
        vx, vy = float(self._qvel[0]), float(self._qvel[1])
        return Twist(vx * math.cos(heading) + vy * math.sin(heading), float(self._qvel[5]))

    @property
    def stage(self) -> Stage:
        """What stands in its world now."""
        return self.world.stage

    @property
    def contacts(self) -> list[Contact]:
        """Every touch of its chassis, oldest first."""
        return list(self._contacts)

    @property
    def clearance_m(self) -> float:
        """Least distance now from its outline to anything standing or driving; inf alone."""
        return self._clearance_at(self.truth)

    def command(self, twist: Any) -> None:
        """Ask for speeds; they take effect after the latency, at the profile's accelerations."""
        self._firmware.command(self.time_s, as_twist(twist))

    def advance(self, dt_s: float) -> None:
        """Ask for `dt_s` to pass, a multiple of the physics step of 2.5 ms.

        Several robots in one world: it passes once the last of them has asked.
        """
        steps = round(dt_s / mjcf.TIMESTEP_S) if math.isfinite(dt_s) else 0
        if steps < 1 or abs(steps * mjcf.TIMESTEP_S - dt_s) > 1e-9:
            raise errors.StepOutOfRange(
                f"dt_s is {dt_s}, must be a positive multiple of {mjcf.TIMESTEP_S} s", dt_s=dt_s
            )
        self.world._ask(self._index, steps)

    def sense(self) -> Readings:
        """Read encoders, gyroscope and ranges."""
        world = self.world
        world.mujoco.mj_kinematics(world.model, world.data)
        corners = np.vstack(
            [world.stage.corners, rect.corners(world.outlines(self._index)).reshape(-1, 2)]
        )
        sides = self._sides()
        travel = (sides[0] - self._sides_before[0], sides[1] - self._sides_before[1])
        turned, elapsed = self._turned, self.time_s - self._sensed_s
        self._sides_before, self._turned, self._sensed_s = sides, 0.0, self.time_s
        return Readings(
            self._ranges.read(self.truth, self.time_s, self._cast, corners),
            self._encoders.read(travel),
            self._gyroscope.read(turned, elapsed),
            self.time_s,
        )

    def shove(self, dx: float, dy: float, dheading: float = 0.0) -> None:
        """Move it by force, in its own frame; see `SimulatedRobot.shove`."""
        there = displaced(self.truth, dx, dy, dheading)
        self._refuse_if_taken(there)
        self._put(there)
        self._turned += dheading
        self._margin_m = 0.0
        self._touching.clear()
        self.world.mujoco.mj_forward(self.world.model, self.world.data)

    def hold(self, half_width_m: float) -> None:
        """Hold it by something unseen; see `SimulatedRobot.hold`."""
        self._sills.append(Sill.under(self.truth, half_width_m))

    def change_floor(self, track_scale: float) -> None:
        """Drive onto another floor; see `SimulatedRobot.change_floor`."""
        self._tyres = Tyres(self._physics, positive_scale(track_scale))

    def emergency_stop(self, for_s: float) -> None:
        """Press its emergency stop; see `SimulatedRobot.emergency_stop`."""
        self._firmware.emergency_stop(self.time_s, for_s)

    def _join(self, world: MujocoWorld, index: int, spec: RobotSpec, physics: Physics) -> None:
        model, data = world.model, world.data
        self.world = world
        self.profile = spec.profile
        self._index = index
        self._physics = physics
        noise = require_noise(spec.profile, spec.noise)
        self._firmware = Firmware(spec.profile)
        self._encoders = WheelEncoders(noise, spec.seed)
        self._gyroscope = Gyroscope(noise, spec.seed)
        self._ranges = RangeSensors(spec.profile, noise, spec.seed, spec.firing)
        joint = model.joint(f"r{index}")
        q, v = int(joint.qposadr[0]), int(joint.dofadr[0])
        self._qpos, self._qvel = data.qpos[q : q + 7], data.qvel[v : v + 6]
        wheels = [model.joint(f"r{index}_{wheel}") for wheel in mjcf.WHEELS]
        # The wheels' joints follow the chassis's own.
        self._spins, self._applied = data.qvel[v + 6 : v + 10], data.qfrc_applied[v : v + 10]
        # Floors differ: the effective track by the same draw as the kinematic robot's.
        drawn = float(np.random.default_rng([spec.seed, 4]).standard_normal())
        self._tyres = Tyres(physics, 1 + noise.track_scale_sigma * drawn)
        self._wheel_angles = np.array([int(w.qposadr[0]) for w in wheels])
        self._wheel_servos = np.array([model.actuator(f"r{index}_{w}").id for w in mjcf.WHEELS])
        gyro = int(model.sensor(f"r{index}_gyro").adr[0]) + 2
        self._gyro = data.sensordata[gyro : gyro + 1]
        loads = int(model.sensor(f"r{index}_{mjcf.WHEELS[0]}").adr[0])
        self._loads = data.sensordata[loads : loads + 4]
        self._chassis = model.geom(f"r{index}_chassis").id
        self._body = model.body(f"r{index}").id
        self._groups = np.array(mjcf.RAY_GROUPS, dtype=np.uint8)
        self._circle_m = (
            math.hypot(spec.profile.footprint.length_m, spec.profile.footprint.width_m) / 2
        )
        self._contacts: list[Contact] = []
        self._sills: list[Sill] = []
        self._touching: set[str] = set()
        self._margin_m = 0.0
        self._turned = self._sensed_s = 0.0
        self._sides_before = (0.0, 0.0)

    def _zero(self) -> None:
        self._sides_before = self._sides()
        self._turned = 0.0

    def _put(self, pose: Pose) -> None:
        half = pose.heading / 2
        self._qpos[:2] = pose.x, pose.y
        self._qpos[3:] = math.cos(half), 0.0, 0.0, math.sin(half)

    def _sides(self) -> tuple[float, float]:
        """Travel of the left and right side by their wheels' angles [m]."""
        a, b, c, d = self.world.data.qpos[self._wheel_angles] * self._physics.wheel_radius_m
        return float(a + b) / 2, float(c + d) / 2

    def _drive(self, time_s: float, dt_s: float) -> None:
        self._firmware.step(time_s, dt_s)
        left, right = (v / self._physics.wheel_radius_m for v in self._firmware.sides_mps())
        self.world.data.ctrl[self._wheel_servos] = left, left, right, right

    def _grip(self) -> None:
        """Apply the tyres' forces for one physics step."""
        _, _, _, w, i, j, k = self._qpos.tolist()
        vx, vy, _, roll, pitch, yaw = self._qvel.tolist()
        c, s = 1 - 2 * (j * j + k * k), 2 * (w * k + i * j)
        fx, fy, mx, my, mz, torques = self._tyres.forces(
            (c * vx + s * vy, c * vy - s * vx),
            (roll, pitch, yaw),
            self._spins.tolist(),
            self._loads.tolist(),
        )
        self._applied[:] = c * fx - s * fy, s * fx + c * fy, 0.0, mx, my, mz, *torques
        for sill in self._sills:
            depth_m = sill.depth_m(float(self._qpos[0]), float(self._qpos[1]))
            if depth_m > 0:
                ux, uy = math.cos(sill.at.heading), math.sin(sill.at.heading)
                speed = ux * float(self._qvel[0]) + uy * float(self._qvel[1])
                push = -max(_SILL_N_PER_M * depth_m + _SILL_NS_PER_M * speed, 0.0)
                self._applied[0] += push * ux
                self._applied[1] += push * uy

    def _clear_for(self, dt_s: float) -> bool:
        """Whether nothing can be touched within `dt_s`, and no touch is going on."""
        limits = self.profile.limits
        # Twice what it may do: slip, and the other robot's own motion.
        reach = 2 * (limits.linear_mps + limits.angular_radps * self._circle_m) * dt_s
        self._margin_m -= reach
        if self._margin_m > 0:
            return True
        clearance = self.clearance_m
        if clearance > _RELEASE_M:
            self._touching.clear()
        self._margin_m = clearance - reach
        return self._margin_m > 0

    def _touch(self, name: str, time_s: float) -> None:
        if name not in self._touching:
            self._touching.add(name)
            self._contacts.append(Contact(time_s, name))

    def _clearance_at(self, pose: Pose) -> float:
        outline = outline_at(pose, self.profile.footprint)
        others = rect.distances(outline, self.world.outlines(self._index)).min(initial=math.inf)
        return min(self.world.stage.clearance_m(pose, self.profile.footprint), float(others))

    def _refuse_if_taken(self, pose: Pose) -> None:
        self.world.stage.refuse_if_taken(pose, self.profile.footprint)
        if self._clearance_at(pose) <= 0:
            raise errors.StandsInObstacle(
                f"a robot at ({pose.x:.3f}, {pose.y:.3f}) m would stand in another robot",
                x_m=pose.x,
                y_m=pose.y,
                heading_rad=pose.heading,
                obstacle="robot",
            )

    def _cast(self, origin: Floats, directions: Floats) -> tuple[Floats, Floats]:
        world, count = self.world, len(directions)
        rays = np.zeros((count, 3))
        rays[:, :2] = directions
        geoms = np.empty(count, dtype=np.int32)
        distance, normals = np.empty(count), np.zeros((count, 3))
        world.mujoco.mj_multiRay(
            world.model,
            world.data,
            np.array([origin[0], origin[1], self._physics.sonar_height_m]),
            rays.ravel(),
            self._groups,
            1,
            self._body,
            geoms,
            distance,
            normals.ravel(),
            count,
            self._ranges.reach_m,
        )
        met = geoms >= 0
        cosine = np.where(met, np.abs((rays * normals).sum(axis=1)), 1.0)
        return np.where(met, distance, np.inf), cosine


def measured_effective_track_m(
    profile: Profile, twist: tuple[float, float] = (0.0, 0.5), seconds: float = 10.0
) -> float:
    """Effective track of a profile's robot in this physics: side speeds' difference per turn rate.

    Drives on an empty floor; a profile is well identified where this is its
    `drive.effective_track_m`.
    """
    noise = require_noise(profile, None).scaled(0.0)
    robot = MujocoP3AT(profile, Scene(), (0.0, 0.0, 0.0), noise=noise)
    robot.command(twist)
    robot.advance(3.0)
    robot.sense()
    turned, before = 0.0, robot.truth.heading
    for _ in range(round(seconds / 0.1)):
        robot.advance(0.1)
        turned += wrap_angle(robot.truth.heading - before)
        before = robot.truth.heading
    left, right = robot.sense().wheels_m
    return (right - left) / turned


def _require_physics(profile: Profile) -> Physics:
    if profile.physics is None:
        raise errors.ProfileTableMissing(
            f"profile `{profile.name}` has no [physics], which a physics engine needs",
            profile=profile.name,
            table="physics",
        )
    return profile.physics


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError:
        raise errors.SimulationNotInstalled(
            'physics needs MuJoCo: pip install "cairn-nav[sim]"'
        ) from None
    return mujoco
