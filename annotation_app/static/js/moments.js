// Moments: watch an episode, write texts at moments of it, and draw in the picture what they are about.

import { $, announce, h, isShortcut } from "./dom.js";
import { drawing } from "./drawing.js";
import { playerOf, shownFrom, watchToEnd } from "./player.js";
import { momentsFeedback } from "./practice.js";
import { begin, payload } from "./work.js";
import { _, number, pieces } from "./speech.js";

/** The kinds of answers to a question: their texts, and what is drawn. */
const ANSWERS = {
  words: { label: _("in words"), texts: [_("Answer")] },
  point: { label: _("by a point"), texts: [_("What is there")], shape: "point", most: 1 },
  boxes: { label: _("by boxes"), texts: [], shape: "box", most: 50 },
  count: { label: _("by a number"), texts: [_("What is counted"), _("How many")] },
  attribute: { label: _("by a property"), texts: [_("Of what"), _("Property, such as colour"), _("Its value")] },
  spatial: { label: _("by where it is"), texts: [_("What"), _("Where, such as left of"), _("Of what")] },
  path: { texts: [], shape: "line", most: 1 },
};
const TEXTS = {
  interjection: _("What a person says"),
  vqa: _("Question"),
  trace: _("What goes along it"),
  memory: _("What was done so far"),
  motion: _("How it moves"),
  plan: _("What is left to do"),
};
const LONG = ["plan", "memory"];

const list = $("moments");
const kinds = [...document.querySelectorAll("#kinds button")];
const titles = Object.fromEntries(kinds.map((button) => [button.dataset.style, button.querySelector("span").textContent]));
const player = playerOf(document.querySelector(".player"));
const { video } = player;
const rows = new Map(); // by the ids of moments
let drawn = null; // what is being drawn on: {id, surface}

const work = begin({
  initial: { moments: [], played_to_end: false, watched_s: 0 },
  draw({ moments }) {
    for (const [id, row] of rows) {
      if (moments.some((moment) => moment.id === id)) continue;
      row.element.remove();
      rows.delete(id);
    }
    moments.forEach((moment, place) => {
      if (!rows.has(moment.id)) rows.set(moment.id, rowOf(moment));
      const row = rows.get(moment.id);
      if (list.children[place] !== row.element) list.insertBefore(row.element, list.children[place] ?? null);
      row.show(moment, place + 1);
    });
    if (drawn) follow(moments.find(({ id }) => id === drawn.id));
  },
  body: ({ moments, ...watched }) => ({ ...watched, moments: moments.map(sent) }),
  problems({ moments, played_to_end }) {
    const found = played_to_end ? [] : [_("Watch the video to its end first.")];
    if (!moments.length) found.push(_("Write at least one text."));
    moments.forEach((moment, i) => {
      const values = { number: i + 1 };
      const { texts, shape } = ANSWERS[moment.kind] ?? { texts: [] };
      if (!isSaid(moment.text)) found.push(_("Type a text at number %(number)s.", values));
      else if (!texts.every((_label, n) => isSaid(moment.texts[n]))) found.push(_("Answer the question at number %(number)s.", values));
      else if (moment.kind === "count" && !/^\d{1,9}$/.test(moment.texts[1].trim())) found.push(_("Type how many as a whole number at number %(number)s.", values));
      else if (shape && !moment.shapes.length) found.push(_("Draw in the picture at number %(number)s.", values));
      else if (shape === "box" && !moment.shapes.every(({ name }) => isSaid(name))) found.push(_("Name each box at number %(number)s.", values));
    });
    return found;
  },
  feedback: momentsFeedback,
});

const isSaid = (text) => /[\p{L}\p{N}]/u.test(text ?? "");
const rounded = (seconds) => Math.round(seconds * 1000) / 1000;
const find = (id) => work.state.moments.find((moment) => moment.id === id);
const inOrder = (moments) => moments.toSorted((a, b) => a.time_s - b.time_s);

