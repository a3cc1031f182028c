// The timing diagram as an instrument: it draws a stretch of a case, zooms and pans.
const MARGIN = 14; // right of the lanes, in pixels
const SCALE = 62; // width of an analog lane's scale
const VALUES = 92; // width of the column of values at a cursor
const NARROWEST = 320; // below this width the diagram scrolls sideways in place of shrinking
const COMPACT = 700; // below this width there is no column of values
const MOST_LANES = 24; // more are drawn on request; those that claims look at come first
const LEAST_VIEW = 20; // nanoseconds

class Scope {
  constructor(record, choose) {
    this.record = record;
    this.chooseClaim = choose;
    this.lanes = this.order(lanes(record));
    this.extent = extent(record);
    this.view = null; // [t0, t1] of a single stretch; without it the axis that the claims ask for
    this.chosen = null; // the claim that the axis is made for
    this.everything = false;
    this.plot = s("svg", { class: "diagram", "aria-hidden": "true" });
    this.map = s("svg", { class: "map", "aria-hidden": "true" });
    this.stage = h("div", { class: "stage", tabindex: 0, role: "application", "aria-roledescription": "timing diagram", "aria-label": `Timing diagram of ${record.name}` }, this.plot, this.map);
    this.cursors = new Cursors(this);
    this.description = h("p", { class: "unseen", id: `described-${record.place}` }, this.described());
    this.stage.setAttribute("aria-describedby", this.description.id);
    this.element = h("div", { class: "scope" }, this.tools(), h("div", { class: "scroll" }, this.stage), this.cursors.reading, this.description);
    handle(this);
    // Drawn at once, as on paper a hidden part is never measured; and again when the width is known.
    this.width = 1160;
    this.draw();
    new ResizeObserver(([entry]) => this.resize(entry.contentRect.width)).observe(this.element);
  }

  // The lanes in the order of the record; those with claims first where there are too many to draw.
  order(list) {
    if (list.length <= MOST_LANES) return list;
    const claimed = new Set(this.record.claims.map((claim) => claim.signal));
    return [...list.filter((lane) => claimed.has(lane.signal)), ...list.filter((lane) => !claimed.has(lane.signal))];
  }

  get drawn() {
    return this.everything ? this.lanes : this.lanes.slice(0, MOST_LANES);
  }

  tools() {
    const more = this.lanes.length - MOST_LANES;
    return h(
      "div",
      { class: "tools", role: "toolbar", "aria-label": "Diagram" },
      h("span", { class: "set" }, button("Zoom out", "−", () => this.zoom(2)), button("Zoom in", "+", () => this.zoom(0.5)), button("Earlier", "◀", () => this.pan(-0.5)), button("Later", "▶", () => this.pan(0.5))),
      h("span", { class: "set" }, button("Claims", "Claims", () => this.fit()), button("Whole case", "Whole case", () => this.whole())),
      this.cursors.tools(),
      more > 0 && button(`${more} more signals`, `${more} more signals`, (event) => {
        this.everything = true;
        event.target.remove();
        this.draw();
      }),
    );
  }

  resize(width) {
    const wanted = Math.max(Math.round(width), NARROWEST);
    if (width > 0 && wanted !== this.width) {
      this.width = wanted;
      this.draw();
    }
  }

  // Draws soon, once for many changes.
  later() {
    this.pending ??= requestAnimationFrame(() => this.draw());
  }

  // What the claims speak of; of one claim alone where one is given.
  fit(claim = null) {
    [this.view, this.chosen] = [null, claim];
    this.draw();
  }

  whole() {
    this.show(...this.extent);
  }

  show(t0, t1) {
    const [low, high] = this.extent;
    const width = Math.min(Math.max(t1 - t0, LEAST_VIEW), high - low);
    const from = Math.round(Math.min(Math.max(t0, low), high - width));
    this.view = [from, from + Math.round(width)];
    // At once, because the next event may count on it; the drawing follows.
    this.axis = Axis.linear(...this.view, this.left, this.right);
    this.later();
  }

