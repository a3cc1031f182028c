"""What the claims on pulses and motion and the measurements come to in one placement: docs/plans/pulses.md, measurements.md.

A figure is an exact fraction. `MISSING` is one that has nothing to be taken of, which fails; None is one of which the manual
does not say what it is.
"""

from fractions import Fraction

import short_pulses
from placement import LAST
from verbs import END, START, VERBS, window

SECOND = 1_000_000_000
MISSING = "missing"


class Rooted:
    """The root of a fraction, compared by its square."""

    def __init__(self, square):
        self.square = square

    def compare(self, other):
        return (0, self.square) if other < 0 else (other * other, self.square)

    def __ge__(self, other):
        least, square = self.compare(other)
        return square >= least if other >= 0 else True

    def __le__(self, other):
        most, square = self.compare(other)
        return square <= most if other >= 0 else False

    def __eq__(self, other):
        return isinstance(other, Rooted) and self.square == other.square

    def __float__(self):
        return float(self.square) ** 0.5


def with_filter(figure):
    """Without the short pulses of its lines."""
    def taken(keys, placement):
        if "pulses-longer-than" not in keys:
            return figure(keys, placement)
        names = [keys[key] for key in ("signal", "of", "reference", "direction", "down", "quadrature") if key in keys]
        return short_pulses.over_lines(figure, keys, placement, names + [name for name, _ in keys.get("edges", ())])
    return taken


def window_edges(keys, placement, kind=None):
    begin, end = window(keys, placement)
    return placement.edges(keys["signal"], kind or keys.get("edge", "rises"), begin, end)


def frequency(keys, placement):
    times = window_edges(keys, placement)
    return Fraction((len(times) - 1) * SECOND, times[-1] - times[0]) if len(times) > 1 else MISSING


def duty(keys, placement):
    times = window_edges(keys, placement)
    if len(times) < 2:
        return MISSING
    high = sum(to - since for since, to, value in placement.tracks[keys["signal"]].stretches(times[0], times[-1]) if value)
    return Fraction(high * 100, times[-1] - times[0])


def taken(lengths, take):
    if not lengths:
        return MISSING
    return {"first": lengths[0], "min": min(lengths), "max": max(lengths), "span": max(lengths) - min(lengths),
            "mean": Fraction(sum(lengths), len(lengths))}[take]


def periods(keys, placement):
    times = window_edges(keys, placement)
    return [to - since for since, to in zip(times, times[1:])]


def period(keys, placement):
    """The measurement of cycles; the claim of `period` is on each of them."""
    return taken(periods(keys, placement), keys.get("take", "mean"))


def pulses(keys, placement):
    """(beginning, end) of each pulse that begins in the window; no end where it still lasts at the end of the case."""
    level = keys.get("level", "high") == "high"
    begin, end = window(keys, placement)
    over = placement.at(END)
    track = placement.tracks[keys["signal"]]
    found = []
    for since in placement.edges(keys["signal"], "rises" if level else "falls", begin, end):
        ends = [time for time, _, after in track.changes((since, LAST), over) if after is not level]
        found.append((since, ends[0] if ends else None))
    return found


def width(keys, placement):
    found = pulses(keys, placement)
    if keys.get("take", "first") == "first" and found and found[0][1] is None:
        return None
    ended = [to - since for since, to in found if to is not None]
    if found and not ended:
        return None
    return taken(ended, keys.get("take", "first"))


def pulse(keys, placement):
    found = pulses(keys, placement)
    if not found:
        return False
    over = placement.at(END)[0]
    answers = []
    for since, to in found[:1] if keys.get("which", "first") == "first" else found:
        limits = keys["width"]
        if to is not None:
            answers.append(limits.allow(to - since))
        elif limits.high is not None:
            answers.append(False if over - since > limits.high else None)
        else:
            answers.append(True if over - since >= limits.low else None)
    return False if False in answers else None if None in answers else True


def all_periods(keys, placement):
    lengths = periods(keys, placement)
    return bool(lengths) and all(keys["is"].allow(length) for length in lengths)


