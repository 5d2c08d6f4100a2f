// Describe: watch a video, type the command.

import { $ } from "./dom.js";
import { describeFeedback, ownFeedback } from "./practice.js";
import { showVideo } from "./player.js";
import { begin, data, payload } from "./work.js";

const text = $("text");

const work = begin({
  initial: { text: "", played_to_end: false, watched_s: 0 },
  undoable: false, // the text box has its own
  draw(state) {
    if (text.value !== state.text) text.value = state.text;
    const words = state.text.trim() ? state.text.trim().split(/\s+/).length : 0;
    $("counter").textContent = `${words} ${words === 1 ? "word" : "words"}`;
  },
  body: (state) => state,
  problems(state) {
    const found = [];
    if (!state.played_to_end) found.push("Watch the video to its end first.");
    if (!/[\p{L}\p{N}]/u.test(state.text)) {
      found.push("Type what you would tell the operator to do.");
    }
    return found;
  },
  feedback: data.own ? ownFeedback : describeFeedback,
});

text.addEventListener("input", () => work.change({ ...work.state, text: text.value }));
showVideo($("player"), payload, work.state.played_to_end, (watched_s) =>
  work.change({ ...work.state, played_to_end: true, watched_s }),
);