  // Makes a pixel worth `factor` times as many nanoseconds; what is at `x` stays there.
  zoom(factor, x = this.cursors.focus() ?? (this.left + this.right) / 2) {
    const [t, scale] = [this.axis.t(x), this.axis.scale(x) * factor];
    const t0 = t - (x - this.left) * scale;
    this.show(t0, t0 + (this.right - this.left) * scale);
  }

  // Moves by a part of what is seen.
  pan(part) {
    this.move((this.right - this.left) * part);
  }

  // Moves by pixels.
  move(pixels) {
    const middle = (this.left + this.right) / 2;
    const [t, scale] = [this.axis.t(middle), this.axis.scale(middle)];
    const half = ((this.right - this.left) * scale) / 2;
    this.show(t + pixels * scale - half, t + pixels * scale + half);
  }

  get compact() {
    return this.width < COMPACT;
  }

  // Room for the names and values to the left of the lanes, and for the scale of an analog lane.
  gutter() {
    const room = (lane) => textWidth(lane.signal) * 1.1 + (lane.kind === "analog" ? SCALE : 0);
    const names = Math.max(...this.drawn.map(room), 90);
    return this.compact ? Math.min(names, 100) + 8 : Math.min(names, this.width < 1000 ? 160 : 230) + VALUES;
  }

  draw() {
    if (this.pending) cancelAnimationFrame(this.pending);
    this.pending = null;
    const record = this.record;
    [this.left, this.right] = [this.gutter(), this.width - MARGIN];
    this.axis = this.view ? Axis.linear(...this.view, this.left, this.right) : claimsAxis(record, this.chosen, this.left, this.right);
    const axis = this.axis;
    const stepRows = new Rows();
    const steps = stepFlags(record, axis, stepRows);
    const decidingTop = 2 + 16 * Math.max(stepRows.ends.length, 1);
    const decidingRows = new Rows();
    const deciding = decidingFlags(record, axis, decidingRows, this.chosen);
    this.cursorTop = decidingTop + 18 * decidingRows.ends.length;
    this.top = this.cursorTop + 18;
    const [ground, body, over] = [[], [], []];
    let y = this.top;
    this.rows = this.drawn.map((lane) => {
      const row = this.lane(axis, lane, y, body, over);
      y = row.bottom + 4;
      return row;
    });
    this.bottom = y;
    for (const piece of axis.pieces) {
      for (const tick of ticks(piece, record.start_ns)) {
        ground.push(line("grid", tick.x, this.top, tick.x, y));
        const half = textWidth(tick.label) / 2;
        // A label that would run into a break or out of the picture is left out; its line stays.
        if (tick.x + half <= piece.x1 + MARGIN && tick.x - half >= piece.x0 - MARGIN) ground.push(label("small mid", tick.x, y + 15, tick.label));
      }
      ground.push(line("axis", piece.x0, y, piece.x1, y));
    }
    ground.push(label("small", 0, y + 15, "time from start"));
    over.push(...drawBreaks(axis, this.top, y), ...steps.flatMap((flag) => drawStep(flag, 2, y)));
    over.push(...deciding.flatMap((flag) => drawDeciding(axis, flag, decidingTop, this.top, y)));
    const below = y + (axis.pieces.length > 1 ? 34 : 22);
    const [sizes, used] = drawDimensions(dimensions(record, this.chosen), axis, below);
    const height = Math.ceil(below + used + 4);
    this.cursors.layer = s("g", { class: "cursors" });
    dress(this.plot, { viewBox: `0 0 ${this.width} ${height}`, width: this.width, height });
    this.plot.replaceChildren(...put(s("g"), [ground, body, over, sizes, this.cursors.layer]).childNodes);
    this.cursors.draw();
    this.drawMap();
  }

