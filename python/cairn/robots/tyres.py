"""Grip of four tyres that roll and slide: Coulomb friction, smooth about rest.

The contact model of MuJoCo is convex: a wheel that slides is also lifted, so that a skid-steer
robot hops when it turns and slips twice as much as real ones (measured: slip factors of 2 to 5,
by friction, cone and solver). So the engine carries the load, and grip is applied here.
"""

from __future__ import annotations

import math

from cairn.profile import Physics


class Tyres:
    """Forces on the wheels of one robot, in its own frame.

    Each tyre with load N sliding over the floor at (sx, sy) is pulled back by
    N · (μ_x sx, μ_y sy) / √(sx² + sy² + v₀²), v₀ being the creep of a tyre that grips. Turning on
    the spot, the moments of both directions balance at an effective track
    b = B · (1 + (μ_y / μ_x) · L² / B²) for a track B and a wheelbase L.
    """

    def __init__(self, physics: Physics, track_scale: float = 1.0) -> None:
        """Tyres in the order front left, rear left, front right, rear right.

        `track_scale` makes a floor on which the effective track is that many times as wide.
        """
        x, y = physics.wheelbase_m / 2, physics.track_m / 2
        self._places = ((x, y), (-x, y), (x, -y), (-x, -y))
        self._radius = physics.wheel_radius_m
        self._along = physics.friction
        # From the equation above, solved for μ_y at a track of b · track_scale.
        slope = physics.friction / (2 * x / (2 * y)) ** 2
        widening = physics.friction_lateral / slope
        self._aside = slope * max(track_scale * (1 + widening) - 1, 0.1 * widening)
        self._creep2 = physics.friction_creep_mps**2

    def forces(
        self,
        velocity: tuple[float, float],
        rates: tuple[float, float, float],
        spins: list[float],
        loads: list[float],
    ) -> tuple[float, float, float, float, float, list[float]]:
        """Sum of all tyres on the robot, and the torque on each axle.

        Args:
            velocity: of the robot's centre along its x and y axes, at axle height [m/s].
            rates: roll, pitch and yaw rate [rad/s].
            spins: of the wheels, positive forwards [rad/s].
            loads: on the wheels [N].

        Returns:
            Force along x and y [N], moments about x, y and z at the centre [N·m], axle torques.
        """
        vx, vy = velocity
        roll, pitch, yaw = rates
        radius = self._radius
        fx = fy = mz = 0.0
        torques = []
        vx -= pitch * radius
        vy += roll * radius
        for (x, y), spin, load in zip(self._places, spins, loads, strict=True):
            sx = vx - yaw * y - spin * radius
            sy = vy + yaw * x
            grip = -load / math.sqrt(sx * sx + sy * sy + self._creep2)
            px, py = self._along * grip * sx, self._aside * grip * sy
            fx += px
            fy += py
            mz += x * py - y * px
            torques.append(-radius * px)
        return fx, fy, radius * fy, -radius * fx, mz, torques
