// The page: views, the address that names what is shown, printing.
const VIEWS = ["overview", "cases", "requirements", "repeats", "coverage"];
const NAMES = { overview: "Overview", cases: "Cases", requirements: "Requirements", repeats: "Repeats", coverage: "Coverage" };
const MOST_PRINTED = 100;

// The address of a state of the page.
const link = (state) => `#${new URLSearchParams(Object.entries(state).filter(([, value]) => value))}`;

class Page {
  constructor(run, root) {
    this.run = run;
    this.cases = new Cases(run, (state) => this.remember({ view: "cases", ...state }));
    this.requirements = new Requirements(run, (state) => this.remember({ view: "requirements", ...state }));
    const contents = {
      overview: () => overview(run),
      cases: () => this.cases.element,
      requirements: () => this.requirements.list.length > 0 && this.requirements.element,
      repeats: () => repeats(run),
      coverage: () => document.getElementById("coverage"),
    };
    this.panels = {};
    this.tabs = {};
    for (const name of VIEWS) {
      const content = contents[name]();
      if (!content) continue;
      const count = { cases: run.cases.length, requirements: this.requirements.list.length }[name];
      this.panels[name] = h("div", { class: "panel", id: `view-${name}`, role: "tabpanel", "aria-labelledby": `tab-${name}`, tabindex: -1 }, content);
      this.tabs[name] = h("button", { type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `view-${name}`, click: () => this.go({ view: name, ...(name === "cases" ? this.cases.state() : {}) }), keydown: (event) => this.turn(event, name) }, NAMES[name], given(count) && h("span", { class: "soft" }, ` ${count}`));
    }
    root.replaceChildren(h("div", { class: "views", role: "tablist", "aria-label": "Views" }, Object.values(this.tabs)), ...Object.values(this.panels));
    this.show("overview");
    addEventListener("hashchange", () => this.follow());
    addEventListener("beforeprint", () => this.print());
    addEventListener("afterprint", () => this.printed());
    this.follow();
  }

  // Arrow keys go along the tabs.
  turn(event, name) {
    const way = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!way) return;
    const names = Object.keys(this.tabs);
    const next = names[(names.indexOf(name) + way + names.length) % names.length];
    this.tabs[next].focus();
    this.tabs[next].click();
    event.preventDefault();
  }

  show(name) {
    for (const [key, panel] of Object.entries(this.panels)) {
      panel.hidden = key !== name;
      dress(this.tabs[key], { "aria-selected": String(key === name), tabindex: key === name ? 0 : -1 });
    }
  }

  go(state) {
    if (link(state) === location.hash) this.follow();
    else location.hash = link(state);
  }

  // What is shown becomes part of the address, without a step of its own in the history.
  remember(state) {
    if (link(state) !== location.hash) history.replaceState(null, "", link(state));
  }

  follow() {
    const state = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
    if (state.case !== undefined) {
      this.show("cases");
      const element = this.cases.open(state.case);
      if (element) {
        element.scrollIntoView({ block: "start" });
        element.querySelector("summary").focus({ preventScroll: true });
        // Once more when everything has its height.
        requestAnimationFrame(() => requestAnimationFrame(() => element.scrollIntoView({ block: "start" })));
      }
      return;
    }
    const view = this.panels[state.view] ? state.view : "overview";
    this.show(view);
    if (view === "cases") this.cases.set(state);
    if (view === "requirements") this.requirements.set(state);
  }

  // On paper: every view, and every case that is shown without a pass, open.
  print() {
    this.opened = [];
    if (!this.requirements.body.firstChild) this.requirements.apply();
    for (const { folder, record } of this.cases.shownCases().filter(({ record }) => bad(record.word)).slice(0, MOST_PRINTED)) {
      const made = folder.reveal(record);
      if (!made.element.open) this.opened.push(made);
      made.open();
    }
  }

  printed() {
    for (const made of this.opened) made.element.open = false;
  }
}

const start = async () => {
  const root = document.getElementById("page");
  if (!("DecompressionStream" in window)) {
    root.prepend(h("p", { class: "reason v-error" }, "This browser cannot unpack the page: it has no DecompressionStream. What is below is the summary."));
    return;
  }
  const run = prepare(await unpack(document.getElementById("run").textContent));
  window.page = new Page(run, root);
  document.documentElement.dataset.ready = "yes";
};
start().catch((error) => {
  document.getElementById("page").prepend(h("p", { class: "reason v-error" }, `The page could not be drawn: ${error.message}. What is below is the summary.`));
});
