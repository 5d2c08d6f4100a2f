// Segment: give the words of a command their places, and see what belongs to what.

import { $, announce, h, isShortcut, redraw } from "./dom.js";
import { differences, lesson } from "./segment-practice.js";
import {
  ROLES, TOP, addUnsaid, allParts, doubts, hasAction, lineOf, nameOf, nextWord, outline, partWith, placesOf, problems, put, question,
  unsaid,
} from "./outline.js";
import "./player.js";
import { begin, data, payload } from "./work.js";
import * as sdc from "./sdc.js";
import { _, pieces } from "./speech.js";

const { words, suggestion } = payload;
// The command may be written the other way than the page's language.
const isRightToLeft = /^\P{L}*[\p{Script=Arabic}\p{Script=Hebrew}\p{Script=Syriac}\p{Script=Thaana}]/u.test(payload.command);
const right = payload.right && sdc.fromJson(payload.right, words);

const proposal = suggestion ? sdc.fromJson(suggestion, words) : sdc.empty;
const unsure = suggestion?.length ? payload.unsure ?? [] : [];

let chosen = new Set(); // words, not part of the draft
let proposed = null; // a word that was chosen for people; their first press of it doesn't take it away
let focused = 0;
let anchor = 0;
let shown = null;
let changing = null; // the part that people have chosen, to change it
let wrong = []; // words that practice found in wrong places
let shortcuts = []; // the places, by the digits that fill them

const editor = $("editor");
const prompt = h("p", { class: "prompt", id: "prompt" });
const wordBar = h("div", { class: "words", role: "toolbar", dir: isRightToLeft ? "rtl" : "ltr", "aria-label": _("The words of the command"), "aria-describedby": "prompt" });
const notice = suggestion?.length ? suggested() : "";
const tools = h("div", { class: "actions" });
const teacher = h("div", { class: "lesson", hidden: true });
const tree = h("div", { class: "outline-box" });
const change = h("section", { class: "panel change", "aria-label": _("Change a part"), hidden: true });
const buttons = words.map((word, i) =>
  h("button", { type: "button", class: "word", onclick: (event) => press(i, event) }, h("bdi", {}, word.text)),
);
wordBar.append(...buttons);
wordBar.addEventListener("keydown", walk);
editor.append(
  h("section", { class: "panel chooser", "aria-label": _("Choose words") }, notice, prompt, wordBar, tools, teacher),
  h("section", { class: "panel places", "aria-label": _("The parts of the command") }, tree),
  change,
  ...document.querySelectorAll("#film"),
);

showExample();
const work = begin({
  initial: proposal,
  draw,
  body: (state) => ({ sdcs: sdc.toJson(state, words) }),
  // A command of a corpus that is corrected may ask for nothing.
  problems: (state) => (payload.corrects && !state.clauses.length ? [] : problems(state, words)),
  doubts: (state) => (payload.corrects && !state.clauses.length ? [] : questions(state)),
  feedback,
  explain: (state) => (right ? feedback(state).text : ""),
});

/** What the instructions speak of, as it looks when it is done. */
function showExample() {
  if (data.own || $("instructions").querySelector(".told > div")) return $("example").remove(); // the study has its own words
  // Translators: six words of the same kinds in the same order.
  const said = _("Put the cup on the table");
  const spans = [...said.matchAll(/\S+/g)].map(({ 0: word, index }) => [word, index]);
  const [verb, the, cup, on, the2, table] = spans;
  const example = spans.map(([text, start]) => ({ text, start }));
  const state = sdc.fromJson([{
    type: "EVENT",
    r: [verb],
    l: [{ type: "OBJECT", f: [the, cup] }],
    l2: [{ type: "PLACE", r: [on], l: [{ type: "OBJECT", f: [the2, table] }] }],
  }], example);
  $("example").replaceChildren(
    h("div", { class: "outline-box" }, branches(outline(state), (part) => row("span", part, nameOf(part, example)))),
    h("figcaption", { class: "quiet" }, _("“Put the cup on the table”: Put what? The cup. Put where? On. On what? The table.")),
  );
}

/** What is asked before it is sent, with buttons where a press answers it. */
function questions(state) {
  return doubts(state, words, { ...payload, unsure: state.isOwn ? [] : unsure, suggestion: proposal }).map(({ text, label, mend }) =>
    mend ? [text, " ", h("button", { type: "button", class: "small", onclick: () => apply(mend(work.state), label) }, label)] : text,
  );
}

