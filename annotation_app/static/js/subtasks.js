// Subtasks: watch an episode, tell which steps it is made of and when each begins, or correct steps that were proposed.
//
// The state is {subtasks: [{start_s, text, of, ok}], removed: [of], ...}: `of` is the number of the proposed step that a
// step was, `ok` whether somebody has accepted it as it is.

import { $, announce, h, isShortcut } from "./dom.js";
import { playerOf, shownFrom, watchToEnd } from "./player.js";
import { subtasksFeedback } from "./practice.js";
import { begin, payload } from "./work.js";
import { showSteps } from "./timeline.js";
import { _, ngettext, number, pieces } from "./speech.js";

const steps = $("steps");
const player = playerOf(document.querySelector(".player"));
const { video } = player;
const proposed = payload.suggestion ?? [];
const vocabulary = payload.vocabulary;
const USUAL_FPS = 25;
const frame = 1 / (payload.fps || USUAL_FPS);
const rounded = (seconds) => Math.round(seconds * 1000) / 1000;
const plain = (text) => text.toLowerCase().split(/\s+/).filter(Boolean).join(" ").replace(/[ .]+$/, "");
const listed = new Set(vocabulary?.steps.map(plain));
const isEmpty = (text) => !/[\p{L}\p{N}]/u.test(text);

const timeline = showSteps({
  duration: payload.duration_s || player.duration || 1,
  frame,
  moved(t, i) {
    video.pause();
    preview(t + frame / 2);
    if (i !== undefined) steps.children[i].querySelector('input[type="number"]').value = t;
  },
  chosen: (i, t) => put(work.state.subtasks.map((step, at) => (at === i ? { ...step, start_s: t } : step))),
});

const work = begin({
  initial: {
    subtasks: proposed.length ? proposed.map((step, of) => ({ ...step, of, ok: false })) : [{ start_s: 0, text: "" }],
    removed: [], played_to_end: false, watched_s: 0,
  },
  draw({ subtasks, removed = [] }) {
    while (steps.children.length > subtasks.length) steps.lastElementChild.remove();
    while (steps.children.length < subtasks.length) steps.append(row());
    const states = subtasks.map(stateOf);
    subtasks.forEach(({ start_s, text, of }, i) => {
      const line = steps.children[i];
      const [start, what] = line.querySelectorAll("input");
      if (Number(start.value) !== start_s) start.value = start_s;
      start.readOnly = i === 0;
      if (what.value !== text) what.value = text;
      line.dataset.state = states[i];
      line.querySelector(".state").textContent = told(subtasks[i], i);
      const accept = line.querySelector(".accept");
      accept.hidden = of === undefined;
      accept.disabled = states[i] === "changed";
      accept.setAttribute("aria-pressed", states[i] === "accepted");
      line.querySelector(".remove").hidden = i === 0 && !proposed.length;
      line.querySelector(".merge").hidden = i === subtasks.length - 1;
    });
    $("gone").replaceChildren(...removed.map((of) => h("li", {},
      h("del", { dir: "auto" }, proposed[of].text), " ",
      h("button", { type: "button", class: "small", onclick: () => restore(of) }, _("Restore")),
    )));
    $("gone-box").hidden = !removed.length;
    $("here").hidden = subtasks.length < 2;
    const open = states.filter((state) => state === "proposed").length;
    $("open").textContent = !proposed.length ? ""
      : open ? ngettext("%(num)s proposed step to decide", "%(num)s proposed steps to decide", open) : _("All proposed steps are decided.");
    timeline.show(subtasks.map((step, i) => ({ ...step, state: states[i] })));
    mark(current(subtasks));
  },
  body: ({ subtasks, removed = [], ...rest }) => ({
    ...rest,
    subtasks: subtasks.map(({ start_s, text }) => ({ start_s, text })),
    decided: [...subtasks.filter((step, i) => step.of !== undefined && stateOf(step, i) !== "proposed").map(({ of }) => of), ...removed],
  }),
  problems({ subtasks, played_to_end }) {
    const found = played_to_end ? [] : [_("Watch the video to its end first.")];
    subtasks.forEach(({ start_s, text }, i) => {
      if (isEmpty(text)) found.push(_("Say what is done in step %(number)s.", { number: i + 1 }));
      else if (vocabulary?.closed && !listed.has(plain(text))) found.push(_("Choose step %(number)s from the list.", { number: i + 1 }));
      if (i && start_s <= subtasks[i - 1].start_s) {
        found.push(_("Step %(number)s must begin after the one before it.", { number: i + 1 }));
      }
    });
    return found;
  },
  doubts({ subtasks }) {
    const open = subtasks.flatMap((step, i) => (stateOf(step, i) === "proposed" ? [i + 1] : []));
    return open.length ? [ngettext(
      "You have not decided about %(num)s proposed step: %(numbers)s. Accept, correct or remove it, if you have looked at it.",
      "You have not decided about %(num)s proposed steps: %(numbers)s. Accept, correct or remove them, if you have looked at them.",
      open.length, { numbers: open.join(", ") })] : [];
  },
  feedback: subtasksFeedback,
});