/** A moment as the server takes it. */
function sent({ style, time_s, text, reply, kind, texts, shapes }) {
  const moment = { style, time_s, text };
  if (style === "interjection") return { ...moment, reply };
  if (!kind) return moment;
  const of = ANSWERS[kind];
  return { ...moment, answer: {
    kind,
    texts: of.texts.map((_label, n) => texts[n].trim()),
    shapes: of.shape ? shapes.map(({ points, name }) => ({ points, label: name })) : [],
  } };
}

function change(id, part, more) {
  const moments = work.state.moments.map((moment) => (moment.id === id ? { ...moment, ...part } : moment));
  work.change({ ...work.state, moments: "time_s" in part ? inOrder(moments) : moments }, more);
}

/** A moment's line: `show(moment, place)` has it say what the moment is now. */
function rowOf({ id, style }) {
  const typed = (part) => change(id, part, { silent: true });
  const inputOf = (label, more = {}) => h(more.rows ? "textarea" : "input", { class: "what", maxlength: 500, dir: "auto", autocomplete: "off", "aria-label": label, placeholder: label, ...more });
  const put = (input, value) => { if (input.value !== value) input.value = value; };
  const title = h("h3", {});
  const time = h("input", {
    type: "number", min: 0, step: "any", "aria-label": _("At, in seconds"),
    onchange: () => change(id, { time_s: rounded(Math.max(Number(time.value) || 0, 0)) }),
  });
  const text = inputOf(TEXTS[style], { ...(LONG.includes(style) && { rows: 3 }), oninput: () => typed({ text: text.value }) });
  const reply = inputOf(_("What the robot answers, if anything"), { oninput: () => typed({ reply: reply.value }) });
  const kind = h(
    "select",
    { "aria-label": _("How it is answered"), onchange: () => { change(id, { kind: kind.value, shapes: [] }); if (ANSWERS[kind.value].shape) open(id); else if (drawn?.id === id) close(); } },
    Object.entries(ANSWERS).filter(([, { label }]) => label).map(([value, { label }]) => h("option", { value }, label)),
  );
  const drawButton = h("button", { type: "button", onclick: () => (drawn?.id === id ? close() : open(id)) });
  const parts = h("div", { class: "parts" });
  let shown = ""; // which inputs there are
  const element = h(
    "li", { class: "moment" },
    h("div", { class: "row" }, title, h("span", {}, ...pieces(_("at %(time)s s"), { time })),
      h("button", { type: "button", onclick: () => (find(id).shapes.length ? open(id) : go(find(id).time_s)) }, _("Show")),
      h("button", { type: "button", onclick: () => remove(id) }, _("Remove"))),
    text,
    style === "interjection" && reply,
    style === "vqa" && h("label", { class: "row" }, h("span", {}, _("It is answered")), kind),
    parts,
  );

  function show(moment, place) {
    title.textContent = `${place}. ${titles[style] ?? style}`;
    element.setAttribute("aria-label", title.textContent);
    if (Number(time.value) !== moment.time_s || time.value === "") time.value = moment.time_s;
    put(text, moment.text);
    put(reply, moment.reply);
    const of = ANSWERS[moment.kind];
    if (!of) return;
    put(kind, moment.kind);
    const names = of.shape === "box" ? moment.shapes.map((_shape, n) => _("Name of box %(number)s", { number: n + 1 })) : of.texts;
    const wanted = `${moment.kind} ${names.length}`;
    if (shown !== wanted) {
      shown = wanted;
      parts.replaceChildren(...(of.shape ? [drawButton] : []), ...names.map((label, n) => {
        const input = inputOf(null, { oninput: () => typed(of.shape === "box"
          ? { shapes: find(id).shapes.map((shape, m) => (m === n ? { ...shape, name: input.value } : shape)) }
          : { texts: [0, 1, 2].map((m) => (m === n ? input.value : find(id).texts[m])) }) });
        return h("label", { class: "row" }, h("span", {}, label), input);
      }));
    }
    [...parts.querySelectorAll("input")].forEach((input, n) => put(input, of.shape === "box" ? moment.shapes[n].name : moment.texts[n]));
    drawButton.textContent = drawn?.id === id ? _("End drawing") : moment.shapes.length ? _("Change the drawing") : _("Draw in the picture");
  }
  return { element, show, text };
}

