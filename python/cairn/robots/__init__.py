"""Robots: what a navigator drives, and the worlds that simulated ones stand in."""

from cairn.profile import Noise
from cairn.robots.kinematic import KinematicRobot
from cairn.robots.mujoco_p3at import MujocoP3AT, MujocoWorld, RobotSpec
from cairn.robots.robot import Contact, Pose, Readings, Robot, SimulatedRobot, Twist
from cairn.robots.scene import Box, Scene, Stage

__all__ = [
    "Box",
    "Contact",
    "KinematicRobot",
    "MujocoP3AT",
    "MujocoWorld",
    "Noise",
    "Pose",
    "Readings",
    "Robot",
    "RobotSpec",
    "Scene",
    "SimulatedRobot",
    "Stage",
    "Twist",
]