function stateOf({ of, ok, text, start_s }, i) {
  if (of === undefined) return proposed.length ? "added" : "";
  const from = proposed[of];
  const isMoved = i > 0 && from.start_s > 0 && from.start_s !== start_s;
  return isMoved || from.text !== text ? "changed" : ok ? "accepted" : "proposed";
}

/** A step's state in words, with what was proposed if that was changed. */
function told(step, i) {
  const state = stateOf(step, i);
  if (state !== "changed") return { added: _("added"), accepted: _("accepted"), proposed: _("proposed") }[state] ?? "";
  const { start_s, text } = proposed[step.of];
  return _("changed; proposed was “%(text)s” from %(time)s s", { text, time: number(start_s, 2) });
}

function put(subtasks, removed = work.state.removed ?? [], more = {}) {
  work.change({ ...work.state, subtasks, removed }, more);
}

/** A step's line. It finds its place by itself, as steps before it may go. */
function row() {
  const line = h("li", { class: "subtask" });
  const at = () => [...steps.children].indexOf(line);
  const changed = (part, more) => put(work.state.subtasks.map((s, i) => (i === at() ? { ...s, ...part } : s)), undefined, more);
  line.append(
    h("span", {}, ...pieces(_("from %(time)s s"), { time: h("input", {
      type: "number", min: 0, step: "any", value: 0, "aria-label": _("Begins at, in seconds"),
      onchange: (event) => changed({ start_s: rounded(Number(event.target.value) || 0) }),
    }) })),
    h("button", { type: "button", class: "small", title: _("Show"), "aria-label": _("Show"), onclick: () => show(work.state.subtasks[at()].start_s) }, "▶"),
    h("button", { type: "button", class: "small accept", "aria-pressed": "false", onclick: () => (work.state.subtasks[at()].ok ? changed({ ok: false }) : accept(at())) }, _("Accept")),
    h("button", { type: "button", class: "small remove", onclick: () => remove(at()) }, _("Remove")),
    h("button", { type: "button", class: "small merge", title: _("Merge with the next step"), onclick: () => merge(at()) }, _("Merge")),
    h("input", {
      class: "what", maxlength: 300, dir: "auto", "aria-label": _("What is done"), placeholder: _("What is done from then on"), value: "",
      list: vocabulary ? "known-steps" : null, autocomplete: "off",
      oninput: (event) => changed({ text: event.target.value }, { silent: true }),
      onkeydown: (event) => {
        if (event.key !== "Enter" || event.ctrlKey || event.metaKey || !proposed.length) return;
        event.preventDefault();
        const next = accept(at());
        if (next >= 0) edit(next);
      },
    }),
    h("span", { class: "state quiet", dir: "auto" }),
  );
  return line;
}

/** The step at which the video is. */
function current(subtasks = work.state.subtasks) {
  return Math.max(subtasks.findLastIndex(({ start_s }) => start_s <= video.currentTime + 1e-3), 0);
}

let wanted = null;
/** Show a moment while something is dragged: the latest one, once the one before is there. */
function preview(t) {
  wanted = Math.min(t, player.duration);
  if (!video.seeking) seekWanted();
}
function seekWanted() {
  if (wanted === null) return;
  const t = wanted;
  wanted = null;
  player.seek(t);
}

function show(seconds) {
  player.seek(seconds);
  video.play().catch(() => {}); // an error says so itself
}

/** Go to a step's first frame. */
function go(i) {
  const step = work.state.subtasks[i];
  if (!step) return;
  video.pause();
  player.seek(i ? step.start_s + frame / 2 : 0);
  mark(i);
  announce(_("Step %(number)s: %(text)s", { number: i + 1, text: step.text }));
}

/** Mark a step in the list and on the timeline, and have the list show it. */
function mark(i) {
  timeline.mark(i);
  [...steps.children].forEach((line, at) => {
    if (at !== i) line.removeAttribute("aria-current");
    else if (!line.hasAttribute("aria-current")) {
      line.setAttribute("aria-current", "step");
      if (steps.scrollHeight > steps.clientHeight && !steps.contains(document.activeElement)) {
        steps.scrollTop = line.offsetTop - steps.offsetTop - steps.clientHeight / 3;
      }
    }
  });
}

function add() {
  video.pause();
  const start_s = shownFrom(video, payload.fps);
  const { subtasks } = work.state;
  if (!subtasks.some((step) => step.start_s === start_s)) {
    put([...subtasks, { start_s, text: "" }].sort((a, b) => a.start_s - b.start_s));
  }
  edit(work.state.subtasks.findIndex((step) => step.start_s === start_s));
}

