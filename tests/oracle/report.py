"""What was compared, and what was contradicted: classes with the smallest example of each."""

import collections
from fractions import Fraction

from compare import Expected, differences
from figures import Limits
from recording import HELD_BACK, UNSEEN_RANK
from rig import Answer


class Report:
    """Counts what is compared; `wanted` are the verbs that have to be tried."""

    def __init__(self, keep, wanted):
        self.keep_in, self.wanted = keep, wanted
        self.counted = collections.Counter()
        self.ways = collections.Counter()
        self.figures = collections.Counter()
        self.unsaid = collections.Counter()
        self.weak = collections.Counter()
        self.left_out = collections.Counter()
        self.classes = {}

    def compared(self):
        return sum(self.counted.values())

    def compare(self, way, claim, answer, found, origin):
        verb = (claim.group, claim.verb)
        self.counted[verb + (answer.verdict,)] += 1
        self.ways[way] += 1
        if claim.group == "measure" and answer.value and found.figures:
            self.figures[claim.verb] += 1
        if found.answers == {None}:
            self.unsaid[verb] += 1
        for kind, words in differences(claim, answer, found):
            if kind == "weak":
                self.weak[(way,) + verb] += 1
            else:
                self.add(self.cause(way, claim, kind, found, origin), words, answer, origin, found)

    def cause(self, way, claim, kind, found, origin):
        """What a contradiction is counted under: what it seems to come of, or its verb."""
        limits = [claim.keys.get(key) for key in ("is", "limits", "tolerance", "near")]
        numbers = [limit for limit in limits if isinstance(limit, (int, Fraction))]
        numbers += [end for limit in limits if isinstance(limit, Limits) for end in (limit.low, limit.high) if end is not None]
        for placement in found.examples.values():
            numbers += [value for name in claim.names for value in placement.tracks[name].values
                        if isinstance(value, Fraction)]
        if any(rank >= HELD_BACK for placement in found.examples.values() for name in claim.names
               for _, rank in placement.tracks[name].at if rank < UNSEEN_RANK):
            return ("", "a change before the end that becomes known after it", claim.group, kind)
        bases = {value[0] for value in claim.keys.values() if isinstance(value, tuple)} | {claim.keys.get("step")}
        if way in ("sampled", "stamped") and any(step in bases for step, *_ in origin.scene.awaited):
            return ("", "a step that waits, in a capture", "", kind)
        delay = claim.keys.get("within") or (claim.keys.get("is") if claim.verb == "period" else None)
        if kind == "margin" and delay and delay.low in (None, 0):
            return ("", "an at-most limit", "", kind)
        if any(abs(number) > 1 << 53 for number in numbers):
            return ("", "numbers beyond 53 bits", "", kind)
        if kind in ("fail, may hold", "pass, may be broken") and 0 in found.margins:
            return ("", "a limit that is just met", claim.verb, kind)
        if "pulses-longer-than" in claim.keys and way not in ("sampled",):
            return ("", "pulses-longer-than", claim.verb, kind)
        return (way, claim.group, claim.verb, kind)

    def add(self, key, words, answer, origin, found):
        """One more of a class; of all of them the smallest is kept."""
        old = self.classes.get(key)
        count = old["count"] + 1 if old else 1
        if old is None or origin.size() < old["origin"].size():
            self.classes[key] = {"words": words, "answer": answer, "origin": origin, "found": found}
        self.classes[key]["count"] = count

    def broken(self, way, kind, words, origin):
        """Something about a whole case."""
        self.add((way, "case", "", kind), words, Answer("error", words), origin, Expected())

    def refused(self, claim, code, message, origin):
        """A claim that the check refuses. None is drawn that no value can meet, or that every run keeps but for its instants."""
        self.left_out[code] += 1
        if code not in ("P0503", "P0622"):
            self.add(("", "the check refuses what can be", "", code), message, Answer("error", message), origin, Expected())

    def failed(self):
        return bool(self.classes) or bool(self.never_tried())

    def never_tried(self):
        tried = {key[:2] for key in self.counted}
        return [f"{group} {verb}" for group, verb in self.wanted if (group, verb) not in tried]

    def show_class(self, key, entry, folder):
        way, group, verb, kind = key
        answer, origin = entry["answer"], entry["origin"]
        print(f"\nCONTRADICTION {words_of(way, group, verb)}: {kind}; {entry['count']} times. The smallest:")
        print(f"  {origin.text()}")
        print(f"  rig: {answer.verdict} {answer.reason} {answer.text}")
        print(f"  oracle: {entry['words']}")
        example = entry["found"].examples.get({"pass": False, "fail": True}.get(answer.verdict))
        if example is not None:
            start = example.steps["start"][0]
            for name, track in example.tracks.items():
                changes = list(zip(track.at, track.values))[:24]
                print(f"    {name}: " + ", ".join(f"{(at[0] - start) / 1e6:g} ms {value}" for at, value in changes))
            print("    steps: " + ", ".join(f"{name} {(at[0] - start) / 1e6:g} ms" for name, at in example.steps.items()
                                          if len(name) < 6))
        print(f"  again: {origin.keep(folder)}")

    def show(self):
        for number, (key, entry) in enumerate(sorted(self.classes.items(), key=lambda item: -item[1]["count"])):
            self.show_class(key, entry, self.keep_in / f"{words_of(*key[:3])} {number}".replace(" ", "-").replace(",", ""))
        print(f"\noracle: {self.compared()} compared: " + ", ".join(f"{way} {count}" for way, count in sorted(self.ways.items())))
        verdicts = ("pass", "fail", "inconclusive", "none")
        for group, verb in self.wanted:
            counts = [self.counted[(group, verb, verdict)] for verdict in verdicts]
            more = f", {self.figures[verb]} figures" if group == "measure" else ""
            unsaid = self.unsaid[(group, verb)]
            weak = sum(count for key, count in self.weak.items() if key[1:] == (group, verb))
            print(f"  coverage {group:7} {verb:9} " + " ".join(f"{verdict} {count}" for verdict, count in zip(verdicts, counts))
                  + more + (f", unsaid {unsaid}" if unsaid else "") + (f", weak {weak}" if weak else ""))
        print(f"oracle: left out by the check: {dict(self.left_out)}")
        print(f"oracle: {len(self.classes)} classes of contradictions, {sum(self.weak.values())} weak verdicts")
        for verb in self.never_tried():
            print(f"oracle: {verb} was never tried")


def words_of(*parts):
    return " ".join(part for part in parts if part)
