"""Robot profiles: one commented TOML file says what a robot is.

The brain reads outline, limits, wheels and sensors. Two tables are the body's alone: `[physics]`,
what a simulation needs to build the robot, and `[noise]`, how its sensors err.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated, Any, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from cairn import _brain, errors, shipped

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
T = TypeVar("T", bound="_Table")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Footprint(_Table):
    """A box on the ground, sides parallel to the robot's axes, centred on its origin [m]."""

    length_m: float
    width_m: float


class Limits(_Table):
    """What the robot can do, in SI units and radians."""

    linear_mps: float
    angular_radps: float
    linear_mps2: float
    angular_radps2: float


class Drive(_Table):
    """Skid-steer drive: side speeds are V ∓ ω·b/2 with the effective track b [Maalouf06 §2]."""

    effective_track_m: float
    latency_s: float


class SensorPose(_Table):
    """Where a sensor sits and looks in the robot frame [m, rad]."""

    x: float
    y: float
    heading: float


class Sonar(_Table):
    """An ultrasonic ranger with a cone of `beam_rad` full angle."""

    pose: SensorPose
    beam_rad: float
    min_range_m: float
    max_range_m: float


class Lidar(_Table):
    """A planar scanner: beam i looks along `first_rad + i · step_rad` in its own frame."""

    pose: SensorPose
    beams: int
    first_rad: float
    step_rad: float
    min_range_m: float
    max_range_m: float


class Physics(_Table):
    """What a physics engine needs to build the robot; SI units."""

    mass_kg: Positive = Field(description="whole robot, battery included")
    body_height_m: Positive = Field(description="of the body box; its sides are the footprint's")
    ground_clearance_m: Positive = Field(description="from the floor to the body box")
    wheel_radius_m: Positive = Field(description="of the tyres, loaded")
    wheel_width_m: Positive = Field(description="of the tyres")
    wheel_mass_kg: Positive = Field(description="of each of the four wheels")
    wheelbase_m: Positive = Field(description="between the axles")
    track_m: Positive = Field(description="between the wheels' middle planes")
    friction: Positive = Field(description="of tyre on floor, along the wheel")
    friction_lateral: Positive = Field(description="the same, along the axle")
    friction_creep_mps: Positive = Field(description="sliding at which grip is 1/√2 of full")
    servo_gain: Positive = Field(description="torque per wheel speed error [N·m·s/rad]")
    sonar_height_m: Positive = Field(description="of the transducers over the floor")


class Noise(_Table):
    """How the sensors err. Everything drawn is drawn from the run's seed."""

    wheel_scale_sigma: NotNegative = Field(
        description="relative error of each side's wheel radius, drawn once per run"
    )
    encoder_sigma_per_sqrt_m: NotNegative = Field(
        description="random walk of each side's travel [m/√m]"
    )
    track_scale_sigma: NotNegative = Field(
        description="relative error of the effective track, drawn once per run"
    )
    slip_sigma: NotNegative = Field(
        description="wandering relative error of the turn rate by slip (kinematic robot)"
    )
    slip_correlation_s: Positive = Field(description="how long one slip lasts")
    gyro_density_radps_sqrt_s: NotNegative = Field(description="white noise [rad/s/√Hz]")
    gyro_bias_sigma_radps: NotNegative = Field(description="bias, drawn once per run")
    gyro_drift_radps_per_sqrt_s: NotNegative = Field(description="random walk of the bias")
    gyro_scale_sigma: NotNegative = Field(description="relative error, drawn once per run")
    sonar_sigma_m: NotNegative = Field(description="of an echo's range, constant part")
    sonar_sigma_relative: NotNegative = Field(description="of an echo's range, per metre")
    sonar_miss_incidence_rad: Annotated[float, Field(gt=0, le=math.pi / 2)] = Field(
        description="a smooth face met farther than this from its normal gives no echo"
    )
    sonar_rays: Annotated[int, Field(ge=1, le=1001)] = Field(description="rays across one cone")
    lidar_sigma_m: NotNegative = Field(default=0.0, description="of a lidar beam's range")

    def scaled(self, factor: float) -> Noise:
        """Everything random times `factor` (0: exact sensors); what is geometry stays."""
        if not (math.isfinite(factor) and factor >= 0):
            raise errors.NoiseFactorOutOfRange(
                f"noise factor is {factor}, must be finite and not negative", factor=factor
            )
        kept = {"sonar_miss_incidence_rad", "sonar_rays", "slip_correlation_s"}
        values = self.model_dump()
        return Noise(**{k: v if k in kept else v * factor for k, v in values.items()})