function edit(i) {
  const what = steps.children[i].querySelector(".what");
  what.focus();
  what.select();
}

const isOpen = (step, i) => stateOf(step, i) === "proposed";

/** Accept a step as it is, and go on. */
function accept(i) {
  if (isOpen(work.state.subtasks[i], i)) put(with_(i, { ok: true }));
  announce(_("Accepted"));
  return goOn(i);
}

/** Go to the next step, from one on, that is to be decided, unless the video goes on by itself; give its number. */
function goOn(from) {
  const { subtasks } = work.state;
  const after = subtasks.findIndex((step, i) => i >= from && isOpen(step, i));
  const next = after < 0 ? subtasks.findIndex(isOpen) : after;
  if (next >= 0 && video.paused) go(next);
  return next;
}
const with_ = (i, part) => work.state.subtasks.map((step, at) => (at === i ? { ...step, ...part } : step));

function remove(i) {
  const { subtasks, removed = [] } = work.state;
  const { of } = subtasks[i];
  if (!i && !proposed.length) return;
  let left = subtasks.filter((_step, at) => at !== i);
  if (!left.length) left = [{ start_s: 0, text: "" }];
  put(fromTheStart(left), of === undefined ? removed : [...removed, of].sort((a, b) => a - b));
  announce(_("Removed"));
  if (of !== undefined) goOn(i);
}

/** The first step begins with the video. */
const fromTheStart = ([first, ...others]) => [{ ...first, start_s: 0 }, ...others];

function merge(i) {
  const { subtasks, removed = [] } = work.state;
  const next = subtasks[i + 1];
  if (!next) return;
  const merged = isEmpty(subtasks[i].text) ? { ...subtasks[i], text: next.text } : subtasks[i];
  put(
    [...subtasks.slice(0, i), merged, ...subtasks.slice(i + 2)],
    next.of === undefined ? removed : [...removed, next.of].sort((a, b) => a - b),
  );
  announce(_("Merged with the next step"));
}

/** Put a removed step back where it was proposed, or on the next free frame. */
function restore(of) {
  const { subtasks, removed } = work.state;
  const back = { ...proposed[of], of, ok: false };
  let others = subtasks;
  if (!back.start_s) {
    const [first, ...rest] = subtasks;
    const from = first.of === undefined ? frame : proposed[first.of].start_s || frame;
    others = isEmpty(first.text) && first.of === undefined ? rest : [{ ...first, start_s: rounded(from) }, ...rest];
  }
  while (others.some(({ start_s }) => start_s === back.start_s)) back.start_s = rounded(back.start_s + frame);
  put([...others, back].sort((a, b) => a.start_s - b.start_s), removed.filter((one) => one !== of));
  announce(_("Restored"));
}

/** Have the nearest step begin with the frame that is shown. */
function beginHere() {
  video.pause();
  const t = shownFrom(video, payload.fps);
  const { subtasks } = work.state;
  const far = ({ start_s }) => Math.abs(start_s - t);
  const nearest = subtasks.slice(1).reduce((best, step) => (!best || far(step) < far(best) ? step : best), null);
  if (!nearest || !t || nearest.start_s === t || subtasks.some((step) => step.start_s === t)) return;
  const i = subtasks.indexOf(nearest);
  put(with_(i, { start_s: t }));
  announce(_("Step %(number)s begins here", { number: i + 1 }));
}

const KEYS = {
  n: add,
  b: beginHere,
  m: () => merge(current()),
  a: () => work.state.subtasks[current()].of !== undefined && accept(current()),
  x: () => remove(current()),
  e: () => edit(current()),
  "[": () => go(Math.max(current() - 1, 0)),
  "]": () => go(current() + 1),
  "+": () => timeline.zoomBy(1),
  "=": () => timeline.zoomBy(1),
  "-": () => timeline.zoomBy(-1),
};

if (vocabulary) $("known-steps").append(...vocabulary.steps.map((text) => h("option", { value: text })));
$("timeline").append(timeline.element);
watchToEnd(player, work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }, { silent: true }),
);
video.addEventListener("seeked", seekWanted);
for (const what of ["timeupdate", "seeked"]) {
  video.addEventListener(what, () => {
    $("now").textContent = _("%(time)s s", { time: number(video.currentTime) });
    timeline.at(video.currentTime);
    mark(current());
  });
}
$("add").addEventListener("click", add);
$("add").disabled = false;
$("here").addEventListener("click", beginHere);
document.addEventListener("keydown", (event) => {
  const does = KEYS[event.key.toLowerCase()];
  if (!does || !isShortcut(event)) return;
  event.preventDefault();
  does();
});
