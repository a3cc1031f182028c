#!/usr/bin/env python3
"""The oracle itself, held against verdicts that were worked out by hand: tests/oracle/selftest.py.

Times are milliseconds. `lamp` and the other lines are drawn as they are from 0 on, a character each millisecond.
"""

import random
import sys
from fractions import Fraction

import compare
import trains
from drawing import Claim
from figures import Limits, MS, Wanted, duration, text
from placement import Placement, NeverCame, Track
from recording import Change, Recording
from rig import Answer
from trains import MEASURES, MISSING
from verbs import VERBS

#        0         1         2         3         4
LINES = {"lamp": "____####____####____####________________",
         "late": "_____####____####____####_______________",
         "odd_": "____##____######____#___________________",
         "up__": "__#___#___#___#_________________________",
         "down": "____________________#___#_______________",
         "way_": "###########_____________________________",
         "a___": "__####____####____####__________________",
         "b___": "____####____####____####________________"}
NUMBERS = {"level": [(-100, 0), (5, 10), (10, 14), (12, 11), (30, 10)],
           "copy": [(-100, 0), (7, 10), (10, 14), (12, 11), (30, 11)],
           "count": [(-100, 0), (3, 1 << 60), (8, (1 << 60) + 1), (20, (1 << 60) + 2)]}


def line(drawn):
    changes, last = [(-100 * MS, 1, drawn[0] == "#")], drawn[0]
    for time, level in enumerate(drawn):
        if level != last:
            changes.append((time * MS, 5, level == "#"))
        last = level
    return Track(changes)


def numbers(changes):
    return Track([(time * MS, 5, Fraction(value)) for time, value in changes])


