// Ground: what each clause refers to, in the picture and on the map.

import { $, announce, choice, h, isShortcut, redraw } from "./dom.js";
import { clauseBar, neighbour, showCommand } from "./clauses.js";
import { showMap } from "./map.js";
import { showPicture } from "./picture.js";
import { groundFeedback } from "./practice.js";
import { numbered } from "./scene.js";
import { begin, data, payload } from "./work.js";

const scene = numbered(payload);
const { clauses } = scene;
const NOTHING = { objects: [], places: [], cant_tell: false, time_s: 0 };
const LABELS = data.labels;
const isThing = (clause) => clause.type === "OBJECT" || clause.type === "PLACE";

const isAsked = (clause) => isThing(clause) || payload.asks_parts;
const first = clauses.find(isAsked) ?? clauses[0];
const mustWatch = Boolean(scene.video);
const hasMap = !scene.map.missing;

let map = null;
const picture = showPicture(scene, toggleObject, (t) => map?.show(t));
map = showMap(scene, (kind, id) => (kind === "object" ? toggleObject(id) : togglePlace(id)), addPlace);
const bar = h("div");
const ask = h("section", { class: "panel ask", "aria-label": "What this clause refers to" });
const lists = h("section", { class: "lists", "aria-label": "Things and places by their numbers" });
$("editor").append(bar, ask, h("div", { class: "scene" }, picture.element, hasMap ? map.element : null), lists);

const work = begin({
  initial: { groundings: {}, trims: {}, whole: [], current: first?.node },
  draw,
  body: ({ groundings, trims, whole = [], watched_s }) => ({ groundings, trims, whole: whole.map(String), watched_s }),
  problems: (state) => [
    ...(mustWatch && state.watched_s === undefined ? ["Watch the video to its end first."] : []),
    ...clauses
      .filter((clause) => !isDone(state, clause))
      .map((clause) => isThing(clause)
        ? `Show what “${clause.phrase}” is, or choose “can't tell”.`
        : `Choose which part of the video shows “${clause.phrase}”.`),
  ],
  feedback: groundFeedback,
});

if (mustWatch) {
  picture.requireWatching(work.state.watched_s !== undefined, (watched_s) =>
    work.change({ ...work.state, watched_s }, { silent: true }),
  );
}
map.board.addEventListener("stopped", () => ask.querySelector('[data-key="mark"]')?.focus());

function of(state, node) {
  return state.groundings[node] ?? NOTHING;
}

function clauseOf(state) {
  return clauses.find((clause) => clause.node === state.current);
}

function isDone(state, clause) {
  if (!isThing(clause)) return !payload.asks_parts || state.trims[clause.node] || isWhole(state, clause.node);
  const grounding = of(state, clause.node);
  return grounding.cant_tell || grounding.objects.length + grounding.places.length > 0;
}

function set(part, said) {
  const state = work.state;
  if (!isThing(clauseOf(state))) return;
  const time_s = Math.round(picture.time * 10) / 10;
  const next = { ...of(state, state.current), ...part, time_s };
  if (next.objects.length + next.places.length && part.cant_tell === undefined) next.cant_tell = false;
  work.change({ ...state, groundings: { ...state.groundings, [state.current]: next } });
  announce(said);
}

function toggleObject(id) {
  const { objects } = of(work.state, work.state.current);
  const { number } = scene.things.find((thing) => thing.id === id);
  const has = objects.includes(id);
  set({ objects: has ? objects.filter((o) => o !== id) : [...objects, id] }, `${LABELS.thing} ${number} ${has ? "not " : ""}chosen`);
}

function togglePlace(id) {
  const { places } = of(work.state, work.state.current);
  const has = places.some((place) => place.place === id);
  const { letter } = scene.zones.find((zone) => zone.id === id);
  set({ places: has ? places.filter((p) => p.place !== id) : [...places, { place: id }] }, `${LABELS.place} ${letter} ${has ? "not " : ""}chosen`);
}

function addPlace(xy) {
  set({ places: [...of(work.state, work.state.current).places, { xy }] }, "Place marked");
}

function cantTell() {
  const { cant_tell } = of(work.state, work.state.current);
  set({ ...NOTHING, cant_tell: !cant_tell }, cant_tell ? "Not can't tell" : "Can't tell");
}

function go(node) {
  if (map.isMarking) map.stop(true);
  work.change({ ...work.state, current: node }, { silent: true });
  const clause = clauseOf(work.state);
  announce(`${clause.type}: ${clause.phrase}`);
}

function isWhole(state, node) {
  return Boolean(state.whole?.includes(node));
}

/** Choose a part of the video for the current clause; null is the whole video. */
function setTrim(trim) {
  const { current } = work.state;
  const { [current]: _, ...others } = work.state.trims;
  const trims = trim ? { ...others, [current]: trim } : others;
  const left = (work.state.whole ?? []).filter((node) => node !== current);
  work.change({ ...work.state, trims, whole: trim ? left : [...left, current] });
}

document.addEventListener("keydown", (event) => {
  if (!isShortcut(event) || map.isMarking) return;
  const key = event.key.toLowerCase();
  if (key === "[" || key === "]") go(neighbour(clauses, work.state.current, key === "]" ? 1 : -1));
  else if (key === "x") cantTell();
  else if (key === "m" && hasMap && isThing(clauseOf(work.state))) map.startMarking();
  else if (/^[1-9]$/.test(key) && scene.things[Number(key) - 1]) toggleObject(scene.things[Number(key) - 1].id);
  else return;
  event.preventDefault();
});

