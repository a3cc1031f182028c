"""What the rig answers, held against what the placements of a recording come to.

A pass is contradicted by one placement that breaks the claim, a failure by one that fulfils it. A claim that is inconclusive
though all placements agree is a weakness and no contradiction. Stated figures have to hold what every placement has, margins to
be those of the worst one.
"""

from fractions import Fraction

import trains
from figures import Limits
from placement import NeverCame, Placement, Track
from scenes import COARSE, EVERY
from trains import MEASURES, MISSING, VERBS, AtLeast, Rooted
from verbs import END, START, window

# Claims that one figure keeps its limits.
FIGURES = {"frequency": trains.frequency, "duty": trains.duty, "speed": trains.speed, "position": trains.position,
           "jitter": trains.jitter}
# What looks at an instant alone: a pulse between two samples is not what it asks for.
AT_INSTANTS = {"value", "equal", "speed", "state", "led", "task", "happens"}


class Expected:
    """What placements come to: the answers of a claim, the figures of a measurement."""

    def __init__(self):
        self.answers, self.unseen = set(), set()
        self.figures = []
        self.margins = []
        self.examples = {}
        self.some = []
        self.never_came = False
        self.unknown = False


def expected(claim, recording, rng, count):
    """What the placements of a recording make of a claim."""
    found = Expected()
    bases, looked_at = bases_of(claim)
    waited = [rest for step, rest in recording.awaited.items() if step in bases]
    names = sorted({*claim.names, *(signal for signal, *_ in waited)})
    looked_at |= {since for _, _, since, _ in waited}
    found.unknown = recording.unknown(names) or bool(COARSE.keys() & set(names))
    drawn = recording.placements, (rng, names, looked_at, marks(claim, recording), count)
    try:
        for placement in drawn[0](*drawn[1]):
            if keeps_promise(claim, placement):
                note(found, found.answers, claim, placement, recording.awaited)
        if recording.samples is not None and claim.verb not in AT_INSTANTS:
            for placement in drawn[0](*drawn[1], claim.keys.get("pulses-longer-than", 0)):
                note(found, found.unseen, claim, placement, recording.awaited, False)
        between_two(found, claim, recording)
    except NeverCame:
        found.never_came = True
    return found


def keeps_promise(claim, placement):
    """Of a signal that is recorded at most every so often, `pulses-longer-than` of at least that says that nothing short is there."""
    longest = claim.keys.get("pulses-longer-than", 0)
    for name in claim.names:
        if name in EVERY and longest >= EVERY[name]:
            at = [time for time, _ in placement.tracks[name].at]
            if any(to - since <= longest for since, to in zip(at[1:], at[2:])):
                return False
    return True


def figure_of(claim, placement):
    """The one figure that a claim or a measurement is about and its limits; None where there is none."""
    figure = MEASURES.get(claim.verb) if claim.group == "measure" else FIGURES.get(claim.verb)
    limits = claim.keys.get("limits" if claim.group == "measure" else "is")
    if figure is None or limits is None or "pulses-longer-than" in claim.keys or empty(claim.keys, placement):
        return None, None
    found = figure(claim.keys, placement)
    return (found, limits) if isinstance(found, (int, Fraction)) and not isinstance(found, bool) else (None, None)


def between_two(found, claim, recording):
    """Where one placement is below the limits and one above them, one in between may keep them: every change halfway between
    where they have it keeps to its interval, too."""
    if found.answers != {False}:
        return
    sides = {}
    for placement in found.some:
        figure, limits = figure_of(claim, placement)
        if figure is not None:
            sides["below" if limits.low is not None and figure < limits.low else "above"] = placement
    for _ in range(24):
        if len(sides) < 2:
            return
        placement = halfway(sides["below"], sides["above"])
        figure, limits = figure_of(claim, placement) if placement else (None, None)
        if figure is None:
            return
        if limits.allow(figure):
            tracks = {name: [(*at, value) for at, value in zip(track.at, track.values)] for name, track in placement.tracks.items()}
            if not recording.ties(tracks, bases_of(claim)[1]):
                note(found, found.answers, claim, placement, recording.awaited)
            return
        sides["below" if limits.low is not None and figure < limits.low else "above"] = placement


