"""What a recording leaves open, and the placements that it allows.

A recording says of each change between which two instants it lies. Every placement that keeps to them, and to the order of the
changes of one signal, is as good as another. A value that is not known may be any, and so may be what a sampled signal was
between two samples. Some of these placements are drawn: the ends of the intervals, instants at which a limit is just met,
instants in between. So what is found is a contradiction, and what is not found is no proof.
"""

from placement import Placement, Track

# Where in their intervals changes are: as early as they can be, pulses as wide as they can be, all as even as they can be ...
WAYS = ("early", "late", "wide", "narrow", "spread", "drawn", "even", "corner", "corner", "marks", "between")
# Ranks of changes that stand in no trace: after what does, at one instant.
HELD_BACK = 1 << 30
UNSEEN_RANK = 1 << 40


class Change:
    """A value and between which instants it began, both possible; `rank` is its place among what the trace has at one instant."""

    __slots__ = ("early", "late", "rank", "value")

    def __init__(self, early, late, rank, value):
        self.early, self.late, self.rank, self.value = early, late, rank, value


class Recording:
    """The changes of signals by their names, the steps, and for a sampled recording the times of its samples."""

    def __init__(self, tracks, steps, samples=None, pool=None, awaited=()):
        self.tracks = {name: cut(changes) for name, changes in tracks.items()}
        self.steps = steps
        self.samples = samples
        self.pool = pool or {}
        self.awaited = {step: rest for step, *rest in awaited}
        self.exact = {name: all(change.early == change.late for change in changes) for name, changes in self.tracks.items()}

    def known(self, names):
        """Nothing of these signals is left open."""
        return self.samples is None and all(self.exact[name] and None not in [change.value for change in self.tracks[name][1:]]
                                            for name in names)

    def placements(self, rng, names, bases, marks, count, unseen_from=None):
        """Placements of these signals. `bases` are the steps that are looked at, `marks` instants at which something may be
        decided. With `unseen_from` there are pulses between samples that are longer than this; a step that waits comes with what
        was seen, as it does while a case runs."""
        if self.known(names):
            yield self.placement({name: [(change.early, change.rank, change.value) for change in self.tracks[name]] for name in names})
            return
        for turn in range(count):
            tracks, seen = {}, {}
            for name in names:
                # At first all signals alike, later each in a way of its own.
                way = WAYS[turn % len(WAYS)] if turn < len(WAYS) else rng.choice(WAYS)
                placed = place(self.tracks[name], rng, way, marks)
                if placed is None:
                    break
                placed = seen[name] = self.filled(name, placed, rng)
                if unseen_from is not None and self.samples and rng.random() < 0.7:
                    placed = self.with_unseen(name, placed, rng, unseen_from)
                tracks[name] = placed
            else:
                placement = None if self.ties(tracks, bases) else self.placement(tracks, seen)
                if placement is not None:
                    yield placement

    def unknown(self, names):
        """A value of one of these signals is not known for a while."""
        return any(change.value is None for name in names for change in self.tracks[name][1:])

    def placement(self, tracks, seen=None):
        """With the steps that wait where what they wait for is seen to come; it does not come alone."""
        placement = Placement({name: Track(changes) for name, changes in tracks.items()}, dict(self.steps))
        watched = Placement({name: Track(changes) for name, changes in (seen or tracks).items()}, placement.steps)
        for step, (signal, kind, since, limit) in self.awaited.items():
            if signal not in tracks:
                continue
            begin = placement.at((since, 0))
            times = watched.edges(signal, kind, begin, placement.at(("end", 0)))
            if times and times[0] - begin[0] <= limit:
                if any(time == times[0] for name, track in placement.tracks.items() if name != signal for time, _ in track.at):
                    return None
                placement.steps[step] = (times[0], UNSEEN_RANK - 1)
        return placement

    def ties(self, tracks, bases):
        """Changes whose order is left open fall together: which one came first is not worth a verdict."""
        seen = {self.steps[base][0] for base in bases if base in self.steps}
        for name, changes in tracks.items():
            mine = {time for time, _, _ in changes}
            if not self.exact[name] and mine & seen:
                return True
            seen |= mine
        return False

    def filled(self, name, changes, rng):
        """Where the value is not known, it is one of those that it may be, and perhaps another one after a while."""
        done = []
        for index, (time, rank, value) in enumerate(changes):
            if value is not None or index == 0:
                done.append((time, rank, value))
                continue
            end = changes[index + 1][0] if index + 1 < len(changes) else time + 10_000_000
            done.append((time, rank, rng.choice(self.pool[name])))
            if end - time > 2 and rng.random() < 0.5:
                done.append((rng.randrange(time + 1, end), rank, rng.choice(self.pool[name])))
        return same_left_out(done)

    def with_unseen(self, name, changes, rng, shortest):
        """A pulse or several between two samples."""
        placed = list(changes)
        for _ in range(rng.choice((1, 1, 2, 8))):
            index = rng.randrange(len(self.samples) - 1)
            since, to = self.samples[index], self.samples[index + 1]
            if to - since - 2 <= shortest or any(since < time <= to for time, _, _ in placed):
                continue
            length = rng.randrange(shortest + 1, to - since)
            begin = rng.randrange(since + 1, to - length + 1)
            before = [value for time, _, value in placed if time <= since]
            if not before or before[-1] is None:
                continue
            others = [value for value in self.pool[name] if value != before[-1]]
            if not others:
                continue
            placed += [(begin, UNSEEN_RANK, rng.choice(others)), (begin + length, UNSEEN_RANK + 1, before[-1])]
            placed.sort(key=lambda change: change[:2])
        return placed


