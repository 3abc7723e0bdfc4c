"""How well a stack drives where it has never been: `cairn bench nav`.

Worlds come from a folder of BARN worlds [Perille20] [Nair22], from our own generator, or from an
office. The robot knows neither world nor path, only its sensors, its odometry and the goal in the
frame of its odometry.

**A stack is a callable made by a callable**, entered by a name in `stacks.STACKS` or as
`module:function`:

    def make(task: Task) -> Callable[[Observation], tuple[float, float]]

`make` is called once for each trial with what the robot knows beforehand (`Task`: profile, goal,
tolerance, seed, control period). What it returns is called once every control period with what the
robot has just sensed (`Observation`), and returns the command (V [m/s], ω [rad/s]), which holds
until the next one takes effect. The stack must draw random numbers only from `task.seed`.

The function may carry an attribute `period_s`, the control period it wants, a multiple of 5 ms of
at least 20 ms (20 Hz is the default for the lidar robot, 10 Hz for the sonar robot). A command of
the lidar robot takes effect one period and 20–40 ms after the observation it answers. What is
returned may have `notes() -> dict`, kept with the trial, and `path`, an (n, 2) array in the
odometry frame for the picture. An exception, or a command that is not finite, ends the trial as
failed (outcome `error`, with the message).

`bench.run` drives many trials over processes; `trial.drive` one of them.
"""

from cairn.experiments.nav.stacks import Observation, Task

__all__ = ["Observation", "Task"]
