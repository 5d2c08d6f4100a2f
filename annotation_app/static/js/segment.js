// Segment: choose words, say what they are, see the tree.

import { $, announce, choice, h, isShortcut, redraw } from "./dom.js";
import { segmentFeedback } from "./practice.js";
import { drawTrees } from "./sdc-drawing.js";
import * as sdc from "./sdc.js";
import { begin, payload } from "./work.js";

const { words, suggestion } = payload;
const TYPE_KEYS = { e: "EVENT", o: "OBJECT", p: "PLACE", t: "PATH" };
const FIELD_KEYS = { n: "alone", s: "f", l: "l", m: "l2" };

let chosen = new Set(); // words, not part of the draft
let focused = 0;
let anchor = 0;

const editor = $("editor");
const wordBar = h("div", { class: "words", role: "toolbar", "aria-label": "The words of the command" });
const maker = h("section", { class: "panel maker", "aria-label": "Make a clause" });
const clausePanel = h("section", { class: "panel", "aria-label": "The current clause" });
const list = h("section", { class: "panel", "aria-label": "All clauses" });
const drawing = h("div", { class: "drawing" });
const notes = h("div", { class: "hints" });
const buttons = words.map((word, i) =>
  h("button", { type: "button", class: "word", onclick: (event) => press(i, event) }, h("bdi", {}, word.text)),
);
wordBar.append(...buttons);
wordBar.addEventListener("keydown", walk);
editor.append(
  suggestion ? suggested() : "",
  h(
    "div",
    { class: "columns" },
    h("div", { class: "stack" }, h("div", { class: "panel" }, h("p", { class: "label" }, "1. Choose the words of a clause"), wordBar), maker, clausePanel),
    h("div", { class: "stack" }, drawing, notes, list),
  ),
);

showExample();
const start = suggestion ? sdc.fromJson(suggestion, words) : sdc.empty;
const work = begin({
  initial: start,
  draw,
  body: (state) => ({ sdcs: sdc.toJson(state, words) }),
  problems: (state) => sdc.problems(state, words),
  feedback: (state) => segmentFeedback(sdc.toJson(state, words)),
});

/** What the instructions speak of, drawn. */
function showExample() {
  const spans = [["Put", 0], ["the", 4], ["cup", 8], ["on", 12], ["the", 15], ["table", 19]];
  const [put, the, cup, on, the2, table] = spans;
  const tree = {
    type: "EVENT",
    r: [put],
    l: [{ type: "OBJECT", f: [the, cup] }],
    l2: [{ type: "PLACE", r: [on], l: [{ type: "OBJECT", f: [the2, table] }] }],
  };
  const example = spans.map(([text, start]) => ({ text, start }));
  const state = { ...sdc.fromJson([tree], example), current: null };
  $("example").replaceChildren(
    h("div", { class: "drawing" }, drawTrees(state, example, null)),
    h("figcaption", { class: "quiet" }, "“Put the cup on the table”: the OBJECT “the cup” is the landmark of “Put”, and the PLACE “on” is its second landmark."),
  );
}

function suggested() {
  return h(
    "p",
    { class: "notice" },
    "A program has made this suggestion. It makes mistakes: correct them, or ",
    h("button", { type: "button", class: "link", onclick: () => apply(sdc.empty, "All clauses removed") }, "start from nothing"),
    ".",
  );
}

function apply(next, said) {
  chosen = new Set();
  work.change(next);
  announce(said);
}

function press(i, event) {
  focused = i;
  if (event.shiftKey) range(anchor, i);
  else {
    anchor = i;
    if (chosen.has(i)) chosen.delete(i);
    else chosen.add(i);
  }
  draw(work.state);
}

function range(a, b) {
  for (let i = Math.min(a, b); i <= Math.max(a, b); i += 1) chosen.add(i);
}

