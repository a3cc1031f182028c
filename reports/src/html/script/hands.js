// Mouse, touch and keys of a diagram.
const STILL = 4; // a press that moves less is a click, in pixels

const handle = (scope) => {
  const { stage, plot, map, cursors } = scope;
  const where = (event, svg) => {
    const frame = svg.getBoundingClientRect();
    return ((event.clientX - frame.left) * scope.width) / frame.width;
  };
  let held = null;

  plot.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || event.target.closest(".tagged")) return;
    const x = where(event, plot);
    if (x < scope.left - 2) return;
    held = { x, last: x, moved: false, cursor: cursors.grasp(x) };
    plot.setPointerCapture(event.pointerId);
  });
  plot.addEventListener("pointermove", (event) => {
    const x = where(event, plot);
    if (!held) {
      cursors.hover = x >= scope.left && event.pointerType === "mouse" ? x : null;
      plot.classList.toggle("grasp", cursors.grasp(x) !== null);
      cursors.draw();
      return;
    }
    held.moved ||= Math.abs(x - held.x) >= STILL;
    if (!held.moved) return;
    if (held.cursor) {
      cursors.activate(held.cursor);
      cursors.set(held.cursor, cursors.snap(x));
    } else {
      cursors.hover = null;
      scope.move(held.last - x);
    }
    held.last = x;
  });
  plot.addEventListener("pointerup", () => {
    if (held && !held.moved && !held.cursor) cursors.press(held.x);
    held = null;
  });
  plot.addEventListener("pointercancel", () => {
    held = null;
  });
  plot.addEventListener("pointerleave", () => {
    cursors.hover = null;
    cursors.draw();
  });

  // Without Ctrl or Shift the wheel belongs to the page.
  plot.addEventListener(
    "wheel",
    (event) => {
      const x = where(event, plot);
      if (event.ctrlKey || event.metaKey) scope.zoom(1.0015 ** Math.max(Math.min(event.deltaY, 400), -400), Math.max(x, scope.left));
      else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) scope.move(event.deltaX || event.deltaY);
      else return;
      event.preventDefault();
    },
    { passive: false },
  );

  // The strip below: a press shows that part of the case.
  const jump = (event) => {
    const t = scope.mapAxis.t(where(event, map));
    const middleX = (scope.left + scope.right) / 2;
    const half = Math.min((scope.axis.scale(middleX) * (scope.right - scope.left)) / 2, (scope.extent[1] - scope.extent[0]) / 8);
    scope.show(t - half, t + half);
  };
  map.addEventListener("pointerdown", (event) => {
    map.setPointerCapture(event.pointerId);
    jump(event);
  });
  map.addEventListener("pointermove", (event) => {
    if (event.buttons) jump(event);
  });

  const keys = {
    "+": () => scope.zoom(0.5),
    "=": () => scope.zoom(0.5),
    "-": () => scope.zoom(2),
    0: () => scope.whole(),
    c: () => scope.fit(),
    a: () => cursors.activate("A"),
    b: () => cursors.activate("B"),
    PageUp: () => scope.pan(-0.5),
    PageDown: () => scope.pan(0.5),
    ArrowUp: () => cursors.choose(-1),
    ArrowDown: () => cursors.choose(1),
    ArrowLeft: (event) => (event.shiftKey ? cursors.nudge(-1) : cursors.step(-1)),
    ArrowRight: (event) => (event.shiftKey ? cursors.nudge(1) : cursors.step(1)),
    Escape: () => cursors.clear(),
  };
  stage.addEventListener("keydown", (event) => {
    const act = keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    act(event);
    event.preventDefault();
  });
};
