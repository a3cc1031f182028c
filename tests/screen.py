"""The screen of a terminal as a picture: text with its colours in, SVG out.

Letters stand on a grid, each run of them stretched to its columns, so that the viewer's fonts do not matter. Braille and
blocks are drawn as what they are, since few fonts have them in one width.
"""

import html
import re

WIDTH, HEIGHT = 8.4, 18
PAPER, INK = "#14171c", "#d4d7dd"
COLORS = ["#3b4048", "#e5686f", "#8cc570", "#d9b668", "#65a5ee", "#c07ddb", "#53b5c0", "#d4d7dd"]
BRIGHT = ["#7a828e", "#ff7a82", "#a3e085", "#f0cd7c", "#7cbcff", "#d893f5", "#68ccd8", "#ffffff"]


class Style:
    def __init__(self):
        self.reset()

    def reset(self):
        self.ink, self.paper, self.bold, self.turned = None, None, False, False

    def take(self, codes):
        codes = [int(code or 0) for code in codes.split(";")]
        while codes:
            code = codes.pop(0)
            if code == 0:
                self.reset()
            elif code == 1:
                self.bold = True
            elif code == 22:
                self.bold = False
            elif code in (7, 27):
                self.turned = code == 7
            elif 30 <= code <= 37:
                self.ink = COLORS[code - 30]
            elif 90 <= code <= 97:
                self.ink = BRIGHT[code - 90]
            elif 40 <= code <= 47:
                self.paper = COLORS[code - 40]
            elif 100 <= code <= 107:
                self.paper = BRIGHT[code - 100]
            elif code in (38, 48) and codes[:1] == [5]:
                number = codes[1]
                color = (COLORS + BRIGHT)[number] if number < 16 else INK
                if code == 38:
                    self.ink = color
                else:
                    self.paper = color
                codes = codes[2:]
            elif code == 39:
                self.ink = None
            elif code == 49:
                self.paper = None

    def seen(self):
        ink, paper = self.ink or INK, self.paper or PAPER
        return (paper, ink, self.bold) if self.turned else (ink, paper, self.bold)


def cells(painted):
    """Rows of (letter, (ink, paper, bold))."""
    style, rows = Style(), []
    for line in painted.splitlines():
        row = []
        for codes, letter in re.findall(r"\x1b\[([\d;]*)m|([^\x1b])", line):
            if letter:
                row.append((letter, style.seen()))
            else:
                style.take(codes)
        rows.append(row)
    return rows


def shapes(letter):
    """What is drawn in place of a letter: rectangles as parts of the cell, or none."""
    code = ord(letter)
    if 0x2801 <= code <= 0x28FF:
        places = [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (0, 3), (1, 3)]
        return [(0.12 + x * 0.5, 0.04 + y * 0.25, 0.28, 0.17) for bit, (x, y) in enumerate(places) if (code - 0x2800) >> bit & 1]
    eighths = "▏▎▍▌▋▊▉█"
    if letter in eighths:
        return [(0, 0, (eighths.index(letter) + 1) / 8, 1)]
    return {
        "▀": [(0, 0.1, 1, 0.4)], "▁": [(0, 0.86, 1, 0.08)], "─": [(0, 0.47, 1, 0.06)], "━": [(0, 0.45, 1, 0.1)],
        "│": [(0.45, 0, 0.12, 1)], "┃": [(0.38, 0, 0.24, 1)], "═": [(0, 0.38, 1, 0.06), (0, 0.56, 1, 0.06)],
        "┌": [(0.45, 0.47, 0.55, 0.06), (0.45, 0.5, 0.12, 0.5)], "┐": [(0, 0.47, 0.55, 0.06), (0.45, 0.5, 0.12, 0.5)],
        "└": [(0.45, 0.47, 0.55, 0.06), (0.45, 0, 0.12, 0.5)], "┘": [(0, 0.47, 0.55, 0.06), (0.45, 0, 0.12, 0.5)],
        "┴": [(0, 0.47, 1, 0.06), (0.45, 0, 0.12, 0.5)],
        "┊": [(0.45, y / 4 + 0.04, 0.1, 0.15) for y in range(4)], "╌": [(0.05, 0.47, 0.38, 0.06), (0.57, 0.47, 0.38, 0.06)],
    }.get(letter)


def svg(painted):
    """The picture."""
    rows = cells(painted)
    columns = max(len(row) for row in rows)
    size = (columns * WIDTH + 16, len(rows) * HEIGHT + 16)
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]:g} {size[1]:g}" width="{size[0]:g}" '
        f'font-family="DejaVu Sans Mono, Menlo, Consolas, monospace" font-size="14">',
        f'<rect width="100%" height="100%" rx="6" fill="{PAPER}"/>',
    ]
    for y, row in enumerate(rows):
        top = 8 + y * HEIGHT
        for begin, end, (ink, paper, bold) in runs(row):
            left, letters = 8 + begin * WIDTH, "".join(letter for letter, _ in row[begin:end])
            if paper != PAPER:
                width = (end - begin) * WIDTH
                out.append(f'<rect x="{left:g}" y="{top}" width="{width:g}" height="{HEIGHT}" fill="{paper}"/>')
            path = "".join(
                f"M{left + (x + a) * WIDTH:.1f} {top + b * HEIGHT:.1f}h{w * WIDTH:.1f}v{h * HEIGHT:.1f}h{-w * WIDTH:.1f}z"
                for x, letter in enumerate(letters) for a, b, w, h in shapes(letter) or [])
            if path:
                out.append(f'<path fill="{ink}" d="{path}"/>')
            for word in re.finditer(r"\S+", "".join(" " if shapes(letter) else letter for letter in letters)):
                weight = ' font-weight="bold"' if bold else ""
                x, length = left + word.start() * WIDTH, len(word.group()) * WIDTH
                out.append(f'<text x="{x:g}" y="{top + 13.5:g}" textLength="{length:g}" fill="{ink}"{weight}>'
                           f"{html.escape(word.group())}</text>")
    return "\n".join([*out, "</svg>"]) + "\n"


def runs(row):
    """Pieces of a row in one style: from, to, style."""
    begin = 0
    for place in range(1, len(row) + 1):
        if place == len(row) or row[place][1] != row[begin][1]:
            yield begin, place, row[begin][1]
            begin = place