def halfway(one, other):
    """The placement in the middle of two of the same changes; None where they have others, or the order of two is lost."""
    tracks = {}
    for name, track in one.tracks.items():
        second = other.tracks[name]
        if track.values != second.values:
            return None
        tracks[name] = Track([((at[0] + to[0]) // 2, at[1], value) for at, to, value in zip(track.at, second.at, track.values)])
        if any(at >= to for at, to in zip(tracks[name].at, tracks[name].at[1:])):
            return None
    return Placement(tracks, one.steps) if one.steps == other.steps else None


def bases_of(claim):
    """The steps that a claim counts from: all of them, and those at whose very instant it looks."""
    counted = [value for value in claim.keys.values() if isinstance(value, tuple)]
    all_of_them = {base for base, _ in counted} | {claim.keys.get("step")}
    return all_of_them, {base for base, distance in counted if distance == 0} | {"start", "end", claim.keys.get("step")}


def empty(keys, placement):
    """A window without time in it: the manual does not say what holds of it."""
    return placement.at(keys.get("from", START))[0] >= placement.at(keys.get("until", END))[0]


def note(found, answers, claim, placement, awaited, seen=True):
    if any(value[0] in awaited and value[0] not in placement.steps for value in claim.keys.values() if isinstance(value, tuple)):
        # Whether the step came is left open: a claim that counts from it is, too.
        answers.add(None)
        found.margins.append(None)
        return
    if empty(claim.keys, placement):
        answers.add(None)
        found.margins.append(None)
        return
    if claim.group == "expect":
        answer = VERBS[claim.verb](claim.keys, placement)
    else:
        figure = MEASURES[claim.verb](claim.keys, placement)
        limits = claim.keys.get("limits")
        if figure is None:
            answer = None
        elif figure == MISSING:
            answer = False
        else:
            if seen:
                found.figures.append(figure)
            if isinstance(figure, AtLeast):
                answer = False if limits and limits.high is not None and figure.least > limits.high else None
            else:
                answer = None if limits is None else limits.allow(figure)
    answers.add(answer)
    found.examples.setdefault(answer, placement)
    if seen and len(found.some) < 80:
        found.some.append(placement)
    if seen:
        found.margins.append(margin(claim, placement))


def margin(claim, placement):
    """The distance from the nearest limit, where the manual says what it is; else None."""
    keys = claim.keys
    if claim.group == "measure":
        figure = MEASURES[claim.verb](keys, placement)
        return passable(claim, keys["limits"]).margin(figure) if "limits" in keys and isinstance(figure, (int, Fraction)) else None
    times = first_times(claim, placement)
    if times is not None:
        return passable(claim, keys["within"]).margin(times[0] - placement.at(keys.get("from", START))[0]) if times else None
    if claim.verb == "period" and "pulses-longer-than" not in keys:
        lengths = trains.periods(keys, placement)
        return min((passable(claim, keys["is"]).margin(length) for length in lengths), default=None)
    if claim.verb in ("stays", "task") and "wanted" in keys and keys["wanted"].limits is not None and \
            "when" not in keys and "pulses-longer-than" not in keys:
        (begin, _), (end, _) = window(keys, placement)
        return min(keys["wanted"].limits.margin(value) for _, _, value in
                   placement.tracks[keys["signal"]].stretches(begin, end))
    if claim.verb == "value" and "wanted" in keys and keys["wanted"].limits is not None:
        return keys["wanted"].limits.margin(placement.tracks[keys["of"]].value(placement.reading(keys.get("when", END))))
    if claim.verb == "equal":
        left, right = (placement.tracks[keys[side]].value(placement.reading(keys.get(side + "-at", keys.get("when", END))))
                       for side in ("left", "right"))
        return None if isinstance(left, bool) else keys.get("tolerance", 0) - abs(left - right)
    figure = FIGURES.get(claim.verb)
    if figure and "pulses-longer-than" not in keys:
        found = figure(keys, placement)
        return passable(claim, keys["is"]).margin(found) if isinstance(found, (int, Fraction)) else None
    return None


def passable(claim, limits):
    """The limits that a figure can pass: a time, a frequency and jitter are never below 0, a duty never above 100 %."""
    low, high = limits.low, limits.high
    if claim.verb not in ("value", "window", "speed", "position") and low is not None and low <= 0:
        low = None
    if claim.verb == "duty" and high is not None and high >= 100:
        high = None
    return Limits(low, high)


def first_times(claim, placement):
    """When what a claim waits for comes, if it has limits for that; else None."""
    keys = claim.keys
    if "within" not in keys or "pulses-longer-than" in keys:
        return None
    begin, end = placement.at(keys.get("from", START)), placement.at(END)
    if claim.verb in ("rises", "falls", "changes"):
        return placement.edges(keys["signal"], claim.verb, begin, end)
    if claim.verb == "becomes" or keys.get("how") == "becomes":
        return [time for time, before, after in placement.tracks[keys["signal"]].changes(begin, end)
                if keys["wanted"].has(after) and not keys["wanted"].has(before)]
    if claim.verb == "log":
        return placement.edges(keys["signal"], "changes", begin, end)
    if claim.verb == "happens" and keys["step"] in placement.steps:
        return [placement.steps[keys["step"]][0]]
    return None


def marks(claim, recording):
    """Instants at which the claim may be decided."""
    found = set()
    keys = claim.keys
    for key in ("from", "until", "when", "to"):
        base, distance = keys.get(key, START if key == "from" else END)
        if base not in recording.steps:
            continue
        at = recording.steps[base][0] + distance
        found |= {at, at - 1, at + 1}
        if key == "from" and "within" in keys:
            for limit in (keys["within"].low, keys["within"].high):
                if limit is not None:
                    found |= {at + int(limit), at + int(limit) + 1, at + int(limit) - 1}
    return sorted(found)


def differences(claim, answer, found):
    """Each contradiction as a kind and words; `weak` where nothing is open but the verdict."""
    verdict = answer.verdict
    if verdict == "error":
        return [("error", answer.reason)]
    if found.never_came:
        if verdict in ("pass", "fail"):
            return [(f"{verdict} without its instant", "an instant that it counts from never came")]
        return []
    seen, unseen = found.answers, found.unseen
    result = []
    if verdict == "pass" and False in seen:
        result.append(("pass, may be broken", "a placement that the recording allows breaks it"))
    elif verdict == "pass" and False in unseen:
        result.append(("pass, unseen", "what happened between two samples may break it"))
    if verdict == "fail" and True in seen:
        result.append(("fail, may hold", "a placement that the recording allows fulfils it"))
    if verdict == "none" and "limits" in claim.keys:
        result.append(("no verdict", "it has limits"))
    if verdict == "inconclusive" and len(seen | unseen) == 1 and None not in seen and not COARSE.keys() & set(claim.names):
        result.append(("weak", f"all placements answer {next(iter(seen))}"))
    # Of a signal that is not known for a while, or of pulses whose width is open, a figure is stated as seen, with no verdict.
    as_seen = verdict == "inconclusive" and (found.unknown or "pulses-longer-than" in claim.keys)
    if answer.value and found.figures and not as_seen:
        result += of_figure(claim, answer, found)
    if answer.value and "limits" in claim.keys and verdict in ("pass", "fail"):
        result += of_stated(claim.keys["limits"], answer)
    if answer.margin is not None and not found.unknown and found.margins and None not in found.margins and verdict != "inconclusive":
        worst = float(min(found.margins))
        stated = float(answer.margin)
        off = 1e-9 * max(abs(worst), 1) + 1e-12 * scale(claim)
        sure = len(found.margins) == 1 and (not answer.value or answer.value[0] == answer.value[1])
        if stated > worst + off or sure and abs(stated - worst) > off:
            result.append(("margin", f"stated {stated!r}, the worst placement has {worst!r}"))
    return result


def of_stated(limits, answer):
    """A verdict is that of the figure as it is stated: all of it keeps the limits, or none of it."""
    low, high = (float(end) for end in answer.value)
    off = 1e-9 * max(abs(low), 1)
    least = -float("inf") if limits.low is None else float(limits.low)
    most = float("inf") if limits.high is None else float(limits.high)
    if answer.verdict == "pass" and (low < least - off or high > most + off):
        return [("verdict against its figure", f"stated {low!r} .. {high!r} passes {least!r} .. {most!r}")]
    if answer.verdict == "fail" and high > least + off and low < most - off:
        return [("verdict against its figure", f"stated {low!r} .. {high!r} fails {least!r} .. {most!r}")]
    return []


def scale(claim):
    """How large the limits are of a claim on a figure that is worked out: what its margin may be rounded by."""
    if claim.verb not in ("frequency", "duty", "jitter", "speed", "window"):
        return 0
    limits = claim.keys.get("is") or claim.keys.get("limits")
    return float(max((abs(end) for end in (limits.low, limits.high) if end is not None), default=0)) if limits else 0


def of_figure(claim, answer, found):
    """The stated interval has to hold the figure of every placement."""
    low, high = answer.value
    for figure in found.figures:
        if isinstance(figure, AtLeast):
            if float(high) < float(figure.least) * (1 - 1e-9) - 1e-6:
                return [("figure", f"stated {float(low)!r} .. {float(high)!r}, a placement has {float(figure.least)!r} or more")]
            continue
        if isinstance(figure, Rooted):
            real = float(figure)
            if not float(low) * (1 - 1e-9) - 1e-6 <= real <= float(high) * (1 + 1e-9) + 1e-6:
                return [("figure", f"stated {float(low)!r} .. {float(high)!r}, a placement has {real!r}")]
            continue
        figure = Fraction(figure)
        # A figure that is worked out may be rounded where the record writes it; a value that was read may not.
        off = 0 if claim.verb == "value" else abs(figure) * Fraction(1, 10 ** 12) + Fraction(1, 10 ** 9)
        if not low - off <= figure <= high + off:
            return [("figure", f"stated {low} .. {high}, a placement has {figure}")]
    return []