def same_left_out(changes):
    kept = []
    for change in changes:
        if not kept or kept[-1][2] != change[2]:
            kept.append(change)
    return kept


def cut(changes):
    """Intervals of one signal of which neither end runs backwards: any instant that is left has room for the others."""
    changes = [Change(change.early, change.late, change.rank, change.value) for change in changes]
    exact = [change.early == change.late for change in changes]
    for index in range(1, len(changes)):
        apart = 0 if exact[index] and exact[index - 1] else 1
        changes[index].early = max(changes[index].early, changes[index - 1].early + apart)
    for index in range(len(changes) - 2, -1, -1):
        apart = 0 if exact[index] and exact[index + 1] else 1
        changes[index].late = min(changes[index].late, changes[index + 1].late - apart)
    return changes


def place(changes, rng, way, marks):
    """One instant for each change, later ones later; None where this turn finds none."""
    if way == "even":
        goals = even(changes, rng)
    elif way in ("spread", "drawn"):
        turn = rng.randrange(len(changes) + 1)
        goals = [change.early if (index < turn) == (way == "spread") else change.late for index, change in enumerate(changes)]
    else:
        goals = [goal(change, index, rng, way, marks) for index, change in enumerate(changes)]
    placed, last = [], None
    for change, wanted in zip(changes, goals):
        low = change.early
        if last is not None and low <= last and change.early != change.late:
            low = last + 1
        if low > change.late or last is not None and low < last:
            return None
        last = min(max(round(wanted), low), change.late)
        placed.append((last, change.rank, change.value))
    return placed


def goal(change, index, rng, way, marks):
    """Where a change is to be."""
    if way in ("early", "late"):
        return change.early if way == "early" else change.late
    if way in ("wide", "narrow"):
        # The first of a line is what it was at first: pulses begin with every second one after it.
        return change.early if (index % 2 == 1) == (way == "wide") else change.late
    if way == "corner":
        return rng.choice((change.early, change.late))
    near = [mark for mark in marks if change.early <= mark <= change.late] if way == "marks" else []
    return rng.choice(near) if near and rng.random() < 0.8 else rng.randint(change.early, change.late)


def even(changes, rng):
    """Instants at which every second change comes evenly, by the distance of two of them."""
    goals = [rng.randint(change.early, change.late) for change in changes]
    for first in (1, 2):
        places = list(range(first, len(changes), 2))
        if len(places) < 3:
            continue
        one, other = sorted(rng.sample(range(len(places)), 2))
        since, to = (rng.choice((changes[places[at]].early, changes[places[at]].late)) for at in (one, other))
        period = (to - since) / (other - one)
        for index, at in enumerate(places):
            goals[at] = since + (index - one) * period
    return goals
