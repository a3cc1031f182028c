"""What each verb of `expect` claims, said of one placement: docs/plans/expectations.md.

Each function answers True, False, or None where the manual does not say. Those of pulses and motion are in trains.py.
"""

from fractions import Fraction

import short_pulses
from placement import LAST

START, END = ("start", 0), ("end", 0)


def window(keys, placement):
    return placement.at(keys.get("from", START)), placement.at(keys.get("until", END))


def in_time(keys, placement, times):
    """The first of these times, all at or after `from`, is within its limits."""
    if not times:
        return False
    since = placement.at(keys.get("from", START))[0]
    return "within" not in keys or keys["within"].allow(times[0] - since)


def first_edge(kind):
    def holds(keys, placement):
        begin = placement.at(keys.get("from", START))
        return in_time(keys, placement, placement.edges(keys["signal"], kind, begin, placement.at(END)))
    return holds


def becomes(keys, placement):
    begin = placement.at(keys.get("from", START))

    def holds(track):
        return in_time(keys, placement, [time for time, before, after in track.changes(begin, placement.at(END)) if after and not before])
    return short_pulses.agreed(holds(track) for track in tested(keys, placement, keys["wanted"].has))


def tested(keys, placement, test):
    """Whether the value meets a test, as a line, without what is too short; more than one where it is open what that is."""
    return short_pulses.possible(short_pulses.levels(placement.tracks[keys["signal"]], test), keys.get("pulses-longer-than", 0),
                                 placement.steps["end"][0])


def merged(stretches):
    """Stretches that follow one another without a gap, put together."""
    found = []
    for since, to in stretches:
        if found and found[-1][1] == since:
            found[-1] = (found[-1][0], to)
        else:
            found.append((since, to))
    return found


def free_of(keys, placement, is_bad):
    """No stretch of the window is bad."""
    (begin, _), (end, _) = window(keys, placement)
    return short_pulses.agreed(not any(bad for _, _, bad in track.stretches(begin, end)) for track in tested(keys, placement, is_bad))


def stays(keys, placement):
    return free_of(keys, placement, lambda value: not keys["wanted"].has(value))


def never(keys, placement):
    if "signals" in keys:
        return not_together(keys, placement)
    return free_of(keys, placement, keys["wanted"].has)


def not_together(keys, placement):
    """At no time of the window are so many of these signals TRUE: all of them, or two."""
    (begin, _), (end, _) = window(keys, placement)
    tracks = [placement.tracks[name] for name in keys["signals"]]
    shortest = keys.get("pulses-longer-than", 0)

    def together(since, tracks):
        cuts = sorted({since} | {time for track in tracks for time, _ in track.at if since < time < end}) + [end]
        limit = len(tracks) if keys["how"] == "all" else 2
        return merged((one, other) for one, other in zip(cuts, cuts[1:])
                      if sum(track.value((one, LAST)) is True for track in tracks) >= limit)
    # Whether the time counts in which they are TRUE together, or each of their pulses, is not said.
    whole = not any(to - since > shortest for since, to in together(begin, tracks))
    if not shortest:
        return whole
    each = short_pulses.over_lines(lambda keys, placement: not together(begin, [placement.tracks[name] for name in keys["signals"]]),
                                   keys, placement, keys["signals"])
    return whole if whole == each else None


def edges(keys, placement):
    begin, end = window(keys, placement)
    return all(keys[key].allow(len(placement.edges(keys["signal"], kind, begin, end)))
               for key, kind in (("rising", "rises"), ("falling", "falls")) if key in keys)


def settles(keys, placement):
    begin, end = window(keys, placement)
    band = keys["wanted"].limits
    track = placement.tracks[keys["signal"]]
    settled = short_pulses.agreed(not any(bad for _, _, bad in line.stretches(begin[0] + keys["settle"], end[0]))
                                  for line in tested(keys, placement, lambda value: not band.allow(value)))
    if settled is None:
        return None
    if "overshoot" not in keys:
        return settled
    middle = Fraction(band.low + band.high, 2)
    before = track.value(placement.reading(keys.get("from", START)))
    step = middle - before
    if step == 0:
        return False if not settled else None
    allowed, relative = keys["overshoot"]
    if relative:
        allowed = abs(step) * allowed
    beyond = [(value - middle) * (1 if step > 0 else -1) for _, _, value in track.stretches(begin[0], end[0])]
    within = [(value - middle) * (1 if step > 0 else -1) for _, _, value in track.stretches(begin[0], begin[0] + keys["settle"])]
    # Whether what keeps to the band later can be an overshoot is not said.
    whole, early = max(beyond, default=0) <= allowed, max(within, default=0) <= allowed
    if not settled:
        return False
    return whole if whole == early else None


