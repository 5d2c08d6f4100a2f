// Mark: whether a robot did its task, how well, and what went wrong.

import { $, announce, isShortcut } from "./dom.js";
import { playerOf, shownFrom, watchToEnd } from "./player.js";
import { markFeedback } from "./practice.js";
import { begin, payload } from "./work.js";
import { _, number } from "./speech.js";

const inputs = [...document.querySelectorAll("input[data-press]")];
const reasons = inputs.filter((input) => input.name === "reason");
const note = $("note-of-marks");
const typed = note.value; // before this script had come
const player = playerOf(document.querySelector(".player"));
const { video } = player;

const work = begin({
  initial: { success: null, quality: null, reasons: [], moment_s: null, note: "", played_to_end: false },
  draw(state) {
    for (const input of inputs) {
      input.checked = input.name === "reason" ? state.reasons.includes(input.value) : String(state[input.name]) === input.value;
    }
    $("moment-set").hidden = state.moment_s === null;
    if (state.moment_s !== null) $("show").textContent = _("Show %(time)s s", { time: number(state.moment_s) });
    if (note.value !== state.note) note.value = state.note;
  },
  body: ({ success, quality, reasons, moment_s, note, watched_s, speed }) => ({ success, quality, reasons, moment_s, note, watched_s, speed }),
  problems({ success, quality, played_to_end }) {
    const found = played_to_end ? [] : [_("Watch the video to its end first.")];
    if (!success) found.push(_("Choose whether the robot did its task."));
    if (!quality) found.push(_("Choose how well it did it, from 1 to 5."));
    return found;
  },
  doubts: ({ success, reasons: chosen, note }) =>
    success !== "success" && !chosen.length && !note.trim() && reasons.length
      ? [_("You haven’t told what went wrong. If no reason fits, write a note.")]
      : [],
  feedback: markFeedback,
});

function choose(input) {
  const { state } = work;
  if (input.name === "quality") work.change({ ...state, quality: Number(input.value) });
  else if (input.name === "success") work.change({ ...state, success: input.value });
  else {
    const chosen = reasons.filter((one) => (one === input) !== state.reasons.includes(one.value));
    work.change({ ...state, reasons: chosen.map((one) => one.value) });
  }
}

/** It fails at the beginning of the frame that is shown. */
function failsHere() {
  video.pause();
  const moment_s = shownFrom(video, payload.fps);
  work.change({ ...work.state, moment_s });
  announce(_("It fails at %(time)s s", { time: number(moment_s) }));
}

for (const input of inputs) input.addEventListener("change", () => choose(input));
document.addEventListener("keydown", (event) => {
  if (!isShortcut(event)) return;
  const key = event.key.toUpperCase();
  const input = inputs.find((one) => one.dataset.press === key);
  if (key === "M") failsHere();
  else if (input) {
    choose(input);
    input.focus();
    announce(input.parentElement.textContent.trim());
  } else return;
  event.preventDefault();
});
$("moment").addEventListener("click", failsHere);
$("show").addEventListener("click", () => player.seek(work.state.moment_s));
$("remove").addEventListener("click", () => {
  work.change({ ...work.state, moment_s: null });
  $("moment").focus();
  announce(_("Removed"));
});
note.addEventListener("input", () => work.change({ ...work.state, note: note.value }, { silent: true }));
if (typed) work.change({ ...work.state, note: [work.state.note, typed].filter(Boolean).join(" ") }, { silent: true });
for (const id of ["success", "quality", "reasons", "moment"]) if ($(id)) $(id).disabled = false;
watchToEnd(player, work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }, { silent: true }),
);
