"""The navigator in a loop of your own: a world from numpy, a robot, ten lines that drive it.

    python examples/drive_between_rooms.py

Replace the kinematic robot by anything with `sense`, `command` and `advance`, and the loop stays.
"""

import numpy as np

import cairn
from cairn.robots import Box, KinematicRobot, Scene

TICK_S = 0.1


def two_rooms() -> cairn.World:
    """8 m x 4 m; a wall at x = 4 m with a door of 1.2 m in its middle."""
    occupancy = np.zeros((80, 160), np.uint8)
    occupancy[:3] = occupancy[-3:] = occupancy[:, :3] = occupancy[:, -3:] = 1
    occupancy[:, 78:82] = 1
    occupancy[28:52, 78:82] = 0
    return cairn.World(occupancy, resolution_m=0.05, name="two rooms")


def main() -> str:
    """Drive from one room to the other, around a box that the map does not show."""
    world, profile, start = two_rooms(), cairn.Profile.load("p3at"), (0.8, 2.0, 0.0)
    box = Box(x=5.6, y=2.3, length_m=0.4, width_m=0.4, name="box")
    robot = KinematicRobot(profile, Scene.from_world(world, [box]), start, seed=1)
    navigator = cairn.Navigator(profile, world, start=start)
    navigator.set_goal((7.2, 2.0))

    last = ""
    while True:
        seen = robot.sense()
        decision = navigator.step(seen.ranges_m, seen.wheels_m, seen.gyro_radps, TICK_S)
        robot.command(decision.twist)
        robot.advance(TICK_S)
        if decision.mode != last or decision.recovery:
            print(f"{decision.time_s:5.1f} s  {decision.sentence}")
            last = decision.mode
        if decision.goal_status in ("reached", "refused"):
            return decision.goal_status


if __name__ == "__main__":
    main()
