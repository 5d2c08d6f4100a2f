// Rate: how well a command fits a video.

import { $, announce, isShortcut } from "./dom.js";
import { playerOf, watchToEnd } from "./player.js";
import { rateFeedback } from "./practice.js";
import { begin, payload } from "./work.js";
import { _ } from "./speech.js";

const radios = [...document.querySelectorAll('input[name="rating"]')];
$("command").textContent = payload.command;

const work = begin({
  initial: { rating: null, played_to_end: false },
  undoable: false,
  draw(state) {
    for (const radio of radios) radio.checked = Number(radio.value) === state.rating;
  },
  body: ({ rating, watched_s, speed }) => ({ rating, watched_s, speed }),
  problems(state) {
    const found = [];
    if (!state.played_to_end) found.push(_("Watch the video to its end first."));
    if (!state.rating) found.push(_("Choose how much you agree."));
    return found;
  },
  feedback: rateFeedback,
});

const rate = (rating) => work.change({ ...work.state, rating });
for (const radio of radios) radio.addEventListener("change", () => rate(Number(radio.value)));
document.addEventListener("keydown", (event) => {
  if (!isShortcut(event)) return;
  const radio = radios[Number(event.key) - 1];
  if (!radio) return;
  event.preventDefault();
  rate(Number(radio.value));
  radio.focus();
  announce(radio.parentElement.textContent.trim());
});
$("likert").disabled = false;
watchToEnd(playerOf(document.querySelector(".player")), work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }, { silent: true }),
);