def jitter(keys, placement):
    times = window_edges(keys, placement)
    if len(times) < 3:
        return MISSING
    grid = keys.get("grid")
    rms = keys.get("take", "span") == "rms"
    if keys.get("compares", "edges") == "periods":
        lengths = [to - since for since, to in zip(times, times[1:])]
        if not rms:
            # What a grid is to the longest period less the shortest one is not said; it does not change the difference.
            return max(lengths) - min(lengths)
        middle = Fraction(grid) if grid is not None else Fraction(sum(lengths), len(lengths))
        return Rooted(sum((length - middle) ** 2 for length in lengths) / len(lengths))
    count = len(times)
    if rms:
        rate = grid
        if rate is None:
            mean = Fraction(count - 1, 2)
            rate = sum((index - mean) * time for index, time in enumerate(times)) / sum((index - mean) ** 2 for index in range(count))
        left = [time - index * Fraction(rate) for index, time in enumerate(times)]
        mean = sum(left) / count
        return Rooted(sum((one - mean) ** 2 for one in left) / count)

    def band(rate):
        left = [time - index * rate for index, time in enumerate(times)]
        return max(left) - min(left)
    if grid is not None:
        return band(Fraction(grid))
    # The narrowest band touches edges on one side at two places: its slope is that of two of the edges.
    return min(band(Fraction(times[j] - times[i], j - i)) for i in range(count) for j in range(i + 1, count))


def speed(keys, placement):
    (begin, _), (end, _) = window(keys, placement)
    track = placement.tracks[keys["signal"]]
    ends = [track.value(placement.reading(keys.get(key, other))) for key, other in (("from", START), ("until", END))]
    # At the very instant of a change it is not said which number counts.
    if any(time in (begin, end) for time, _ in track.at):
        return None
    return Fraction((ends[1] - ends[0]) * SECOND, end - begin)


def angles(keys, placement):
    """The angle of each whole cycle in degrees; MISSING where one is missing, None where it is not clear which edge is meant."""
    begin, end = window(keys, placement)
    kind = keys.get("edge", "rises")
    cycles = placement.edges(keys["reference"], kind, begin, end)
    if len(cycles) < 2:
        return MISSING
    limits = keys["is"]
    middle = Fraction(limits.low + limits.high, 2)
    everything = placement.edges(keys["of"], kind, (-LAST, 0), (LAST, 0))
    found = []
    for since, to in zip(cycles, cycles[1:]):
        turn = to - since
        centre = since + middle / 360 * turn
        near = [time for time in everything if abs(time - centre) <= Fraction(turn, 2)]
        if not near:
            return MISSING
        if len(near) > 1 or abs(near[0] - centre) == Fraction(turn, 2):
            return None
        # Whether an edge outside of the window belongs to a cycle inside of it is not said.
        if not begin[0] <= near[0] < end[0]:
            return None
        found.append(Fraction((near[0] - since) * 360, turn))
    return found


def phase(keys, placement):
    found = angles(keys, placement)
    if found is None or found == MISSING:
        return None if found is None else False
    return all(keys["is"].allow(angle) for angle in found)


def counts(keys, placement):
    """(time, +1 or -1) of each count of a pulse train in the window; None where it is not known which line was first."""
    begin, end = window(keys, placement)
    name = keys["signal"]
    if "quadrature" in keys:
        other = keys["quadrature"]
        lines = {line: [(at, after) for at, (_, _, after) in zip([at for at in placement.tracks[line].at if begin <= at < end],
                 placement.tracks[line].changes(begin, end))] for line in (name, other)}
        if {at[0] for at, _ in lines[name]} & {at[0] for at, _ in lines[other]}:
            return None
        both = [(at[0], after != placement.tracks[other].value(at)) for at, after in lines[name]]
        both += [(at[0], after == placement.tracks[name].value(at)) for at, after in lines[other]]
        return [(time, 1 if up else -1) for time, up in sorted(both)]
    rises = placement.edges(name, "rises", begin, end)
    if "down" in keys:
        return sorted([(time, 1) for time in rises] + [(time, -1) for time in placement.edges(keys["down"], "rises", begin, end)])
    if "direction" in keys:
        way = placement.tracks[keys["direction"]]
        if set(rises) & {time for time, _ in way.at}:
            return None
        return [(time, 1 if way.value((time, 0)) != keys.get("inverted", False) else -1) for time in rises]
    return [(time, 1) for time in rises]


def position(keys, placement):
    if keys.get("number"):
        begin, end = window(keys, placement)
        track = placement.tracks[keys["signal"]]
        if any(time in (begin[0], end[0]) for time, _ in track.at):
            return None
        return track.value(placement.reading(keys.get("until", END))) - track.value(placement.reading(keys.get("from", START)))
    found = counts(keys, placement)
    return None if found is None else sum(way for _, way in found)


