"""A whole run told: what changed when and why, what went wrong, and how it ended."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field
from typing import Any

from cairn.record import words
from cairn.record.run import Run
from cairn.record.tick_story import refused


@dataclass(frozen=True)
class Moment:
    """Something worth telling of one robot."""

    time_s: float
    kind: str  # mode, recovery, refusal, goal
    code: str  # stable: a reason, a cause, a refusal, a status
    mode: str
    sentence: str
    times: int = 1  # the same again, one after the other
    until_s: float | None = None  # of those, the last one's time

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {key: value for key, value in vars(self).items() if value is not None}


@dataclass
class RobotStory:
    """What one robot went through."""

    robot: str
    moments: list[Moment] = field(default_factory=list)
    ending: list[str] = field(default_factory=list)
    status: str = "idle"  # code of how the last task stands
    refusal: dict[str, Any] | None = None
    ended_s: float = 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return it as plain values."""
        return {
            "robot": self.robot,
            "status": self.status,
            "refusal": self.refusal,
            "ended_s": self.ended_s,
            "moments": [moment.to_dict() for moment in self.moments],
            "ending": self.ending,
        }


def tell_run(run: Run, robot: str | None = None) -> list[RobotStory]:
    """Tell a run from its log, robot by robot; one that was cut off, as far as it goes."""
    names = run.robots if robot is None else [robot]
    return [_tell_robot(run, name) for name in names]


def _tell_robot(run: Run, name: str) -> RobotStory:
    story = RobotStory(name)
    moments: list[Moment] = []
    mode = status = last = None
    for tick in run.ticks(name):
        decision, time_s = tick["decision"], tick["time_s"]
        sentence = _bare(decision["sentence"])
        now, stands = decision["mode"], decision["status"]["code"]
        recovery = decision["recovery"]
        if stands == "refused" and status != "refused":
            code = decision["status"]["refusal"]["code"]
            moments.append(Moment(time_s, "refusal", code, now, sentence))
        elif now != mode:
            moments.append(Moment(time_s, "mode", decision["reason"], now, sentence))
        elif recovery:
            code = recovery["cause"]["code"]
            moments.append(Moment(time_s, "recovery", code, now, sentence))
        elif stands != status and stands in ("reached", "cancelled"):
            moments.append(Moment(time_s, "goal", stands, now, sentence))
        mode, status, last = now, stands, tick
    story.moments = list(_gathered(moments))
    if last is None:
        story.ending = ["The log holds no tick of it."]
        return story
    story.status = last["decision"]["status"]["code"]
    story.refusal = last["decision"]["status"].get("refusal")
    story.ended_s = last["time_s"]
    story.ending = _ending(run, story, last)
    return story


def _gathered(moments: list[Moment]) -> list[Moment]:
    """The same recovery again and again is told once."""
    gathered = []
    for _, group in itertools.groupby(
        enumerate(moments),
        lambda each: (each[1].kind, each[1].code) if each[1].kind == "recovery" else each[0],
    ):
        same = [moment for _, moment in group]
        first = same[0]
        if len(same) > 1:
            first = Moment(
                first.time_s, first.kind, first.code, first.mode, first.sentence,
                times=len(same), until_s=same[-1].time_s,
            )  # fmt: skip
        gathered.append(first)
    return gathered


def _ending(run: Run, story: RobotStory, last: dict[str, Any]) -> list[str]:
    """How it ended and why: what the robot says, then what the judge says."""
    told = []
    if story.refusal:
        told += refused(story.refusal)
    else:
        mode = words.MODES[last["decision"]["mode"]].lower()
        said = words.STATUS[story.status]
        told.append(
            f"At {story.ended_s:.1f} s, the last tick, its task is {said}; it is in {mode}:"
            f" {_bare(last['decision']['sentence'])}."
            if story.status == "driving"
            else f"At {story.ended_s:.1f} s, the last tick, {said}."
        )
    summary = run.summary
    if summary is None:
        told.append("The run was cut off: there is no summary.json, and the log ends here.")
        return told
    judged = next((each for each in summary["robots"] if each["name"] == story.robot), None)
    if judged is None:
        return told
    told += [f"The judge: {goal['sentence'].rstrip('.')}." for goal in judged["goals"]]
    told += [
        f"The judge: touched {contact['name']} at {contact['time_s']:.1f} s."
        for contact in judged["contacts"]
    ]
    return told


def _bare(sentence: str) -> str:
    """A navigator's sentence without the mode that it begins with."""
    _, colon, why = sentence.partition(": ")
    return (why if colon else sentence).rstrip(".")
