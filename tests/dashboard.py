#!/usr/bin/env python3
"""A session of the dashboard in a real terminal: tests/dashboard.py RIG [PICTURE].

RIG is the command. tmux is the terminal: keys go in, the text of its screen is looked at. The rig is the demonstration
that `rig dash --board sim` starts. A force, a trend with a trigger, a recording that another program reads, a file that
is looked at, leaving; then what a terminal gets that has no colours and nothing but ASCII, and one that goes away.

With PICTURE the screen of the trend is written there as SVG: the picture in the README.

Prints what failed, then `N passed, M failed`; the exit code is 0 only without failures.
"""

import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import time

from vcdvcd import VCDVCD

import screen
from tally import check, finish

SECONDS = 60


class Terminal:
    """A terminal of tmux, with a shell command in it."""

    def __init__(self, folder, command, width=80, height=24, term="tmux-256color"):
        self.server = ["tmux", "-S", str(folder / "tmux"), "-f", "/dev/null"]
        self.run("new-session", "-d", "-x", str(width), "-y", str(height), "-s", "rig", "-c", str(folder),
                 f"export LANG=C.UTF-8 LC_ALL=C.UTF-8 TERM={term}; unset NO_COLOR; {command}")

    def run(self, *arguments, wrong=True):
        ran = subprocess.run([*self.server, *arguments], capture_output=True, text=True, timeout=SECONDS)
        if wrong and ran.returncode != 0:
            sys.exit(f"tmux {arguments}: {ran.stderr}")
        return ran.stdout

    def text(self):
        return self.run("capture-pane", "-p", wrong=False)

    def painted(self):
        """The screen with its colours, as terminals are told them."""
        return self.run("capture-pane", "-e", "-N", "-p")

    def wait(self, what, wanted):
        """Waits until the screen has a text, or what a function wants of it."""
        fits = wanted if callable(wanted) else lambda text: wanted in text
        until = time.monotonic() + SECONDS
        while time.monotonic() < until:
            text = self.text()
            if fits(text):
                check(what, True)
                return text
            time.sleep(0.05)
        # Nothing after it would mean anything.
        check(what, False, f"not so on the screen:\n{text}")
        finish()

    def keys(self, *names):
        self.run("send-keys", "-t", "rig", *names)

    def type(self, text):
        self.run("send-keys", "-t", "rig", "-l", "--", text)

    def end(self):
        self.run("kill-server", wrong=False)


def choose(terminal, name):
    """Takes a signal into the trend."""
    terminal.type("i")
    terminal.wait("the list of signals opens", "type to find")
    terminal.type(name)
    terminal.wait(f"{name} is found", lambda text: re.search(rf"\[ \] \S*{re.escape(name)}", text))
    terminal.keys("Enter")
    terminal.wait(f"{name} is taken", lambda text: re.search(rf"\[x\] \S*{re.escape(name)}", text))
    terminal.keys("Escape")
    terminal.wait("the list closes", lambda text: "type to find" not in text)


