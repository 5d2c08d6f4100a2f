// Describe: watch a video, type the command.

import { $ } from "./dom.js";
import { describeFeedback } from "./practice.js";
import { playerOf, watchToEnd } from "./player.js";
import { begin } from "./work.js";
import { _, ngettext } from "./speech.js";

const text = $("text");
const MOST_WORDS = Number(text.dataset.mostWords);
const typed = text.value; // before this script had come
const countOf = (typed) => (typed.trim() ? typed.trim().split(/\s+/).length : 0);

const work = begin({
  initial: { text: "", played_to_end: false, watched_s: 0 },
  undoable: false, // the text box has its own
  draw(state) {
    if (text.value !== state.text) text.value = state.text;
    const words = countOf(state.text);
    $("counter").textContent = ngettext("%(num)s of at most %(most)s words", "%(num)s of at most %(most)s words", words, { most: MOST_WORDS });
    $("counter").classList.toggle("problem", words > MOST_WORDS);
  },
  body: (state) => state,
  problems(state) {
    const found = [];
    if (!state.played_to_end) found.push(_("Watch the video to its end first."));
    if (!/[\p{L}\p{N}]/u.test(state.text)) {
      found.push(_("Type a command."));
    }
    if (countOf(state.text) > MOST_WORDS) found.push(_("Use at most %(most)s words for the command.", { most: MOST_WORDS }));
    return found;
  },
  feedback: describeFeedback,
});

text.addEventListener("input", () => work.change({ ...work.state, text: text.value }));
if (typed) work.change({ ...work.state, text: [work.state.text, typed].filter(Boolean).join(" ") });
watchToEnd(playerOf(document.querySelector(".player")), work.state.played_to_end, (watched) =>
  work.change({ ...work.state, played_to_end: true, ...watched }),
);