def follows(keys, placement):
    (begin, _), (end, _) = window(keys, placement)

    def apart(since):
        """The lengths of the stretches in which they are apart, from an instant to the end of the window."""
        tracks = placement.tracks[keys["signal"]], placement.tracks[keys["leader"]]
        cuts = sorted({since} | {time for track in tracks for time, _ in track.at if since < time < end}) + [end]
        found = []
        for one, other in zip(cuts, cuts[1:]):
            left, right = (track.value((one, LAST)) for track in tracks)
            if left is not None and right is not None and distance(left, right) > keys.get("tolerance", 0):
                found.append((one, other))
        return merged(found)
    # A time counts from when it began, before the window too.
    return all(to - since <= keys.get("longest", 0) for since, to in apart(-LAST) if to > begin)


def distance(left, right):
    if isinstance(left, bool) or isinstance(left, str):
        return int(left != right)
    return abs(left - right)


def value(keys, placement):
    seen = placement.tracks[keys["of"]].value(placement.reading(keys.get("when", END)))
    if "near" in keys:
        near = keys["near"]
        if isinstance(near, str):
            near = placement.tracks[near].value(placement.reading(keys["near-at"]))
        return distance(seen, near) <= keys["tolerance"]
    return keys["wanted"].has(seen)


def equal(keys, placement):
    left, right = (placement.tracks[keys[side]].value(placement.reading(keys.get(side + "-at", keys.get("when", END))))
                   for side in ("left", "right"))
    return distance(left, right) <= keys.get("tolerance", 0)


def order(keys, placement):
    begin, end = placement.at(keys.get("from", START)), placement.at(END)
    firsts = []
    for name, kind in keys["edges"]:
        track = placement.tracks[name]
        found = [position for position, (_, before, after) in
                 zip([at for at in track.at if begin <= at < end], track.changes(begin, end)) if is_kind(kind, before, after)]
        if not found:
            return False
        firsts.append(found[0])
    if len(set(firsts)) < len(firsts):
        # Whether one edge is before itself is not said.
        return None
    return all(one < other for one, other in zip(firsts, firsts[1:]))


def is_kind(kind, before, after):
    return before != after if kind == "changes" else after and not before if kind == "rises" else before and not after


def happens(keys, placement):
    """An awaited step came, and in time: a placement has the steps that came."""
    if keys["step"] not in placement.steps:
        return False
    if "within" not in keys:
        return True
    came, since = placement.steps[keys["step"]][0], placement.at(keys.get("from", START))[0]
    # One that came before is too early.
    return in_time(keys, placement, [came] if came >= since else [])


def state(keys, placement):
    how = keys["how"]
    return {"is": value, "becomes": becomes, "stays": stays}[how](dict(keys, of=keys["signal"]), placement)


def log(keys, placement):
    begin, end = window(keys, placement)
    added = placement.edges(keys["signal"], "changes", begin, end)
    return not added if keys["how"] == "never" else in_time(keys, placement, added)


def task(keys, placement):
    if "when" in keys:
        return value(dict(keys, of=keys["signal"]), placement)
    return stays(keys, placement)


def frames(keys, placement):
    begin, end = window(keys, placement)
    times = placement.edges(keys["signal"], "changes", begin, end)
    if "count" in keys and not keys["count"].allow(len(times)):
        return False
    if "cycle" in keys:
        if len(times) < 2 or not all(keys["cycle"].allow(to - since) for since, to in zip(times, times[1:])):
            return False
    if "gap" in keys:
        marks = [begin[0], *times, end[0]]
        if any(to - since > keys["gap"] for since, to in zip(marks, marks[1:])):
            return False
    return True


VERBS = {"rises": first_edge("rises"), "falls": first_edge("falls"), "changes": first_edge("changes"), "becomes": becomes,
         "stays": stays, "never": never, "edges": edges, "settles": settles, "follows": follows, "state": state,
         "led": state, "log": log, "task": task, "value": value, "equal": equal, "order": order, "happens": happens,
         "frames": frames}