def session(rig, folder, picture):
    command = f"{shlex.quote(rig)} dash --board sim; echo ended with $?; stty -a; exec cat"
    terminal = Terminal(folder, command, 110, 34)
    try:
        terminal.wait("a controller runs", "RUNNING")
        terminal.wait("its points are shown", "%QX0.6")

        terminal.type("/")
        terminal.wait("the filter is asked for", "Rows with")
        terminal.type("Q6")
        terminal.keys("Enter")
        terminal.wait("the filter holds", lambda text: "%QX0.6" in text and "%IX0.0" not in text)
        terminal.type("f")
        terminal.wait("a value is asked for", "Force %QX0.6 to:")
        terminal.keys("C-u")
        terminal.type("TRUE")
        terminal.keys("Enter")
        terminal.wait("the banner says what is forced", "FORCED 1: %QX0.6=TRUE")

        terminal.type("2")
        terminal.wait("the trend is empty", "No signals yet")
        for name in ["temperature", "BELT.position", "pusher-out"]:
            choose(terminal, name)
        # Half of a window, so that a trigger has something before it.
        terminal.wait("curves grow", lambda text: len(re.findall("[\u2801-\u28ff]", text)) > 150)
        terminal.keys("Down", "Down")
        terminal.type("t")
        terminal.wait("the trigger is set", "Before")
        terminal.keys("Right", "Right", "Right", "Enter")
        terminal.wait("it waits, or it came", lambda text: "trigger single" in text)
        terminal.wait("it came, and its window is whole", "done: pusher-out rises")
        # From the contact's first edge to the last one of its bouncing, and to when it lets go.
        terminal.type("aEebeeeeee")
        terminal.wait("the cursors measure", lambda text: re.search(r"B-A [1-9][\d.]* (ms|us|s)", text))
        if picture:
            pathlib.Path(picture).write_text(screen.svg(terminal.painted()), encoding="utf-8")
        terminal.keys("Escape")

        for name in ["trend.vcd", "trend.csv"]:
            terminal.type("s")
            terminal.wait("a name is asked for", "Save as")
            terminal.keys("C-u")
            terminal.type(name)
            terminal.keys("Enter")
            terminal.wait(f"{name} is written", "changes of 3 signals")
        dump = VCDVCD(str(folder / "trend.vcd"))
        contact = dump["rig.pusher-out"].tv
        check("the contact of the recording moves", len({value for _, value in contact}) > 1, str(contact))
        temperatures = [float(value) for _, value in dump["rig.temperature"].tv]
        check("the oven is no colder than the room", temperatures and min(temperatures) >= 19, str(temperatures))
        rows = (folder / "trend.csv").read_text().splitlines()
        check("the table names its columns", rows[0] == "time [ns],temperature [degC],BELT.position,pusher-out", rows[0])
        check("the table has rows in their order", all(int(a.split(",")[0]) < int(b.split(",")[0])
                                                     for a, b in zip(rows[1:], rows[2:])))

        terminal.type("s")
        terminal.wait("a name is asked for", "Save as")
        terminal.keys("C-u")
        terminal.type("trend.vcd")
        terminal.keys("Enter")
        terminal.wait("a file is not written over", "R0681")
        terminal.type("o")
        terminal.wait("a file is asked for", "Look at file")
        terminal.type("trend.vcd")
        terminal.keys("Enter")
        terminal.wait("the file is shown", lambda text: "FILE" in text and "BELT.position" in text)
        terminal.type("c")

        for key, shown in [("3", "Watchdog"), ("4", "HSC0"), ("5", "Received"), ("6", "RUNNING"), ("7", "lans")]:
            terminal.type(key)
            terminal.wait(f"view {key} is shown", shown)

        terminal.type("q")
        terminal.wait("leaving is asked about", "eave")
        terminal.keys("Escape")
        terminal.wait("one can stay", lambda text: "eave and" not in text)
        terminal.type("q")
        terminal.wait("leaving is asked about again", "eave and")
        terminal.type("l")
        text = terminal.wait("it ends", "ended with 0")
        settings = terminal.wait("the terminal says how it is", "min = ")
        check("the terminal is as it was", re.search(r"(?<!-)\becho\b", settings) and re.search(r"(?<!-)\bicanon\b", settings),
              settings)
        check("the screen is given back", "Trend" not in text, text)
    finally:
        terminal.end()


def plain(rig, folder):
    """A serial console: no colours, no characters but those of ASCII, 80 x 24."""
    terminal = Terminal(folder, f"{shlex.quote(rig)} dash --board sim; exec cat", 80, 24, term="vt100")
    try:
        text = terminal.wait("it starts on a console", "RUNNING")
        for key in "1234567":
            terminal.type(key)
            text = terminal.wait(f"view {key} is there", lambda text: "leave" in text)
            check(f"view {key} has only ASCII", text.isascii(), text)
        colors = set(re.findall(r"\x1b\[[\d;]*?(3[0-7]|4[0-7]|[34]8;)[\d;]*m", terminal.painted()))
        check("no colours", not colors, str(colors))
    finally:
        terminal.end()


def hang_up(rig, folder):
    """A terminal that goes away ends the dashboard, and the rig that was started for it."""
    terminal = Terminal(folder, f"exec {shlex.quote(rig)} dash --board sim")
    terminal.wait("it starts again", "RUNNING")
    shell = int(terminal.run("list-panes", "-F", "#{pane_pid}").split()[0])
    children = [int(pid) for pid in pathlib.Path(f"/proc/{shell}/task/{shell}/children").read_text().split()]
    check("it has a rig of its own", len(children) == 1, str(children))
    terminal.end()
    until = time.monotonic() + SECONDS
    left = [shell, *children]
    while left and time.monotonic() < until:
        left = [pid for pid in left if alive(pid)]
        time.sleep(0.05)
    check("both end with their terminal", not left, str(left))


def alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] not in "ZX"
    except OSError:
        return False


def main():
    rig = os.path.abspath(sys.argv[1])
    picture = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else None
    for part in [lambda folder: session(rig, folder, picture), lambda folder: plain(rig, folder),
                 lambda folder: hang_up(rig, folder)]:
        with tempfile.TemporaryDirectory() as folder:
            part(pathlib.Path(folder))
    finish()


if __name__ == "__main__":
    main()
