"use strict";
(() => {
  const all = (selector, root = document) => [...root.querySelectorAll(selector)];
  const cases = all("details.case");
  const form = document.querySelector(".filter");
  const words = cases.map((c) => (c.querySelector("summary").textContent + " " + (c.querySelector(".meta")?.textContent ?? "")).toLowerCase());
  const apply = () => {
    const verdicts = new Set(all("input[name=verdict]:checked", form).map((box) => box.value));
    const text = form.elements.text.value.trim().toLowerCase();
    let shown = 0;
    cases.forEach((c, i) => {
      c.hidden = !(verdicts.has(c.dataset.verdict) && words[i].includes(text));
      shown += c.hidden ? 0 : 1;
    });
    all(".folder").forEach((f) => { f.hidden = !f.querySelector("details.case:not([hidden])"); });
    form.querySelector(".shown").value = shown === cases.length ? "" : `${shown} of ${cases.length} shown`;
  };
  form.hidden = cases.length < 2;
  form.addEventListener("input", apply);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.elements.open.addEventListener("click", () => cases.forEach((c) => { if (!c.hidden) c.open = true; }));
  form.elements.close.addEventListener("click", () => cases.forEach((c) => { c.open = false; }));

  // A link to something inside a closed or filtered case opens and shows it.
  const reveal = () => {
    let id = "";
    try { id = decodeURIComponent(location.hash.slice(1)); } catch { return; }
    const target = id && document.getElementById(id);
    const owner = target && target.closest("details.case");
    if (!owner) return;
    owner.hidden = false;
    owner.closest(".folder").hidden = false;
    owner.open = true;
    target.scrollIntoView({ block: owner === target ? "start" : "center" });
  };
  addEventListener("hashchange", reveal);
  reveal();

  // On paper every case that is shown is open.
  let closed = [];
  addEventListener("beforeprint", () => { closed = cases.filter((c) => !c.open && !c.hidden); closed.forEach((c) => { c.open = true; }); });
  addEventListener("afterprint", () => closed.forEach((c) => { c.open = false; }));

  // Reading times off a diagram.
  const format = (ns) => {
    const size = Math.abs(ns);
    const [unit, name] = size >= 1e9 ? [1e9, "s"] : size >= 1e6 ? [1e6, "ms"] : size >= 1e3 ? [1e3, "us"] : [1, "ns"];
    return `${Number((ns / unit).toPrecision(7))} ${name}`;
  };
  for (const svg of all("svg.diagram")) {
    const pieces = svg.dataset.pieces.split(";").map((piece) => piece.split(",").map(Number));
    const output = svg.parentElement.querySelector(".reading");
    const line = (kind) => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", "line");
      made.setAttribute("class", kind);
      made.setAttribute("y1", svg.dataset.top);
      made.setAttribute("y2", svg.dataset.bottom);
      made.style.display = "none";
      return svg.appendChild(made);
    };
    const cursor = line("cursor"), anchor = line("cursor held");
    let held = null;
    const read = (event) => {
      const x = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse()).x;
      const piece = pieces.find(([, , x0, x1]) => x >= x0 && x <= x1);
      return piece && { x, t: piece[0] + (piece[1] - piece[0]) * (x - piece[2]) / (piece[3] - piece[2]) };
    };
    const place = (which, at) => {
      which.style.display = at ? "" : "none";
      if (at) { which.setAttribute("x1", at.x); which.setAttribute("x2", at.x); }
    };
    svg.addEventListener("pointermove", (event) => {
      const at = read(event);
      place(cursor, at);
      output.value = !at ? "" : `start + ${format(at.t)}` + (held ? `, ${format(at.t - held.t)} from the mark` : "");
    });
    svg.addEventListener("pointerleave", () => { place(cursor, null); output.value = ""; });
    svg.addEventListener("click", (event) => {
      if (event.target.closest("a")) return;
      held = held ? null : read(event) || null;
      place(anchor, held);
    });
  }
})();
