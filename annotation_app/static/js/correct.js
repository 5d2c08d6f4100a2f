// Correct: whether a task is the one that a robot does, and else what it should be.

import { $, announce, isShortcut } from "./dom.js";
import { playerOf, watchToEnd } from "./player.js";
import { correctFeedback } from "./practice.js";
import { begin, payload } from "./work.js";
import { _ } from "./speech.js";

const radios = [...document.querySelectorAll('input[name="verdict"]')];
const text = $("text");
const words = (typed) => (typed.toLowerCase().match(/[\p{L}\p{N}_]+/gu) ?? []).join(" ");
$("command").textContent = payload.command;

const work = begin({
  initial: { verdict: null, text: "", played_to_end: false },
  undoable: false, // the text box has its own
  draw(state) {
    for (const radio of radios) radio.checked = radio.value === state.verdict;
    $("instead").hidden = state.verdict !== "wrong";
    if (text.value !== state.text) text.value = state.text;
  },
  body: ({ verdict, text, watched_s, speed }) => ({ verdict, text: verdict === "wrong" ? text : "", watched_s, speed }),
  problems({ verdict, text, played_to_end }) {
    const found = played_to_end ? [] : [_("Watch the video to its end first.")];
    if (!verdict) found.push(_("Choose whether the task is right."));
    if (verdict === "wrong" && !words(text)) found.push(_("Type what the task should be."));
    else if (verdict === "wrong" && words(text) === words(payload.command)) {
      found.push(_("This is the same task. Change it, or choose “Right”."));
    }
    return found;
  },
  feedback: correctFeedback,
});

/** A wrong task is changed rather than typed anew: often one word is wrong. */
function judge(verdict) {
  const isNew = verdict === "wrong" && !work.state.text;
  work.change({ ...work.state, verdict, ...(isNew && { text: payload.command }) });
}

for (const radio of radios) radio.addEventListener("change", () => judge(radio.value));
document.addEventListener("keydown", (event) => {
  if (!isShortcut(event)) return;
  const radio = radios.find((one) => one.dataset.press === event.key.toUpperCase());
  if (!radio) return;
  event.preventDefault();
  judge(radio.value);
  announce(radio.parentElement.textContent.trim());
  if (radio.value === "wrong") text.focus();
  else radio.focus();
});
text.addEventListener("input", () => work.change({ ...work.state, text: text.value }));
$("verdict").disabled = false;
watchToEnd(playerOf(document.querySelector(".player")), work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }, { silent: true }),
);