def area(points, since, to):
    """Counts that a shape goes by between two times, both counted from its beginning."""
    total = Fraction(0)
    line = [(Fraction(0), Fraction(0))] if not points else []
    line += [(Fraction(time), Fraction(rate)) for time, rate in points]
    if line[0][0] > 0:
        line.insert(0, (Fraction(0), line[0][1]))
    line.append((Fraction(max(to, line[-1][0]) + 1), line[-1][1]))
    for (t0, f0), (t1, f1) in zip(line, line[1:]):
        low, high = max(t0, since), min(t1, to)
        if low >= high:
            continue
        slope = (f1 - f0) / (t1 - t0)
        total += (high - low) * (f0 + slope * (low - t0) + f0 + slope * (high - t0)) / 2
    return total / SECOND


def profile(keys, placement):
    """What follows from the distances of counts alone, one after the other: a train that goes one way, a shape above its
    tolerance everywhere. What else may break the claim is left open near the limits."""
    if any(key in keys for key in ("over", "direction", "down", "quadrature")):
        return None
    found = counts(keys, placement)
    if not found:
        return False
    begin, end = (position[0] for position in window(keys, placement))
    points, off = keys["points"], keys["tolerance"]
    lower = [(time, rate - off) for time, rate in points]
    upper = [(time, rate + off) for time, rate in points]
    times = [time - begin for time, _ in found]
    # How far its instants may be off says nothing of an even shape away from its beginning; else it is left open.
    shifts = keys.get("shape-within", 0)
    for since, to in zip(times, times[1:]):
        if area(lower, since, to) > 1 or area(upper, since, to) < 1:
            return False if since >= shifts and (not shifts or len(points) == 1) else None
    over = end - begin
    if area(lower, shifts, times[0]) > 1 or area(lower, max(times[-1], shifts), over) > 1:
        return False if not shifts or len(points) == 1 else None
    # Where in its turn it begins is not said.
    if area(upper, 0, times[0]) < 1 or area(lower, 0, times[0]) >= 1 or area(lower, times[-1], over) >= 1:
        return None
    return True


class AtLeast:
    """A figure of which is known what it is not below."""

    def __init__(self, least):
        self.least = least

    def __eq__(self, other):
        return isinstance(other, AtLeast) and self.least == other.least


def off_shape(keys, placement):
    """By how much a train is off an even shape at least: what the distances of its counts need."""
    found = counts(keys, placement)
    if not found or len(keys["points"]) > 1:
        return None if found else MISSING
    rate = keys["points"][0][1]
    return AtLeast(max((abs(Fraction(SECOND, to[0] - since[0]) - rate) for since, to in zip(found, found[1:])), default=Fraction(0)))


def limited(figure):
    """The claim that a figure keeps its limits."""
    def holds(keys, placement):
        found = figure(keys, placement)
        if found is None:
            return None
        return found != MISSING and keys["is"].allow(found)
    return holds


def time(keys, placement):
    begin = placement.at(keys.get("from", START))
    if "to" in keys:
        return placement.at(keys["to"])[0] - begin[0]
    times = placement.edges(keys["signal"], keys["edge"], begin, placement.at(END))
    return times[0] - begin[0] if times else MISSING


def value_at(keys, placement):
    return placement.tracks[keys["signal"]].value(placement.reading(keys.get("when", END)))


def over_window(keys, placement):
    (begin, _), (end, _) = window(keys, placement)
    parts = [(to - since, int(value) if isinstance(value, bool) else value)
             for since, to, value in placement.tracks[keys["signal"]].stretches(begin, end)]
    values = [value for _, value in parts]
    if not values:
        return None
    take = keys["take"]
    if take in ("mean", "rms"):
        power = 1 if take == "mean" else 2
        mean = Fraction(sum(length * Fraction(value) ** power for length, value in parts), end - begin)
        return mean if take == "mean" else Rooted(mean)
    return {"min": min(values), "max": max(values), "span": max(values) - min(values)}[take]


VERBS.update({"pulse": pulse, "period": with_filter(all_periods), "frequency": with_filter(limited(frequency)),
              "duty": with_filter(limited(duty)), "jitter": with_filter(limited(jitter)), "speed": limited(speed),
              "phase": with_filter(phase), "position": with_filter(limited(position)), "profile": with_filter(profile)})
for verb in ("rises", "falls", "changes", "edges", "order", "pulse"):
    VERBS[verb] = with_filter(VERBS[verb])
MEASURES = {"time": time, "value": value_at, "window": with_filter(over_window), "frequency": with_filter(frequency),
            "duty": with_filter(duty), "period": with_filter(period), "width": with_filter(width), "speed": speed,
            "jitter": with_filter(jitter), "position": with_filter(position), "profile": with_filter(off_shape)}