class Profile(_brain.Profile):
    """A robot, from its TOML file. Passed to the brain as it is.

    Attributes:
        name: name a person would use.
        footprint, limits, drive, sonars, lidar: as the brain reads them.
        physics: for a physics engine; None where the file has no `[physics]`.
        noise: sensor errors; None where the file has no `[noise]`.
        text: the file itself.
    """

    name: str
    footprint: Footprint
    limits: Limits
    drive: Drive
    sonars: tuple[Sonar, ...]
    lidar: Lidar | None
    physics: Physics | None
    noise: Noise | None
    text: str

    def __new__(cls, text: str) -> Self:
        """Read a profile from TOML text; see `load` for the errors."""
        profile = super().__new__(cls, text)
        brain = profile.to_dict()
        tables = tomllib.loads(text)
        profile.text = text
        profile.name = brain["name"]
        profile.footprint = Footprint(**brain["footprint"])
        profile.limits = Limits(**brain["limits"])
        profile.drive = Drive(**brain["drive"])
        profile.sonars = tuple(Sonar(**sonar) for sonar in brain["sonars"])
        profile.lidar = Lidar(**brain["lidar"]) if brain["lidar"] else None
        profile.physics = _read(Physics, "physics", tables, profile.name)
        profile.noise = _read(Noise, "noise", tables, profile.name)
        return profile

    @classmethod
    def load(cls, name_or_path: str | Path) -> Self:
        """The profile shipped under a name (`"p3at"`), or the one in a file.

        Raises:
            ProfileNotFound: neither a shipped name nor a file.
            ProfileKeyUnknown, ProfileKeyMissing, ProfileValueOutOfRange: what the file says is not
                usable.
            ProfileUnreadable: it is not TOML, or has keys that are not those of a profile.
        """
        path = shipped.find("profiles", name_or_path)
        if path is None:
            known = shipped.names("profiles")
            raise errors.ProfileNotFound(
                f"robot profile `{name_or_path}` is neither a file nor one of {', '.join(known)}",
                profile=str(name_or_path),
                known=known,
            )
        return cls(shipped.read(path, errors.ProfileUnreadable))

    @property
    def range_count(self) -> int:
        """Readings in one array of ranges: the sonars, then the lidar's beams."""
        return len(self.sonars) + (self.lidar.beams if self.lidar else 0)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the text."""
        return (type(self), (self.text,))


def _read(kind: type[T], table: str, tables: dict[str, Any], profile: str) -> T | None:
    if table not in tables:
        return None
    try:
        return kind.model_validate(tables[table])
    except ValidationError as error:
        raise _refusal(error, kind, table, profile) from None


def _refusal(
    error: ValidationError, kind: type[_Table], table: str, profile: str
) -> errors.CairnError:
    first = error.errors()[0]
    key = ".".join([table, *map(str, first["loc"])])
    if first["type"] == "extra_forbidden":
        known = sorted(kind.model_fields)
        return errors.ProfileKeyUnknown(
            f"profile `{profile}`: unknown key {key}; [{table}] has {', '.join(known)}",
            profile=profile,
            key=key,
            known=known,
        )
    if first["type"] == "missing":
        return errors.ProfileKeyMissing(
            f"profile `{profile}`: {key} is missing", profile=profile, key=key
        )
    return errors.ProfileValueOutOfRange(
        f"profile `{profile}`: {key} is {first['input']!r}: {first['msg']}",
        profile=profile,
        key=key,
        value=first["input"],
        least=first.get("ctx", {}).get("gt", first.get("ctx", {}).get("ge", -math.inf)),
    )