TRACKS = {name: line(drawn) for name, drawn in LINES.items()} | {name: numbers(found) for name, found in NUMBERS.items()}
STEPS = {"start": (0, 2), "press": (4 * MS, 3), "go": (9 * MS + MS // 2, 3), "end": (40 * MS, 9)}
PLACEMENT = Placement(TRACKS, STEPS)


def at(ms, base="start"):
    return (base, int(ms * MS))


def ms(low, high):
    return Limits(None if low is None else Fraction(low) * MS, None if high is None else Fraction(high) * MS)


def only(*values):
    return Wanted([Fraction(value) if not isinstance(value, bool) else value for value in values])


def between(low, high):
    return Wanted(limits=Limits(low, high))


# A verb, what it says, and whether that holds.
CLAIMS = [
    ("rises", {"signal": "lamp", "within": ms(0, 4)}, True),
    ("rises", {"signal": "lamp", "within": ms(5, 20)}, False),
    # The line rises at the instant of the step and after it.
    ("rises", {"signal": "lamp", "from": at(0, "press"), "within": ms(0, 0)}, True),
    ("rises", {"signal": "lamp", "from": at(30)}, False),
    ("rises", {"signal": "lamp", "from": at(4), "within": ms(0, 0)}, True),
    ("falls", {"signal": "lamp", "from": at(5), "within": ms(3, 3)}, True),
    ("changes", {"signal": "level", "from": at(6), "within": ms(0, Fraction(39, 10))}, False),
    ("becomes", {"signal": "level", "wanted": between(12, 20), "within": ms(10, 10)}, True),
    ("becomes", {"signal": "level", "wanted": between(0, 20)}, False),
    ("stays", {"signal": "lamp", "wanted": only(False), "until": at(4)}, True),
    ("stays", {"signal": "lamp", "wanted": only(False), "until": at(4.000001)}, False),
    # What ends where the window begins is not in it.
    ("stays", {"signal": "lamp", "wanted": only(True), "from": at(4), "until": at(8)}, True),
    ("stays", {"signal": "odd_", "wanted": only(False), "pulses-longer-than": 6 * MS}, True),
    ("stays", {"signal": "odd_", "wanted": only(False), "pulses-longer-than": 6 * MS - 1}, False),
    # A pulse counts by its whole length, and what is too short is not there.
    ("stays", {"signal": "odd_", "wanted": only(False), "from": at(11), "until": at(14), "pulses-longer-than": 5 * MS}, False),
    ("rises", {"signal": "odd_", "within": ms(10, 10), "pulses-longer-than": 2 * MS}, True),
    ("rises", {"signal": "lamp", "within": ms(4, 4), "pulses-longer-than": 4 * MS}, False),
    ("becomes", {"signal": "level", "wanted": between(10, 20), "within": ms(5, 5), "pulses-longer-than": 4 * MS}, True),
    ("becomes", {"signal": "level", "wanted": only(14), "pulses-longer-than": 2 * MS}, False),
    ("settles", {"signal": "level", "wanted": between(9, 12), "settle": 8 * MS, "pulses-longer-than": 2 * MS}, True),
    ("never", {"signals": ["lamp", "late"], "how": "all", "pulses-longer-than": 3 * MS}, None),
    ("never", {"signal": "level", "wanted": only(14), "from": at(12)}, True),
    ("never", {"signal": "level", "wanted": only(14), "from": at(11)}, False),
    ("never", {"signals": ["lamp", "late"], "how": "all"}, False),
    ("never", {"signals": ["up__", "down", "lamp"], "how": "all"}, True),
    ("never", {"signals": ["a___", "b___", "down"], "how": "any-two"}, False),
    ("edges", {"signal": "lamp", "rising": Limits(3, 3), "falling": Limits(3, 3)}, True),
    ("edges", {"signal": "lamp", "rising": Limits(1, 1), "from": at(4), "until": at(12)}, True),
    ("edges", {"signal": "lamp", "rising": Limits(2, 2), "from": at(4), "until": at(12)}, False),
    ("edges", {"signal": "odd_", "rising": Limits(2, 2), "pulses-longer-than": 1 * MS}, True),
    ("settles", {"signal": "level", "wanted": between(9, 12), "settle": 12 * MS}, True),
    ("settles", {"signal": "level", "wanted": between(9, 12), "settle": 11 * MS}, False),
    # From 0 to 10.5 it went 3.5 too far, a third of the step.
    ("settles", {"signal": "level", "wanted": between(9, 12), "settle": 12 * MS, "overshoot": (Fraction(7, 2), False)}, True),
    ("settles", {"signal": "level", "wanted": between(9, 12), "settle": 12 * MS, "overshoot": (Fraction(33, 100), True)}, False),
    ("settles", {"signal": "level", "wanted": between(9, 12), "settle": 12 * MS, "overshoot": (Fraction(34, 100), True)}, True),
    ("follows", {"signal": "copy", "leader": "level", "tolerance": 1}, False),
    ("follows", {"signal": "copy", "leader": "level", "tolerance": 1, "longest": 2 * MS}, True),
    ("follows", {"signal": "copy", "leader": "level", "longest": 9 * MS}, False),
    ("follows", {"signal": "copy", "leader": "level", "longest": 10 * MS}, True),
    ("state", {"signal": "count", "how": "is", "wanted": only(1 << 60), "when": at(5)}, True),
    ("led", {"signal": "count", "how": "becomes", "wanted": only(1 << 60), "within": ms(0, 3)}, True),
    ("state", {"signal": "count", "how": "stays", "wanted": only(1 << 60), "from": at(3), "until": at(9)}, False),
    ("log", {"signal": "count", "how": "contains", "from": at(4), "within": ms(0, 4)}, True),
    ("log", {"signal": "count", "how": "never", "from": at(9), "until": at(20)}, True),
    ("task", {"signal": "level", "wanted": between(0, 14)}, True),
    ("task", {"signal": "level", "wanted": between(11, 14), "when": at(30)}, False),
    # At the instant of a step the value is the one before it, at a distance the new one.
    ("value", {"of": "lamp", "wanted": only(False), "when": at(0, "press")}, True),
    ("value", {"of": "lamp", "wanted": only(True), "when": at(4)}, True),
    ("value", {"of": "count", "wanted": only((1 << 60) + 2)}, True),
    ("value", {"of": "count", "wanted": only((1 << 60) + 1)}, False),
    ("value", {"of": "level", "near": Fraction(9), "tolerance": Fraction(9, 10)}, False),
    ("equal", {"left": "copy", "right": "level"}, False),
    ("equal", {"left": "copy", "right": "level", "tolerance": 1}, True),
    ("equal", {"left": "lamp", "right": "lamp", "left-at": at(3), "right-at": at(4)}, False),
    ("order", {"edges": [("lamp", "rises"), ("late", "rises"), ("lamp", "falls")]}, True),
    ("order", {"edges": [("late", "rises"), ("lamp", "rises")]}, False),
    ("order", {"edges": [("late", "rises"), ("lamp", "rises")], "from": at(5)}, True),
    ("order", {"edges": [("lamp", "rises"), ("lamp", "changes")]}, None),
    ("happens", {"step": "go", "within": ms(9, 10)}, True),
    ("happens", {"step": "go", "from": at(0, "press"), "within": ms(0, 5)}, False),
    ("frames", {"signal": "count", "count": Limits(3, 3)}, True),
    ("frames", {"signal": "count", "cycle": ms(5, 11)}, False),
    ("frames", {"signal": "count", "cycle": ms(5, 12), "gap": 20 * MS}, True),
    ("frames", {"signal": "count", "gap": 19 * MS}, False),
    ("pulse", {"signal": "odd_", "width": ms(2, 2)}, True),
    ("pulse", {"signal": "odd_", "width": ms(2, 6), "which": "every"}, False),
    ("pulse", {"signal": "odd_", "width": ms(1, 6), "which": "every"}, True),
    ("pulse", {"signal": "odd_", "width": ms(None, 18), "from": at(17), "level": "low"}, False),
    ("pulse", {"signal": "odd_", "width": ms(10, None), "from": at(21), "level": "low"}, True),
    ("pulse", {"signal": "odd_", "width": ms(10, 30), "from": at(21), "level": "low"}, None),
    ("pulse", {"signal": "odd_", "width": ms(10, 30), "from": at(22), "level": "low"}, False),
    ("period", {"signal": "lamp", "is": ms(8, 8)}, True),
    ("period", {"signal": "odd_", "is": ms(6, 9)}, False),
    ("period", {"signal": "lamp", "is": ms(8, 8), "from": at(5), "until": at(20)}, False),
    ("period", {"signal": "lamp", "is": ms(4, 4), "edge": "changes"}, True),
    ("period", {"signal": "odd_", "is": ms(6, 6), "pulses-longer-than": MS}, True),
    ("frequency", {"signal": "lamp", "is": Limits(125, 125)}, True),
    ("frequency", {"signal": "odd_", "is": Limits(126, None)}, False),
    ("duty", {"signal": "lamp", "is": Limits(50, 50)}, True),
    ("duty", {"signal": "odd_", "is": Limits(51, 60)}, False),
    ("duty", {"signal": "odd_", "edge": "falls", "is": Limits(Fraction(700, 15), Fraction(700, 15))}, True),
    ("jitter", {"signal": "lamp", "is": ms(None, 0)}, True),
    # Rises at 4, 10, 20: from a grid of 8 ms they are off by 0, 2 and 0.
    ("jitter", {"signal": "odd_", "is": ms(2, 2)}, True),
    ("jitter", {"signal": "odd_", "grid": Fraction(8 * MS), "is": ms(2, 2)}, True),
    ("jitter", {"signal": "odd_", "grid": Fraction(6 * MS), "is": ms(4, 4)}, True),
    ("jitter", {"signal": "odd_", "compares": "periods", "is": ms(4, 4)}, True),
    ("jitter", {"signal": "odd_", "compares": "periods", "take": "rms", "is": ms(2, 2)}, True),
    ("jitter", {"signal": "lamp", "until": at(13), "is": ms(0, 100)}, False),
    ("speed", {"signal": "count", "from": at(4), "until": at(24), "is": Limits(100, 100)}, True),
    ("speed", {"signal": "level", "from": at(11), "until": at(13), "is": Limits(None, -1501)}, False),
    ("speed", {"signal": "level", "from": at(5), "until": at(13), "is": Limits(0, 0)}, None),
    ("phase", {"of": "late", "reference": "lamp", "is": Limits(45, 45)}, True),
    ("phase", {"of": "lamp", "reference": "late", "is": Limits(-50, -40), "until": at(20)}, True),
    ("phase", {"of": "lamp", "reference": "late", "is": Limits(-50, -40), "from": at(5), "until": at(20)}, None),
    ("phase", {"of": "b___", "reference": "a___", "is": Limits(80, 89)}, False),
    ("phase", {"of": "down", "reference": "a___", "is": Limits(80, 89)}, False),
    ("position", {"signal": "up__", "is": Limits(4, 4)}, True),
    ("position", {"signal": "up__", "down": "down", "is": Limits(2, 2)}, True),
    ("position", {"signal": "up__", "direction": "way_", "is": Limits(2, 2)}, True),
    ("position", {"signal": "up__", "direction": "way_", "inverted": True, "is": Limits(-2, -2)}, True),
    ("position", {"signal": "a___", "quadrature": "b___", "is": Limits(12, 12)}, True),
    ("position", {"signal": "b___", "quadrature": "a___", "is": Limits(12, 12)}, False),
    ("position", {"signal": "count", "number": True, "from": at(4), "is": Limits(2, 2)}, True),
    ("profile", {"signal": "lamp", "points": [(0, Fraction(125))], "tolerance": Fraction(1), "from": at(0, "press"), "until": at(28)}, None),
    ("profile", {"signal": "lamp", "points": [(0, Fraction(100))], "tolerance": Fraction(20)}, False),
    ("profile", {"signal": "lamp", "points": [(0, Fraction(125))], "tolerance": Fraction(1)}, False),
    ("profile", {"signal": "lamp", "points": [(0, Fraction(125))], "tolerance": Fraction(100), "from": at(1), "until": at(23)}, None),
    # From 125 Hz to 250 Hz in 8 ms it goes by one and a half.
    ("profile", {"signal": "lamp", "points": [(0, Fraction(125)), (8 * MS, Fraction(250))], "tolerance": Fraction(62),
                 "from": at(0, "press")}, False),
    ("profile", {"signal": "lamp", "points": [(0, Fraction(100))], "tolerance": Fraction(20), "shape-within": 2 * MS}, False),
    ("profile", {"signal": "lamp", "points": [(0, Fraction(100))], "tolerance": Fraction(20), "shape-within": 9 * MS}, None),
]
# A measurement, and what it comes to.
FIGURES = [
    ("time", {"signal": "lamp", "edge": "rises", "from": at(5)}, 7 * MS),
    ("time", {"signal": "lamp", "edge": "rises", "from": at(21)}, MISSING),
    ("time", {"to": at(0, "go"), "from": at(0, "press")}, 5_500_000),
    ("value", {"signal": "count", "when": at(8)}, (1 << 60) + 1),
    ("window", {"signal": "level", "take": "max"}, 14),
    ("window", {"signal": "level", "take": "min", "from": at(12)}, 10),
    ("window", {"signal": "count", "take": "span", "from": at(3)}, 2),
    ("window", {"signal": "lamp", "take": "mean", "until": at(32)}, Fraction(3, 8)),
    ("window", {"signal": "level", "take": "mean", "from": at(10), "until": at(14)}, Fraction(25, 2)),
    ("frequency", {"signal": "odd_"}, 125),
    ("duty", {"signal": "odd_"}, 50),
    ("duty", {"signal": "odd_", "until": at(10)}, MISSING),
    ("period", {"signal": "odd_", "take": "span"}, 4 * MS),
    ("period", {"signal": "odd_"}, 8 * MS),
    ("width", {"signal": "odd_", "take": "mean"}, 3 * MS),
    ("width", {"signal": "odd_", "take": "max", "level": "low", "from": at(4)}, 4 * MS),
    ("speed", {"signal": "count", "from": at(4), "until": at(24)}, 100),
    ("jitter", {"signal": "odd_", "grid": Fraction(6 * MS)}, 4 * MS),
    ("position", {"signal": "up__"}, 4),
    ("profile", {"signal": "up__", "points": [(0, Fraction(260))]}, 10),
]
def check(what, found, wanted):
    if found != wanted:
        sys.exit(f"selftest: {what}: {found}, and not {wanted}")


def recordings():
    """Placements keep to what a recording says, and what may be is found."""
    rng = random.Random(1)
    track = [Change(-MS, -MS, 1, False), Change(2 * MS, 6 * MS, 5, True), Change(4 * MS, 5 * MS, 6, False)]
    recording = Recording({"lamp": track}, STEPS)
    widths = set()
    for placement in recording.placements(rng, ["lamp"], ["start"], [4 * MS], 200):
        rise, fall = (time for time, _ in placement.tracks["lamp"].at[1:])
        assert 2 * MS <= rise < fall <= 5 * MS, (rise, fall)
        widths.add(fall - rise)
    check("the widest pulse", max(widths), 3 * MS)
    check("the narrowest pulse", min(widths), 1)
    claim = Claim("expect", "pulse", {"signal": "lamp", "width": ms(0, 2)}, {}, ["lamp"])
    found = compare.expected(claim, recording, rng, 60)
    check("a width that is left open", found.answers, {True, False})
    check("its pass", [kind for kind, _ in compare.differences(claim, Answer("pass"), found)], ["pass, may be broken"])
    check("its failure", [kind for kind, _ in compare.differences(claim, Answer("fail"), found)], ["fail, may hold"])
    check("its being open", compare.differences(claim, Answer("inconclusive"), found), [])
    # Pulses of 1 ms to 5 ms and periods of 6 ms to 10 ms: no end of an interval makes exactly a third.
    train = [Change(-MS, -MS, 1, False)]
    for time in range(4, 36, 8):
        train += [Change(time * MS, (time + 2) * MS, 5, True), Change((time + 3) * MS, (time + 5) * MS, 6, False)]
    third = Fraction(100, 3)
    claim = Claim("expect", "duty", {"signal": "lamp", "is": Limits(third - Fraction(1, 10 ** 5), third + Fraction(1, 10 ** 5))}, {}, ["lamp"])
    found = compare.expected(claim, Recording({"lamp": train}, STEPS), rng, 60)
    check("a figure between two", found.answers, {True, False})
    steady = Recording({"lamp": [Change(-MS, -MS, 1, False)]}, STEPS, samples=[time * MS for time in range(41)],
                       pool={"lamp": [False, True]})
    for keys, kinds in (({}, ["pass, unseen"]), ({"pulses-longer-than": MS}, [])):
        claim = Claim("expect", "stays", {"signal": "lamp", "wanted": only(False), **keys}, {}, ["lamp"])
        found = compare.expected(claim, steady, rng, 60)
        check("what samples do not show", [kind for kind, _ in compare.differences(claim, Answer("pass"), found)], kinds)
    gone = Recording({"lamp": [Change(-MS, -MS, 1, False), Change(9 * MS, 9 * MS, 2, None), Change(12 * MS, 12 * MS, 3, False)]},
                     STEPS, pool={"lamp": [False, True]})
    claim = Claim("expect", "stays", {"signal": "lamp", "wanted": only(False)}, {}, ["lamp"])
    check("what is not known", compare.expected(claim, gone, rng, 60).answers, {True, False})
    claim = Claim("expect", "rises", {"signal": "lamp", "from": at(0, "nothing")}, {}, ["lamp"])
    found = compare.expected(claim, gone, rng, 60)
    check("an instant that never came", [kind for kind, _ in compare.differences(claim, Answer("fail"), found)],
          ["fail without its instant"])
    claim = Claim("measure", "value", {"signal": "count", "limits": Limits(None, 1 << 60)}, {}, ["count"])
    exact = Recording({"count": [Change(0, 0, 1, Fraction((1 << 60) + 1))]}, STEPS)
    found = compare.expected(claim, exact, rng, 1)
    answer = Answer("pass", value=[Fraction(1 << 60)] * 2, margin=Fraction(0))
    check("a rounded number", [kind for kind, _ in compare.differences(claim, answer, found)],
          ["pass, may be broken", "figure", "margin"])


def main():
    for verb, keys, wanted in CLAIMS:
        check(f"{verb} {keys}", VERBS[verb](keys, PLACEMENT), wanted)
    for verb, keys, wanted in FIGURES:
        figure = MEASURES[verb](keys, PLACEMENT)
        check(f"{verb} {keys}", figure.least if isinstance(figure, trains.AtLeast) else figure, wanted)
    check("verbs without a verdict by hand", set(VERBS) - {verb for verb, _, _ in CLAIMS}, set())
    check("measurements without a figure by hand", set(MEASURES) - {verb for verb, _, _ in FIGURES}, set())
    root = trains.Rooted(Fraction(2))
    check("a root", (root >= Fraction(14, 10), root >= Fraction(15, 10), root <= Fraction(15, 10), root >= -1), (True, False, True, True))
    check("a decimal", (text(Fraction(-7, 20)), text(Fraction(3)), duration(1_500_000), duration(7)),
          ("-0.35", "3", "1500 us", "0.000007 ms"))
    try:
        PLACEMENT.at(at(0, "nothing"))
        sys.exit("selftest: a step that never came has no instant")
    except NeverCame:
        pass
    recordings()
    print(f"selftest: {len(CLAIMS)} claims and {len(FIGURES)} measurements of {len(VERBS)} verbs and {len(MEASURES)} kinds")


if __name__ == "__main__":
    main()
