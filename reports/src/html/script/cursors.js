// Two cursors that measure: they snap to edges, and know an instant no better than the trace does.
const REACH = 8; // a click this near to an edge means the edge, in pixels
const GRASP = 6; // a press this near to a cursor takes hold of it, in pixels

class Cursors {
  constructor(scope) {
    this.scope = scope;
    this.A = null; // { at: [earliest, latest], what }
    this.B = null;
    this.active = "A";
    this.lane = null; // the signal whose edges count; all without one
    this.hover = null;
    this.reading = h("div", { class: "reading" });
    this.spoken = h("p", { class: "unseen", role: "status" });
    this.read();
  }

  tools() {
    const choice = (id) => button(`Cursor ${id}`, id, () => this.activate(id), { class: `cursor-${id}`, "aria-pressed": String(this.active === id) });
    this.buttons = { A: choice("A"), B: choice("B") };
    return h("span", { class: "set" }, this.buttons.A, this.buttons.B, button("Previous edge", "⇤", () => this.step(-1)), button("Next edge", "⇥", () => this.step(1)), button("Clear cursors", "Clear", () => this.clear()));
  }

  activate(id) {
    this.active = id;
    for (const [key, made] of Object.entries(this.buttons)) made.setAttribute("aria-pressed", String(key === id));
  }

  clear() {
    [this.A, this.B] = [null, null];
    this.activate("A");
    this.changed();
  }

  // What a cursor can snap to, in the order of time.
  edges() {
    if (this.known?.of === this.lane) return this.known.list;
    const { record, drawn } = this.scope;
    const list = [];
    for (const lane of this.lane ? [this.lane] : drawn) {
      let before;
      for (const point of lane.points) {
        if (before !== undefined && point.value !== before) list.push({ at: point.at, what: `${lane.signal} ${this.change(lane, point.value)}` });
        before = point.value;
      }
    }
    if (!this.lane) {
      for (const step of record.steps) if (step.at_ns) list.push({ at: step.at_ns, what: step.id === "start" || step.id === "end" ? step.id : `step ${step.id}` });
      record.claims.forEach((claim, at) => {
        for (const t of [claim.window?.limit_from_ns, claim.window?.limit_until_ns]) if (given(t)) list.push({ at: [t, t], what: `limit of claim ${at + 1}` });
      });
    }
    list.sort((a, b) => a.at[0] - b.at[0]);
    this.known = { of: this.lane, list };
    return list;
  }

  change(lane, value) {
    if (lane.kind !== "digital" || !isNumber(value)) return `→ ${named(lane, value)}`;
    return value === 0 ? "falls" : "rises";
  }

  // What is meant by a place: an edge within reach, else the instant itself.
  snap(x) {
    const axis = this.scope.axis;
    let best = null;
    let reach = REACH;
    for (const edge of this.edges()) {
      const t = middle(edge.at);
      const away = Math.abs(axis.x(t) - x);
      if (away < reach && axis.shows(t)) [best, reach] = [edge, away];
    }
    if (best) return best;
    const t = axis.t(x);
    return { at: [t, t], what: "" };
  }

  set(id, mark) {
    this[id] = mark;
    this.changed();
  }

  // A click: the active cursor goes there, and the other one is next.
  press(x) {
    this.set(this.active, this.snap(x));
    this.activate(this.active === "A" ? "B" : "A");
  }

  // The cursor under the pointer.
  grasp(x) {
    const near = (id) => this[id] && Math.abs(this.scope.axis.x(middle(this[id].at)) - x) <= GRASP;
    return near("B") ? "B" : near("A") ? "A" : null;
  }

  // Where the active cursor is, where it is seen.
  focus() {
    const mark = this[this.active] ?? this.A;
    const t = mark && middle(mark.at);
    return given(t) && this.scope.axis.shows(t) ? this.scope.axis.x(t) : null;
  }

  // To the edge before or after.
  step(way) {
    const axis = this.scope.axis;
    const list = this.edges();
    const mark = this[this.active];
    const t = mark ? middle(mark.at) : way > 0 ? axis.first.t0 - 1 : axis.last.t1 + 1;
    const next = way > 0 ? list.find((edge) => middle(edge.at) > t) : list.findLast((edge) => middle(edge.at) < t);
    if (next) this.go(next);
  }

  // By pixels, onto no edge.
  nudge(pixels) {
    const axis = this.scope.axis;
    const x = this.focus() ?? (this.scope.left + this.scope.right) / 2;
    const mark = this[this.active];
    const t = (mark ? middle(mark.at) : axis.t(x)) + Math.round(axis.scale(x) * pixels) || 0;
    this.go({ at: [t, t], what: "" });
  }