/** Stop at the middle of a moment's frame, which is shown without doubt. */
function go(time_s) {
  video.pause();
  const { fps } = payload;
  player.seek(fps ? (Math.floor(time_s * fps + 1e-3) + 0.5) / fps : time_s);
}

function add(style) {
  if (!(style in titles)) return;
  video.pause();
  const kind = { vqa: "words", trace: "path" }[style] ?? "";
  const id = crypto.getRandomValues(new Uint32Array(1))[0];
  const moment = { id, style, time_s: shownFrom(video, payload.fps), text: "", reply: "", kind, texts: ["", "", ""], shapes: [] };
  work.change({ ...work.state, moments: inOrder([...work.state.moments, moment]) });
  if (kind === "path") open(id);
  rows.get(id).text.focus();
}

function remove(id) {
  work.change({ ...work.state, moments: work.state.moments.filter((moment) => moment.id !== id) });
  announce(_("Removed"));
}

/** Draw on the picture of a moment. */
function open(id) {
  close();
  const moment = find(id);
  const { shape, most } = ANSWERS[moment.kind];
  go(moment.time_s);
  const surface = drawing({
    width: video.videoWidth,
    height: video.videoHeight,
    label: _("The picture, to draw in"),
    kinds: [shape],
    most,
    shapes: moment.shapes,
    changed: (shapes) => change(id, { shapes }),
    named: (of) => {
      const at = find(id).shapes.findIndex((one) => one.id === of);
      rows.get(id).element.querySelectorAll(".parts input")[shape === "box" ? at : 0]?.focus();
    },
  });
  drawn = { id, surface };
  video.closest(".screen").append(surface.element);
  surface.tools.append(h("button", { type: "button", onclick: close }, _("End drawing")));
  $("drawing-tools").replaceChildren(surface.tools, surface.help);
  $("drawing-tools").hidden = false;
  surface.use(shape);
  showLine(id);
}

function close() {
  if (!drawn) return;
  const { id, surface } = drawn;
  drawn = null;
  const hadFocus = surface.element.contains(document.activeElement) || $("drawing-tools").contains(document.activeElement);
  surface.element.remove();
  $("drawing-tools").hidden = true;
  showLine(id);
  if (hadFocus) rows.get(id)?.text.focus();
}

/** Have a line say whether its moment is being drawn on. */
function showLine(id) {
  const place = work.state.moments.findIndex((moment) => moment.id === id);
  if (place >= 0) rows.get(id)?.show(work.state.moments[place], place + 1);
}

/** Have the surface show what its moment has, also after undo; without the moment there is none. */
function follow(moment) {
  if (!moment || !ANSWERS[moment.kind]?.shape) close();
  else if (JSON.stringify(drawn.surface.shapes) !== JSON.stringify(moment.shapes)) drawn.surface.put(moment.shapes);
}

watchToEnd(player, work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }, { silent: true }),
);
video.addEventListener("timeupdate", () => ($("now").textContent = _("%(time)s s", { time: number(video.currentTime) })));
video.addEventListener("play", close);
kinds.forEach((button) => {
  button.addEventListener("click", () => add(button.dataset.style));
  button.disabled = false;
});
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && drawn && !event.defaultPrevented) return close();
  const button = kinds[Number(event.key) - 1];
  if (!button || !isShortcut(event)) return;
  event.preventDefault();
  add(button.dataset.style);
});