function walk(event) {
  const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  const to = event.key === "Home" ? 0 : event.key === "End" ? words.length - 1 : focused + (step ?? NaN);
  if (Number.isNaN(to) || event.ctrlKey || event.metaKey) return;
  event.preventDefault();
  if (event.shiftKey) chosen.add(focused);
  focused = Math.max(0, Math.min(words.length - 1, to));
  if (event.shiftKey) chosen.add(focused);
  else anchor = focused;
  draw(work.state);
  buttons[focused].focus();
}

function picked() {
  return [...chosen].sort((a, b) => a - b);
}

function phrase(numbers) {
  return sdc.text(numbers, words);
}

function make(type) {
  if (!chosen.size) return announce("Choose words first");
  const taken = picked();
  apply(sdc.add(work.state, type, taken), `${type} made: ${phrase(taken)}`);
}

function give(field) {
  if (!chosen.size || !sdc.currentOf(work.state)) return announce("Choose words and a clause first");
  const taken = picked();
  apply(sdc.give(work.state, field, taken), `Added to the ${sdc.FIELD_NAMES[field]}: ${phrase(taken)}`);
}

function removeCurrent() {
  const current = sdc.currentOf(work.state);
  if (current) apply(sdc.remove(work.state, current.id), `${current.type} removed`);
}

function pick(id) {
  work.change(sdc.choose(work.state, id), { silent: true });
  const clause = sdc.find(work.state, id);
  announce(`${clause.type}: ${phrase(sdc.wordsOf(work.state, id))}`);
}

function inListOrder(state, id = null) {
  return sdc.children(state, id).flatMap((c) => [c, ...inListOrder(state, c.id)]);
}

document.addEventListener("keydown", (event) => {
  if (!isShortcut(event)) return;
  const key = event.key.toLowerCase();
  const state = work.state;
  if (TYPE_KEYS[key]) make(TYPE_KEYS[key]);
  else if (key === "r" || key === "f") give(key);
  else if (FIELD_KEYS[key]) setField(FIELD_KEYS[key]);
  else if (key === "delete" || key === "backspace") removeCurrent();
  else if (key === "[" || key === "]") {
    const all = inListOrder(state);
    const at = all.findIndex((c) => c.id === state.current);
    const next = all[(at + (key === "]" ? 1 : all.length - 1)) % all.length];
    if (next) pick(next.id);
  } else if (key === "escape") {
    chosen = new Set();
    draw(state);
  } else return;
  event.preventDefault();
});

function setField(field) {
  if (field !== "alone" && !sdc.currentOf(work.state)) return;
  work.change(sdc.chooseField(work.state, field), { silent: true });
  announce(field === "alone" ? "The next clause stands alone" : `The next clause becomes a ${sdc.FIELD_NAMES[field]}`);
}

function draw(state) {
  const current = sdc.currentOf(state);
  const inCurrent = current ? sdc.wordsOf(state, current.id) : [];
  buttons.forEach((button, i) => {
    const holder = sdc.holder(state, i);
    button.className = `word${holder ? ` type-${holder.type}` : ""}${inCurrent.includes(i) ? " in-current" : ""}`;
    button.setAttribute("aria-pressed", chosen.has(i));
    button.tabIndex = i === focused ? 0 : -1;
    button.setAttribute("aria-label", holder ? `${words[i].text}, in ${holder.type}` : words[i].text);
  });
  redraw(maker, ...makerParts(state, current));
  redraw(clausePanel, ...clauseParts(state, current));
  redraw(list, h("h2", {}, "All clauses"), state.clauses.length ? branches(state, null) : h("p", { class: "quiet" }, "None yet."));
  drawing.replaceChildren(state.clauses.length ? drawTrees(state, words, pick) : h("p", { class: "quiet" }, "The tree is drawn here."));
  notes.replaceChildren(...sdc.hints(state, words).map((hint) => h("p", { class: "quiet" }, hint)));
}

