// Elements and their texts. A text of the record only ever becomes a text node or the value of an attribute, and
// passes `clean` on its way: nothing of it is read as markup.
const SVG = "http://www.w3.org/2000/svg";

// What a reader of text could act on: control characters and invisible marks of direction.
const UNSEEN = /[\u0000-\u001f\u007f-\u009f\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff\ufffe\uffff]/g;
const clean = (text) => String(text).replace(UNSEEN, (c) => ("\n\r\t".includes(c) ? " " : "\ufffd"));

const put = (node, children) => {
  for (const child of children) {
    if (Array.isArray(child)) put(node, child);
    else if (child instanceof Node) node.append(child);
    else if (child !== null && child !== undefined && child !== false && child !== "") node.append(clean(child));
  }
  return node;
};

const dress = (node, attributes) => {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") node.addEventListener(name, value);
    else node.setAttribute(name, value === true ? "" : clean(value));
  }
  return node;
};

const h = (name, attributes, ...children) => put(dress(document.createElement(name), attributes), children);
const s = (name, attributes, ...children) => put(dress(document.createElementNS(SVG, name), attributes), children);

const all = (selector, root = document) => [...root.querySelectorAll(selector)];

// A coordinate with one decimal at most.
const px = (x) => (Number.isFinite(x) ? Math.round(x * 10) / 10 : 0);

// A button with a name of its own where what it shows is only a sign.
const button = (label, sign, press, more) =>
  h("button", { type: "button", "aria-label": sign === label ? null : label, title: sign === label ? null : label, click: press, ...more }, sign);

const plural = (n, one, many = `${one}s`) => `${n} ${n === 1 ? one : many}`;