function draw(state) {
  const clause = clauseOf(state);
  if (!clause) return;
  const grounding = of(state, clause.node);
  showCommand(clause.node);
  picture.mark(grounding.objects);
  map.mark(
    grounding.objects,
    grounding.places.map((place) => place.place),
    grounding.places.filter((place) => place.xy).map((place) => place.xy),
  );
  redraw(bar, clauseBar(clauses, clause.node, (c) => isDone(state, c), go));
  redraw(ask, ...(isThing(clause) ? askParts(clause, grounding) : trimParts(clause, state)));
  redraw(lists, ...(isThing(clause) ? listParts(grounding) : []));
}

function question(clause, words) {
  return h("h2", {}, words, " ", h("q", {}, h("bdi", {}, clause.phrase)), "?");
}

function next() {
  return h("button", { type: "button", "data-key": "next", onclick: () => go(neighbour(clauses, work.state.current, 1)) }, "Next clause");
}

function askParts(clause, grounding) {
  const marked = grounding.places
    .map((place, i) => [place, i])
    .filter(([place]) => place.xy)
    .map(([, i], n) =>
      h("li", {}, `Marked place ${n + 1} `, h("button", { type: "button", class: "link", "data-key": `unmark ${i}`, onclick: () => set({ places: grounding.places.filter((_, j) => j !== i) }, "Place removed") }, "remove")),
    );
  return [
    question(clause, clause.type === "PLACE" ? "Where is" : "What is"),
    h("p", { class: "quiet" }, hasMap ? "Click it in the picture or on the map, or choose its number below. Several are fine." : "Click it in the picture, or choose its number below. Several are fine."),
    marked.length ? h("ul", { class: "marked" }, marked) : null,
    h(
      "div",
      { class: "actions" },
      hasMap ? h("button", { type: "button", "data-key": "mark", onclick: () => map.startMarking() }, "Mark a place on the map") : null,
      h("button", { type: "button", "data-key": "cant", "aria-pressed": grounding.cant_tell, onclick: cantTell }, "Can't tell"),
      next(),
    ),
  ].filter(Boolean);
}

function listParts(grounding) {
  const box = (name, label, checked, onchange, key) => choice("checkbox", name, label, checked, onchange, { "data-key": key });
  const things = scene.things.map((thing) =>
    box("object", `${LABELS.thing} ${thing.number}${thing.isRobot ? ` (${LABELS.robot})` : ""}`, grounding.objects.includes(thing.id), () => toggleObject(thing.id), thing.id),
  );
  const zones = scene.zones.map((zone) =>
    box("place", `${LABELS.place} ${zone.letter}`, grounding.places.some((p) => p.place === zone.id), () => togglePlace(zone.id), zone.id),
  );
  return [
    h("div", { class: "panel" }, h("fieldset", {}, h("legend", {}, "Things"), h("div", { class: "choices" }, things))),
    zones.length ? h("div", { class: "panel" }, h("fieldset", {}, h("legend", {}, "Places on the map"), h("div", { class: "choices" }, zones))) : null,
  ].filter(Boolean);
}

function trimParts(clause, state) {
  const trim = state.trims[clause.node];
  const isAllOfIt = isWhole(state, clause.node) || (!trim && !payload.asks_parts);
  const [from, to] = trim ?? [0, scene.duration_s];
  const slider = (label, value, set_) => {
    const output = h("output", {}, `${value.toFixed(1)} s`);
    const input = h("input", {
      type: "range", min: 0, max: scene.duration_s, step: 0.1, "aria-label": label, "data-key": label,
      oninput: () => {
        output.textContent = `${Number(input.value).toFixed(1)} s`;
        picture.seek(Number(input.value));
      },
      onchange: () => set_(Number(input.value)),
    });
    input.value = value;
    return h("label", { class: "range" }, h("span", {}, label), input, output);
  };
  const parts = scene.steps.map(([start, end], i) =>
    h("button", { type: "button", "data-key": `part ${i}`, onclick: () => setTrim([start, Math.min(end, scene.duration_s)]) }, `Part ${i + 1}: ${start.toFixed(0)}–${end.toFixed(0)} s`),
  );
  const whole = choice("radio", "trim", "The whole video", isAllOfIt, () => setTrim(null), { "data-key": "whole" });
  const part = choice("radio", "trim", "A part of it", Boolean(trim), () => setTrim(scene.steps[0] ?? [0, scene.duration_s]), { "data-key": "part" });
  return [
    question(clause, "Which part of the video shows"),
    h("div", { class: "choices" }, whole, part),
    trim
      ? h(
          "div",
          { class: "stack" },
          slider("From", from, (v) => setTrim([Math.min(v, to - 0.1), to])),
          slider("To", to, (v) => setTrim([from, Math.max(v, from + 0.1)])),
          parts.length > 1 ? h("div", { class: "actions" }, parts) : null,
        )
      : h("p", { class: "quiet" }, payload.asks_parts
        ? "The command has several steps. Play the video, and choose the part that shows this one."
        : "The command has one step: it is the whole video, unless you choose a part."),
    h("div", { class: "actions" }, next()),
  ];
}
