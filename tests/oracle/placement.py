"""Placements: what every signal was at every instant, exactly, and where the steps lie.

A position is a pair of nanoseconds and a rank among what happens at that nanosecond. What a trace records has the rank at
which it stands there, a step too. An instant at a distance from a step has rank 0: a change at that very nanosecond comes
after it. A value that is read there is the new one, so reading looks at the last rank.
"""

import bisect

LAST = 1 << 60


class NeverCame(Exception):
    """An instant counts from a step that did not come."""


class Track:
    """One signal: its values, each from a position on. What it was before the first one is not known."""

    def __init__(self, changes):
        self.at = [(time, rank) for time, rank, _ in changes]
        self.values = [value for _, _, value in changes]

    def value(self, position):
        """The value right before what has this position; None where it is not known."""
        index = bisect.bisect_left(self.at, position) - 1
        return self.values[index] if index >= 0 else None

    def changes(self, begin, end):
        """(time, before, after) of each change from a position on and before another one."""
        index = bisect.bisect_left(self.at, begin)
        while index < len(self.at) and self.at[index] < end:
            yield self.at[index][0], self.values[index - 1] if index else None, self.values[index]
            index += 1

    def stretches(self, begin, end):
        """(time, time, value) of each stretch of the time from `begin` to `end` in which the value is one; no empty ones."""
        index = max(bisect.bisect_right(self.at, (begin, LAST)) - 1, 0)
        while index < len(self.at) and self.at[index][0] < end:
            since = max(self.at[index][0], begin)
            to = min(self.at[index + 1][0] if index + 1 < len(self.at) else end, end)
            if since < to:
                yield since, to, self.values[index]
            index += 1


class Placement:
    """The tracks by their names, and the positions of the steps that came, `start` and `end` among them."""

    def __init__(self, tracks, steps):
        self.tracks = tracks
        self.steps = steps

    def at(self, instant):
        """Where an instant, a base and a distance in nanoseconds, lies."""
        base, distance = instant
        if base not in self.steps:
            raise NeverCame(base)
        time, rank = self.steps[base]
        return (time + distance, 0) if distance else (time, rank)

    def reading(self, instant):
        """Where a value at this instant is read: after all that happens there, but before the step if it is one."""
        time, rank = self.at(instant)
        return (time, rank or LAST)

    def edges(self, name, kind, begin, end):
        """The times of the edges of a kind."""
        return [time for time, before, after in self.tracks[name].changes(begin, end) if is_edge(kind, before, after)]


def is_edge(kind, before, after):
    """Whether a change is an edge: `rises` of a Boolean is from FALSE to TRUE; of a number that counts, each change."""
    if kind == "changes" or not isinstance(after, bool):
        return before != after
    return after and not before if kind == "rises" else before and not after