  // The diagram follows a cursor that leaves it.
  go(mark) {
    const { scope } = this;
    this.set(this.active, mark);
    const t = middle(mark.at);
    if (scope.axis.shows(t)) return;
    const middleX = (scope.left + scope.right) / 2;
    const half = ((scope.right - scope.left) * scope.axis.scale(middleX)) / 2;
    scope.show(t - half, t + half);
  }

  // The signal above or below in the list, or all.
  choose(way) {
    const list = [null, ...this.scope.drawn];
    this.lane = list[(list.indexOf(this.lane) + way + list.length) % list.length];
    this.changed();
    this.spoken.textContent = clean(this.lane ? `Edges of ${this.lane.signal}` : "Edges of all signals");
  }

  changed() {
    this.draw();
    this.read();
  }

  draw() {
    const { axis, cursorTop, top, bottom, rows } = this.scope;
    if (!this.layer || !axis) return;
    const out = [];
    for (const id of ["A", "B"]) {
      const mark = this[id];
      if (!mark || !axis.shows(middle(mark.at))) continue;
      const [a, b] = mark.at.map((t) => axis.x(t));
      const x = axis.x(middle(mark.at));
      if (b - a >= UNCERTAIN) out.push(box("uncertain", a, top, b - a, bottom - top));
      out.push(line(`cursor cursor-${id}`, x, cursorTop + 14, x, bottom));
      out.push(s("g", { class: `handle cursor-${id}` }, s("rect", { x: px(x - 8), y: cursorTop, width: 16, height: 14, rx: 3 }), label("mid", x, cursorTop + 11, id)));
    }
    if (this.A && this.B) {
      const [a, b] = [this.A, this.B].map((mark) => axis.x(middle(mark.at)));
      const [x0, x1] = [Math.min(a, b) + 9, Math.max(a, b) - 9];
      const text = `Δ ${between(this.delta())}`;
      if (x1 > x0) out.push(line("gap", x0, cursorTop + 7, x1, cursorTop + 7));
      const wide = textWidth(text) * 1.15 + 10;
      const inside = x1 - x0 > wide + 8;
      const x = inside ? (x0 + x1) / 2 : x1 + 20 + wide < this.scope.right ? x1 + 22 + wide / 2 : x0 - 22 - wide / 2;
      out.push(box("gap-ground", x - wide / 2, cursorTop, wide, 14), label("gap-text mid", x, cursorTop + 11, text));
    }
    if (this.hover !== null && this.hover >= axis.first.x0 && this.hover <= axis.last.x1) {
      const text = offset(axis.t(this.hover) - this.scope.record.start_ns);
      out.push(line("hover", this.hover, top, this.hover, bottom));
      const wide = textWidth(text) * 1.1 + 10;
      const x = Math.min(Math.max(this.hover, this.scope.left + wide / 2), this.scope.right - wide / 2);
      out.push(box("hover-ground", x - wide / 2, bottom + 3, wide, 15), label("small mid", x, bottom + 15, text));
    }
    // The values at the active cursor, or at the one that is set.
    const mark = this.hover !== null ? null : this[this.active] ?? this.A ?? this.B;
    const t = mark ? middle(mark.at) : this.hover !== null ? axis.t(this.hover) : null;
    for (const row of rows) {
      row.name.classList.toggle("chosen", row.lane === this.lane);
      const value = t === null || this.scope.compact ? "" : valueAt(row.lane, t);
      if (value) out.push(label("value end", row.valueX, row.base, fit(value, 84)));
    }
    this.layer.replaceChildren(...out);
  }

  // The distance from A to B, as well as both are known.
  delta() {
    return [this.B.at[0] - this.A.at[1], this.B.at[1] - this.A.at[0]];
  }

  read() {
    const { record } = this.scope;
    const cell = (name, kind, text, note) => h("span", { class: `cell ${kind}` }, h("b", {}, name), h("span", { class: "code" }, text), note && h("span", { class: "note" }, note));
    const cells = ["A", "B"].filter((id) => this[id]).map((id) => cell(id, `cursor-${id}`, relative(this[id].at, record.start_ns), this[id].what));
    if (this.A && this.B) {
      const [low, high] = this.delta();
      const rate = low === high && low !== 0 ? figure(Number((1e9 / Math.abs(low)).toPrecision(6)), "Hz") : "";
      cells.push(cell("Δ", "delta", between([low, high]), rate));
    }
    const hint = h("span", { class: "hint" }, "Click for cursor A, again for B; drag to pan, Ctrl + wheel to zoom. Keys: ← → edges, + − zoom, A B Esc cursors.");
    this.reading.replaceChildren(...(cells.length ? cells : [hint]), this.spoken);
    this.spoken.textContent = cells.map((made) => [...made.children].map((child) => child.textContent).join(" ")).join("; ");
  }
}