function makerParts(state, current) {
  const fields = ["alone", "f", "l", "l2"].map((field) =>
    choice(
      "radio",
      "field",
      field === "alone" ? "alone" : sdc.FIELD_NAMES[field],
      state.field === field || (field === "alone" && !current),
      () => setField(field),
      { value: field, disabled: !current && field !== "alone", "data-key": `field ${field}` },
    ),
  );
  const of = current ? h("span", {}, " of ", name(state, current)) : "";
  return [
    h("fieldset", { class: "inline" }, h("legend", {}, "2. It is"), ...fields, of),
    h("p", { class: "label", id: "type-label" }, "3. Make it a clause"),
    h(
      "div",
      { class: "types", role: "group", "aria-labelledby": "type-label" },
      Object.entries(TYPE_KEYS).map(([key, type]) =>
        h(
          "button",
          { type: "button", class: `type type-${type}`, "aria-keyshortcuts": key, "data-key": type, onclick: () => make(type) },
          type, " ", h("kbd", { "aria-hidden": "true" }, key.toUpperCase()),
        ),
      ),
    ),
  ];
}

function name(state, clause) {
  return h("q", {}, h("bdi", {}, phrase(sdc.wordsOf(state, clause.id)) || clause.type));
}

function clauseParts(state, current) {
  if (!current) {
    return [h("h2", {}, "Current clause"), h("p", { class: "quiet" }, "Choose words above and make the first clause.")];
  }
  const own = sdc.subtree(state, current.id);
  const others = inListOrder(state).filter((c) => !own.includes(c.id));
  const type = select("type", sdc.TYPES.map((t) => [t, t]), current.type, (value) =>
    apply(sdc.retype(work.state, current.id, value), `It is a ${value} now`),
  );
  const inside = select(
    "inside",
    [["", "nothing, it stands alone"], ...others.map((c) => [c.id, `${c.type}: ${phrase(sdc.wordsOf(state, c.id))}`])],
    current.parent ?? "",
    (value) => apply(sdc.move(work.state, current.id, value ? Number(value) : null, current.field ?? "l"), "Moved"),
  );
  const as = select("as", ["f", "l", "l2"].map((f) => [f, sdc.FIELD_NAMES[f]]), current.field ?? "l", (value) =>
    apply(sdc.move(work.state, current.id, current.parent, value), `It is a ${sdc.FIELD_NAMES[value]} now`),
  );
  as.disabled = current.parent === null;
  const holds = ["f", "r"].filter((f) => current[f].length);
  const button = (label, key, onclick) => h("button", { type: "button", "data-key": key, onclick }, label);
  return [
    h("h2", {}, "Current clause: ", name(state, current)),
    holds.length ? h("dl", { class: "fields" }, holds.map((f) => h("div", {}, h("dt", {}, sdc.FIELD_NAMES[f]), h("dd", {}, h("bdi", {}, phrase(current[f])))))) : null,
    h("div", { class: "grid" }, h("label", {}, "Type", type), h("label", {}, "Inside", inside), h("label", {}, "As its", as)),
    h(
      "div",
      { class: "actions" },
      button("Add chosen words to the relation", "give r", () => give("r")),
      button("… to the figure", "give f", () => give("f")),
      button("Take chosen words out", "free", () => apply(sdc.free(work.state, picked()), "Words taken out")),
      button("Remove clause", "remove", removeCurrent),
    ),
  ].filter(Boolean);
}

function select(key, options, value, onchange) {
  const made = h(
    "select",
    { "data-key": key, onchange: (event) => onchange(event.target.value) },
    options.map(([v, label]) => h("option", { value: v }, label)),
  );
  made.value = value;
  return made;
}

function branches(state, id) {
  return h(
    "ul",
    { class: "clauses" },
    sdc.children(state, id).map((c) => {
      const below = sdc.children(state, c.id);
      const field = c.field ? h("span", { class: "quiet" }, `${sdc.FIELD_NAMES[c.field]}: `) : "";
      return h(
        "li",
        {},
        h(
          "button",
          { type: "button", class: `clause type-${c.type}`, "aria-current": c.id === state.current ? "true" : null, "data-key": `clause ${c.id}`, onclick: () => pick(c.id) },
          field, h("b", {}, c.type), " ", h("bdi", {}, phrase(sdc.ownWords(c)) || "…"),
        ),
        below.length ? branches(state, c.id) : null,
      );
    }),
  );
}