function suggested() {
  const from = payload.corrects
    ? _("The words have places already. Correct what is wrong: choose a word to move it, or %(start)s. If the command asks for nothing, remove all parts and send it.")
    : unsure.length
      ? _("A program has placed the words, and isn't sure of those with dots below. Choose a word to move it, or %(start)s.")
      : _("A program has placed the words. It makes mistakes: choose a word to move it, or %(start)s.");
  return h(
    "p",
    { class: "notice" },
    ...pieces(from, {
      start: h("button", { type: "button", class: "link", onclick: () => apply({ ...sdc.empty, isOwn: true }, _("All parts removed")) }, _("start from nothing")),
    }),
  );
}

function apply(next, said, stillChanging = null) {
  wrong = [];
  changing = stillChanging;
  work.change(next);
  announce(said);
}

function press(i, event) {
  focused = i;
  if (event.shiftKey) range(anchor, i);
  else {
    anchor = i;
    if (i === proposed) proposed = null;
    else if (chosen.has(i)) chosen.delete(i);
    else chosen.add(i);
  }
  draw(work.state);
}

function range(a, b) {
  for (let i = Math.min(a, b); i <= Math.max(a, b); i += 1) chosen.add(i);
}

function walk(event) {
  const ahead = isRightToLeft ? -1 : 1;
  const step = { ArrowRight: ahead, ArrowDown: 1, ArrowLeft: -ahead, ArrowUp: -1 }[event.key];
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

function quoted(numbers) {
  return h("q", {}, h("bdi", {}, phrase(numbers)));
}

/** Fill a place with the chosen words. The next word is chosen then, and has the focus. */
function fill(place, asked) {
  const taken = picked();
  if (!taken.length) return announce(_("Choose words first"));
  apply(put(work.state, place, taken), `${asked} ${phrase(taken)}`);
  if (proposed !== null) buttons[proposed].focus({ preventScroll: true });
}

function leaveOut() {
  const taken = picked();
  const state = sdc.free(work.state, taken);
  const wordless = work.state.clauses.filter((c) => !sdc.wordsOf(work.state, c.id).length).map((c) => c.id);
  apply(sdc.pruned({ ...state, left: [...new Set([...(state.left ?? []), ...taken])] }, wordless), _("Left out: %(words)s", { words: phrase(taken) }));
}

function removeCurrent() {
  const current = sdc.find(work.state, work.state.current);
  if (current) apply(sdc.remove(work.state, current.id), _("Removed"));
}

function pick(id) {
  changing = changing === id ? null : id;
  work.change(sdc.choose(work.state, id), { silent: true });
  announce(phrase(sdc.wordsOf(work.state, id)));
}

document.addEventListener("keydown", (event) => {
  if (!isShortcut(event)) return;
  const key = event.key.toLowerCase();
  const state = work.state;
  if (/^[1-9]$/.test(key)) shortcuts[Number(key) - 1]?.();
  else if (key === "x" && chosen.size) leaveOut();
  else if (key === "delete" || key === "backspace") removeCurrent();
  else if (key === "[" || key === "]") {
    const all = allParts(outline(state)).map((part) => part.id);
    const next = all[(all.indexOf(state.current) + (key === "]" ? 1 : all.length - 1)) % all.length];
    if (next) pick(next);
  } else if (key === "escape") {
    chosen = new Set();
    proposed = null;
    draw(state);
  } else return;
  event.preventDefault();
});

function draw(state) {
  if (shown === null || shown.clauses !== state.clauses || shown.left !== state.left) {
    proposed = hasAction(state) ? nextWord(state, words) : null;
    chosen = new Set(proposed === null ? [] : [proposed]);
    focused = anchor = proposed ?? focused;
  }
  shown = state;
  const taken = picked();
  buttons.forEach((button, i) => {
    const holder = sdc.holder(state, i);
    const isLeft = Boolean(state.left?.includes(i));
    const kind = holder ? ` type-${holder.type}` : isLeft ? " left-out" : "";
    button.className = `word${kind}${wrong.includes(i) ? " wrong" : ""}${unsure.includes(i) ? " unsure" : ""}`;
    button.setAttribute("aria-pressed", chosen.has(i));
    button.tabIndex = i === focused ? 0 : -1;
    const where = wrong.includes(i) ? _("not in its place") : holder ? _("has a place") : isLeft ? _("left out") : "";
    button.setAttribute("aria-label", where ? `${words[i].text}, ${where}` : words[i].text);
  });
  if (notice && !state.clauses.length) notice.hidden = true; // nothing of it is left
  prompt.replaceChildren(...asked(state, taken));
  redraw(tools, ...toolParts(state, taken));
  shortcuts = [];
  redraw(tree, ...treeParts(state, taken));
  change.hidden = changing !== state.current || !sdc.find(state, state.current);
  redraw(change, ...(change.hidden ? [] : changeParts(state)));
}

function asked(state, taken) {
  if (taken.length) {
    const more = !hasAction(state) ? _("If that is all that says what to do, choose “%(place)s”.", { place: topQuestion(state) })
      : taken.length === 1 ? _("Add words that belong with it, or choose its place.") : _("Now choose its place.");
    return [h("b", {}, pieces(_("%(words)s is chosen."), { words: quoted(taken) })), " ", more];
  }
  if (!hasAction(state)) return [h("b", {}, _("Which words say what to do?")), " ", _("Choose them, wherever they stand.")];
  if (nextWord(state, words) !== null) return [h("b", {}, _("Choose words that belong together."))];
  return [h("b", {}, _("Every word has its place.")), " ", _("Read it once more. To move something, choose its words.")];
}

function topQuestion(state) {
  return question("done", "", outline(state).length > 0);
}

/** Have an action without words, for those that are chosen or have no place yet. */
function sayNothing() {
  const before = chosen;
  apply(addUnsaid(work.state), _("No word says it"));
  if (!before.size) return;
  chosen = before;
  draw(work.state);
}

function unsaidButton(name, isNext) {
  return h("button", { type: "button", class: name, "data-key": "unsaid", onclick: sayNothing }, h("bdi", {}, unsaid(isNext)));
}

function toolParts(state, taken) {
  return [
    !taken.length && !hasAction(state) ? unsaidButton("small", false) : null,
    taken.length ? h("button", { type: "button", class: "small", "data-key": "leave", onclick: leaveOut }, _("Leave it out"), " ", h("kbd", { "aria-hidden": "true" }, "X")) : null,
    right && teacher.hidden ? h("button", { type: "button", class: "small", "data-key": "show", onclick: teach }, _("Show me how")) : null,
  ].filter(Boolean);
}

function treeParts(state, taken) {
  const parts = outline(state);
  const isMoving = taken.some((word) => sdc.holder(state, word));
  const own = partWith(state, taken);
  const moving = own ? [own, ...allParts(own.parts)].map((part) => part.id) : [];
  const everywhere = allParts(parts).map((part) => part.id).filter((id) => !moving.includes(id));
  const line = !taken.length ? [] : isMoving ? everywhere : lineOf(state, state.current);
  const current = (part) => part.id === state.current;
  const isThing = payload.things?.includes(taken[0]); // which no clause begins with
  const fits = ({ role }) => !isThing || !["when", "happens"].includes(role);
  const places = (part) => (line.includes(part.id) ? placesOf(part, taken, current(part)).filter(fits) : []);
  const made = branches(
    parts,
    (part) => row("button", part, nameOf(part, words), {
      type: "button", "aria-current": current(part) ? "true" : null, "data-key": `part ${part.id}`,
      class: wrong.length && part.words.some((word) => wrong.includes(word)) ? "wrong" : "",
      onclick: () => pick(part.id),
    }),
    (part) => placeBar(places(part), nameOf(part, words)),
  );
  const top = taken.length ? placeBar([{ ...TOP, isFilled: parts.length > 0 }], "") : null;
  if (top && hasAction(state)) top.append(unsaidButton("place filled", true));
  return [made, top, parts.length || top ? null : h("p", { class: "quiet" }, _("Nothing has a place yet."))];
}

/** Parts as a list with what belongs to each below it. */
function branches(parts, rowOf, placesBelow = () => null) {
  if (!parts.length) return null;
  return h("ul", { class: "outline" }, parts.map((part) =>
    h("li", {}, rowOf(part), branches(part.parts, rowOf, placesBelow), placesBelow(part)),
  ));
}

function row(tag, part, said, more = {}) {
  return h(
    tag,
    { ...more, class: `part type-${part.type} ${more.class ?? ""}` },
    h("bdi", { class: part.words.length ? null : "unsaid" }, said), " ", h("small", {}, ROLES[part.role]),
  );
}

function placeBar(places, said) {
  if (!places.length) return null;
  return h("div", { class: "place-bar" }, places.map((place) => {
    const label = question(place.role, said, place.isFilled);
    const act = () => fill(place, label);
    shortcuts.push(act);
    const digit = shortcuts.length <= 9 ? h("kbd", { "aria-hidden": "true" }, shortcuts.length) : null;
    const isQuiet = place.isFilled || place.role === "more" ? " filled" : "";
    return h(
      "button",
      { type: "button", class: `place role-${place.role}${isQuiet}`, "data-key": place.key, onclick: act },
      digit, h("bdi", {}, label),
      place.example && !place.isFilled ? h("small", { "aria-hidden": "true" }, place.example) : null,
    );
  }));
}

function changeParts(state) {
  const current = sdc.find(state, state.current);
  const own = sdc.subtree(state, current.id);
  const others = allParts(outline(state)).filter((part) => !own.includes(part.id));
  const kinds = [["EVENT", ROLES.done], ["OBJECT", _("a thing or person")], ["PLACE", ROLES.where], ["PATH", ROLES.way]];
  const kind = select("type", kinds, current.type, (value) => apply(sdc.retype(work.state, current.id, value), _("Changed"), current.id));
  const above = select(
    "inside",
    [["", _("nothing")], ...others.map((part) => [part.id, nameOf(part, words)])],
    current.parent ?? "",
    (value) => apply(sdc.move(work.state, current.id, value ? Number(value) : null, current.field ?? "l"), _("Moved"), current.id),
  );
  const fields = [["f", _("who or what it is about")], ["l", _("first")], ["l2", _("second")]];
  const as = select("as", fields, current.field ?? "l", (value) => apply(sdc.move(work.state, current.id, current.parent, value), _("Moved"), current.id));
  as.disabled = current.parent === null;
  const own_ = sdc.ownWords(current);
  return [
    h("h2", {}, pieces(_("Change %(words)s"), { words: quoted(own_.length ? own_ : sdc.wordsOf(state, current.id)) })),
    h("div", { class: "grid" }, h("label", {}, _("It says"), kind), h("label", {}, _("It belongs to"), above), h("label", {}, _("There it comes"), as)),
    h("div", { class: "actions" }, h("button", { type: "button", class: "small", "data-key": "remove", onclick: removeCurrent }, _("Remove it from here"))),
  ];
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

function feedback(state) {
  const found = differences(state, right, words);
  wrong = found.words;
  draw(work.state);
  return found;
}

/** Do the example step by step: what is chosen, then where it goes. */
function teach() {
  const steps = lesson(right, words);
  let at = 0;
  apply(sdc.empty, _("Everything starts from nothing"));
  const tell = () => {
    teacher.hidden = false;
    if (at === steps.length) {
      const own = h("button", { type: "button", class: "primary", onclick: end }, _("Now you"));
      teacher.replaceChildren(h("p", {}, _("That is all. Now it is your turn: it starts from nothing.")), own);
      own.focus();
      return;
    }
    const { taken, place, said } = steps[at];
    chosen = new Set(taken);
    proposed = null;
    draw(work.state);
    editor.querySelector(`[data-key="${CSS.escape(place(work.state)?.key ?? "unsaid")}"]`)?.classList.add("pointed");
    const next = h("button", { type: "button", class: "primary", onclick: go }, _("Do it"));
    teacher.replaceChildren(h("p", {}, h("b", {}, _("Step %(number)s of %(count)s.", { number: at + 1, count: steps.length })), " ", said), h("div", { class: "actions" }, next, h("button", { type: "button", onclick: end }, _("Stop"))));
    next.focus({ preventScroll: true });
    announce(said);
  };
  const go = () => {
    const { act, said } = steps[at];
    apply(act(work.state), said);
    at += 1;
    tell();
  };
  const end = () => {
    teacher.hidden = true;
    apply(sdc.empty, _("It starts from nothing"));
    buttons[0].focus();
  };
  tell();
}
