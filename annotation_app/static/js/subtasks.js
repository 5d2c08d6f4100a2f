// Subtasks: watch an episode, tell which steps it is made of and when each begins.

import { $, announce, h, isShortcut } from "./dom.js";
import { playerOf, watchToEnd } from "./player.js";
import { subtasksFeedback } from "./practice.js";
import { begin, payload } from "./work.js";
import { _, number, pieces } from "./speech.js";

const steps = $("steps");
const player = playerOf(document.querySelector(".player"));
const { video } = player;

const work = begin({
  initial: { subtasks: [{ start_s: 0, text: "" }], played_to_end: false, watched_s: 0 },
  draw({ subtasks }) {
    while (steps.children.length > subtasks.length) steps.lastElementChild.remove();
    while (steps.children.length < subtasks.length) steps.append(row(steps.children.length));
    subtasks.forEach(({ start_s, text }, i) => {
      const [start, what] = steps.children[i].querySelectorAll("input");
      if (Number(start.value) !== start_s) start.value = start_s;
      if (what.value !== text) what.value = text;
    });
  },
  body: (state) => state,
  problems({ subtasks, played_to_end }) {
    const found = played_to_end ? [] : [_("Watch the video to its end first.")];
    subtasks.forEach(({ start_s, text }, i) => {
      if (!/[\p{L}\p{N}]/u.test(text)) found.push(_("Say what is done in step %(number)s.", { number: i + 1 }));
      if (i && start_s <= subtasks[i - 1].start_s) {
        found.push(_("Step %(number)s must begin after the one before it.", { number: i + 1 }));
      }
    });
    return found;
  },
  feedback: subtasksFeedback,
});

/** A step's line. It finds its place by itself, as steps before it may go. */
function row(number) {
  const line = h("li", { class: "subtask" });
  const at = () => [...steps.children].indexOf(line);
  const changed = (part, more) =>
    work.change(
      { ...work.state, subtasks: work.state.subtasks.map((s, i) => (i === at() ? { ...s, ...part } : s)) },
      more,
    );
  line.append(
    h("span", {}, ...pieces(_("from %(time)s s"), { time: h("input", {
      type: "number", min: 0, step: "any", value: 0, readonly: number === 0, "aria-label": _("Begins at, in seconds"),
      onchange: (event) => changed({ start_s: rounded(Number(event.target.value) || 0) }),
    }) })),
    h("button", { type: "button", onclick: () => show(work.state.subtasks[at()].start_s) }, _("Show")),
  );
  if (number) {
    line.append(h("button", { type: "button", onclick: () => {
      const gone = at();
      work.change({ ...work.state, subtasks: work.state.subtasks.filter((_, i) => i !== gone) });
      announce(_("Removed"));
    } }, _("Remove")));
  }
  line.append(
    h("input", {
      class: "what", maxlength: 300, dir: "auto", "aria-label": _("What is done"), placeholder: _("What is done from then on"), value: "",
      oninput: (event) => changed({ text: event.target.value }, { silent: true }),
    }),
  );
  return line;
}

/** When the frame begins that is shown. */
function shownFrom() {
  const { fps } = payload;
  return rounded(fps ? Math.floor(video.currentTime * fps + 1e-3) / fps : video.currentTime);
}

const rounded = (seconds) => Math.round(seconds * 1000) / 1000;

function show(seconds) {
  player.seek(seconds);
  video.play().catch(() => {}); // an error says so itself
}

function add() {
  video.pause();
  const start_s = shownFrom();
  const subtasks = [...work.state.subtasks, { start_s, text: "" }].sort((a, b) => a.start_s - b.start_s);
  work.change({ ...work.state, subtasks });
  const place = subtasks.findLastIndex((s) => s.start_s === start_s && !s.text);
  steps.children[place]?.querySelector(".what").focus();
}

watchToEnd(player, work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }, { silent: true }),
);
video.addEventListener("timeupdate", () => ($("now").textContent = _("%(time)s s", { time: number(video.currentTime) })));
$("add").addEventListener("click", add);
$("add").disabled = false;
document.addEventListener("keydown", (event) => {
  if (event.key.toLowerCase() !== "n" || !isShortcut(event)) return;
  event.preventDefault();
  add();
});
