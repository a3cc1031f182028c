"""What is left of a signal without its short pulses: docs/plans/expectations.md, `pulses-longer-than`.

A stretch of either level that is not longer is as if it were not there: a change counts once its new level lasts for longer, and
then from its own instant. How long the first and the last stretch that are known were is not known if what is seen of them is
short; then both are possible.
"""

import itertools

from placement import LAST, Placement, Track


def levels(track, test=None):
    """(position, level) of a line, or of whether a test of the value is met."""
    found = []
    for at, value in zip(track.at, track.values):
        level = value if test is None or value is None else bool(test(value))
        if level is not None and (not found or found[-1][1] != level):
            found.append((at, level))
    return found


def possible(changes, shortest, end):
    """The tracks that can be meant: one, or several where a stretch at the beginning or at the end may be short or long."""
    if not changes:
        return [Track([])]
    times = [at[0] for at, _ in changes]
    first = [True] if len(changes) == 1 or times[1] - times[0] > shortest else [True, False]
    last = [True] if end - times[-1] > shortest or len(changes) == 1 else [True, False]
    return [without(changes, shortest, *ways) for ways in itertools.product(first, last)]


def without(changes, shortest, first_is_long, last_is_long):
    level = changes[0][1] if first_is_long else not changes[0][1]
    kept = [((-LAST, 1), level)]
    for index in range(0 if first_is_long else 1, len(changes)):
        at, value = changes[index]
        if index + 1 < len(changes):
            long = index == 0 or changes[index + 1][0][0] - at[0] > shortest
        else:
            long = last_is_long
        if long and value != kept[-1][1]:
            kept.append((at, value))
    track = Track([])
    track.at, track.values = [at for at, _ in kept], [value for _, value in kept]
    return track


def agreed(answers):
    """What all ways to take it come to; None where they differ."""
    answers = list(answers)
    return answers[0] if all(answer == answers[0] for answer in answers) else None


def over_lines(answer, keys, placement, names):
    """What a claim comes to without the short pulses of its lines; of numbers every value counts."""
    shortest = keys["pulses-longer-than"]
    end = placement.steps["end"][0]
    lines = [name for name in names if isinstance(placement.tracks[name].values[-1], bool)]
    ways = itertools.product(*(possible(levels(placement.tracks[name]), shortest, end) for name in lines))
    return agreed(answer(keys, Placement(placement.tracks | dict(zip(lines, tracks)), placement.steps)) for tracks in ways)
