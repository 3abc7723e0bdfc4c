"""The lidar robot of the BARN Challenge, a Clearpath Jackal, as the benchmark's rules have it.

The wheels follow a command at the accelerations of the robot's own controller; the body follows the
wheels as far as the grip of its tyres lasts. How far it really turns for what its wheels do is a
gain that nobody knows, and its odometry, summed from the wheels, does not either.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from cairn.experiments.nav.simulated import STEP_S, Floats, Stepped, Surroundings
from cairn.experiments.nav.stacks import Observation
from cairn.experiments.nav.worlds import NavWorld
from cairn.profile import Profile
from cairn.robots.robot import Pose, Twist, moved, wrap_angle

YAW_GAIN = (0.85, 1.15)
"""True over commanded turn rate, drawn once for each trial."""
LATENCY_S = (0.02, 0.04)
"""From the end of a control period until its command takes effect, drawn for each command."""
GRIP_MPS2 = 5.0
"""Above this acceleration, along, across or both together, the tyres slip."""
YAW_GRIP_RADPS2 = 20.0
WHEEL_MPS2, WHEEL_RADPS2 = 20.0, 25.0
"""What the robot's own controller allows its wheels (jackal_control)."""
SCAN_EVERY_S = 0.02
SCAN_SIGMA_M = 0.001

_EVERY = round(SCAN_EVERY_S / STEP_S)


class Jackal(Stepped):
    """A Jackal in a world.

    Args:
        profile: `jackal`, or one with a lidar made from it.
        world: what is around it; it starts at the world's start.
        period_s: from one observation to the next; commands come that much later, and 20–40 ms.
        seed: of yaw gain, latencies and noise.
        phase_s: the world's time at the start.
    """

    def __init__(
        self, profile: Profile, world: NavWorld, period_s: float, seed: int, phase_s: float = 0.0
    ) -> None:
        assert profile.lidar is not None
        super().__init__(profile, Surroundings(world, phase_s), Pose(*world.start))
        self.odometry = Pose(0.0, 0.0, 0.0)
        self._lidar = profile.lidar
        self._period_s = period_s
        random = np.random.default_rng([seed, 1])
        self.yaw_gain = float(random.uniform(*YAW_GAIN))
        self._latencies, self._noise = (np.random.default_rng([seed, n]) for n in (2, 3))
        self._queue: deque[tuple[float, Twist]] = deque()
        self._wanted = self._wheels = Twist(0.0, 0.0)
        self._velocity = (0.0, 0.0)  # of the body, world frame
        self._turn_rate = 0.0
        self._scanned = (0.0, self.truth, self.odometry)
        self._seen_s = 0.0
        self._travel = (0.0, 0.0)

    def observe(self) -> Observation:
        """Read lidar and odometry."""
        time_s, dt_s = self.time_s, self.time_s - self._seen_s
        self._seen_s = time_s
        travel, self._travel = self._travel, (0.0, 0.0)
        scan_s, scan_from, scan_pose = self._scanned
        return Observation(
            time_s, dt_s, self._scan(scan_s, scan_from), scan_pose, self.odometry, self._wheels,
            travel, None,
        )  # fmt: skip

    def command(self, linear_mps: float, angular_radps: float) -> None:
        """Ask for speeds; limited to the profile's."""
        limits = self.profile.limits
        wanted = Twist(
            _clamp(linear_mps, limits.linear_mps), _clamp(angular_radps, limits.angular_radps)
        )
        due_s = self.time_s + self._period_s + float(self._latencies.uniform(*LATENCY_S))
        self._queue.append((due_s, wanted))

    def _step(self) -> None:
        while self._queue and self._queue[0][0] <= self.time_s + 1e-9:
            self._wanted = self._queue.popleft()[1]
        linear, angular = self._wheels
        linear += _clamp(self._wanted.linear_mps - linear, WHEEL_MPS2 * STEP_S)
        angular += _clamp(self._wanted.angular_radps - angular, WHEEL_RADPS2 * STEP_S)
        self._wheels = Twist(linear, angular)
        self._turn_rate += _clamp(
            self.yaw_gain * angular - self._turn_rate, YAW_GRIP_RADPS2 * STEP_S
        )
        # The wheels drag the body towards their speed along its heading, as hard as they grip.
        x, y, heading = self.truth
        turn = self._turn_rate * STEP_S
        vx, vy = self._velocity
        ahead = heading + turn / 2
        dx, dy = linear * math.cos(ahead) - vx, linear * math.sin(ahead) - vy
        slip = math.hypot(dx, dy)
        share = min(1.0, GRIP_MPS2 * STEP_S / slip) if slip > 0.0 else 0.0
        vx, vy = vx + share * dx, vy + share * dy
        self._velocity = (vx, vy)
        self.truth = Pose(x + vx * STEP_S, y + vy * STEP_S, wrap_angle(heading + turn))
        self.odometry = moved(self.odometry, self._wheels, STEP_S)
        half = angular * self.profile.drive.effective_track_m / 2
        left, right = self._travel
        self._travel = (left + (linear - half) * STEP_S, right + (linear + half) * STEP_S)
        self._steps += 1
        if self._steps % _EVERY == 0:
            self._scanned = (self.time_s, self.truth, self.odometry)

    def _scan(self, time_s: float, pose: Pose) -> Floats:
        lidar = self._lidar
        c, s = math.cos(pose.heading), math.sin(pose.heading)
        at = (
            pose.x + c * lidar.pose.x - s * lidar.pose.y,
            pose.y + s * lidar.pose.x + c * lidar.pose.y,
            pose.heading + lidar.pose.heading,
        )
        true = self.around.shapes.scan(
            at, lidar.beams, lidar.first_rad, lidar.step_rad, lidar.max_range_m,
            self.around.moving(time_s),
        )  # fmt: skip
        measured = true + SCAN_SIGMA_M * self._noise.standard_normal(lidar.beams)
        return np.maximum(measured, lidar.min_range_m)


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