  // One lane from `y` down: numbers of its claims, then the signal.
  lane(axis, lane, y, body, over) {
    const claims = this.record.claims.map((claim, at) => ({ claim, n: at + 1 })).filter(({ claim }) => claim.signal === lane.signal);
    const rows = new Rows();
    const tags = claims
      .map(({ claim, n }) => ({ claim, n, x: tagPlace(axis, claim) }))
      .filter(({ x }) => x !== null)
      .sort((a, b) => a.x - b.x || a.n - b.n)
      .map((tag) => ({ ...tag, x: Math.min(tag.x, this.right - tagWidth(tag.n)), row: 0 }));
    for (const tag of tags) tag.row = rows.place(tag.x, tagWidth(tag.n) + 2, 3);
    const top = y + 4 + 16 * rows.ends.length;
    const height = HEIGHT[lane.kind];
    for (const { claim } of claims) body.push(...drawWindow(axis, claim, top, height));
    const band = claims
      .filter(({ claim }) => claim.bounds && claim.window)
      .map(({ claim }) => ({ min: claim.bounds.min, max: claim.bounds.max, from: claim.window.from_ns[0], until: claim.window.until_ns[1], word: claim.verdict }));
    body.push(...drawLane(axis, lane, top, band));
    for (const { claim, n, x, row } of tags) if (row >= 0) over.push(drawTag(n, claim, x, y + 3 + 16 * row, () => this.chooseClaim(claim)));
    for (const { claim } of claims) {
      const at = claim.deciding_ns && middle(claim.deciding_ns);
      if (given(at) && !bad(claim.verdict) && axis.shows(at)) over.push(s("circle", { class: `dot v-${claim.verdict}`, cx: px(axis.x(at)), cy: px(top + 11), r: 3.2 }));
    }
    // Beside the scale of an analog lane there is no room for the name in a narrow picture: it stands above.
    const base = this.compact && lane.kind === "analog" ? top - 1 : top + height / 2 + 4;
    const scale = lane.kind === "analog" ? SCALE : 0;
    const name = label("name", 0, base, fit(lane.signal, (this.left - (this.compact ? 8 : VALUES) - (this.compact ? 0 : scale)) / 1.1));
    name.append(s("title", {}, lane.signal));
    body.push(name);
    return { lane, name, valueX: this.left - 8 - scale, base, top, bottom: top + height };
  }

  // The whole case as a strip, with the stretches that are seen.
  drawMap() {
    const [low, high] = this.extent;
    const axis = Axis.linear(low, high, this.left, this.right);
    const seen = new Set();
    const steady = this.drawn.filter((lane) => lane.kind !== "analog");
    for (const lane of steady.length ? steady : this.drawn) for (const point of lane.points) seen.add(Math.round(axis.x(point.at[0])));
    let d = "";
    for (const x of seen) d += `M${x} 7V17`;
    const out = [box("ground", this.left, 4, this.right - this.left, 16), s("path", { class: "activity", d: d || "M0 0" })];
    for (const claim of this.record.claims) {
      if (claim.deciding_ns) out.push(box(`decided v-${claim.verdict}`, axis.x(middle(claim.deciding_ns)) - 1, bad(claim.verdict) ? 4 : 15, 2, bad(claim.verdict) ? 16 : 5));
    }
    for (const piece of this.axis.pieces) {
      const [a, b] = [axis.x(piece.t0), axis.x(piece.t1)];
      out.push(box("seen", a - Math.max(0, 3 - (b - a)) / 2, 3, Math.max(b - a, 3), 18));
    }
    out.push(label("small", 0, 16, "whole case"), label("small mid", (this.left + this.right) / 2, 33, span(high - low)));
    out.push(label("small", this.left, 33, offset(low - this.record.start_ns)), label("small end", this.right, 33, offset(high - this.record.start_ns)));
    this.mapAxis = axis;
    dress(this.map, { viewBox: `0 0 ${this.width} 38`, width: this.width, height: 38 });
    this.map.replaceChildren(...out);
  }

  // The diagram in words, for those who cannot see it.
  described() {
    const record = this.record;
    const words = record.claims
      .map((claim, at) => ({ claim, n: at + 1 }))
      .filter(({ claim }) => bad(claim.verdict))
      .map(({ claim, n }) => `Claim ${n}, ${claim.verdict}: ${claim.name}${claim.deciding_ns ? ` at ${relative(claim.deciding_ns, record.start_ns)} from start` : ""}.`);
    const keys =
      "Left and right arrow move the cursor from edge to edge, with Shift by a pixel; up and down choose the signal; A and B choose the cursor, Escape takes both away; plus and minus zoom, Page Up and Page Down pan, 0 shows the whole case, C what the claims speak of.";
    return [`Signals: ${this.lanes.map((lane) => lane.signal).join(", ")}.`, ...words, keys].join(" ");
  }
}
