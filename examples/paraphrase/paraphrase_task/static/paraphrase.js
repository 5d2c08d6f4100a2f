// Paraphrase: say a command in other words.

import { $ } from "/static/js/dom.js";
import { showVideo } from "/static/js/player.js";
import { begin, payload } from "/static/js/work.js";

const text = $("text");
const words = (line) => line.toLowerCase().replace(/[.,;:!?]/g, "").trim().split(/\s+/).join(" ");
$("command").textContent = payload.command;

const work = begin({
  initial: { text: "", played_to_end: false },
  undoable: false, // the text box has its own
  draw(state) {
    if (text.value !== state.text) text.value = state.text;
  },
  body: (state) => state,
  problems(state) {
    const found = [];
    if (!state.played_to_end) found.push("Watch the video to its end first.");
    if (!/[\p{L}\p{N}]/u.test(state.text)) found.push("Type the command in other words.");
    else if (words(state.text) === words(payload.command)) {
      found.push("These are the same words. Use others.");
    }
    return found;
  },
  feedback: () => ({ good: true, text: "Others wrote: “Go over to the buoy next to the lighthouse.”" }),
});

text.addEventListener("input", () => work.change({ ...work.state, text: text.value }));
showVideo($("player"), payload, work.state.played_to_end, () =>
  work.change({ ...work.state, played_to_end: true }, { silent: true }),
);
