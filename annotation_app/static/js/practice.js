// What people are told about their answers to the practice examples, which are about a boat.

import { data } from "./work.js";
import { _ } from "./speech.js";

const answer = (good, text) => ({ good, text });

/** What the study's file says to an answer to a practice item of its own: no verdict where nothing is judged. */
export function ownFeedback({ rating }) {
  if (rating === undefined) return { text: _("Compare yours: %(examples)s", { examples: data.own.good }) };
  const isRight = data.own.right.includes(rating);
  return answer(isRight, isRight ? data.own.good : data.own.again);
}

/** No pattern can tell a good command from a bad one: people compare theirs with some. */
export function describeFeedback() {
  return {
    text: _("Compare yours with some that would do: “Sail over to the buoy next to the lighthouse.” “The buoy that is by the lighthouse: go there.” “Head for the lighthouse and stop at its buoy.” All say what is to be done, and to which buoy. Yours may be quite different."),
  };
}

export function subtasksFeedback() {
  return {
    text: _("Compare yours with some that would do: “Sail over to the buoy” from 0 s is enough. “Wait” from 0 s and “Sail to the buoy” from about 0.5 s would do, too. Each says what is done, and from when on."),
  };
}

export function groundFeedback({ groundings }) {
  const chosen = (node) => [...(groundings[node]?.objects ?? [])].sort().join();
  const wrong = Object.entries({ 3: "thing-c", 4: "thing-c", 5: "thing-d" }).find(([node, id]) => chosen(node) !== id);
  if (!wrong) return answer(true, _("The boat sails to the buoy that is by the lighthouse."));
  if (wrong[0] === "5") return answer(false, _("“the lighthouse” is the tower on the small island."));
  return answer(false, _("Play the video: to which buoy does the boat sail? Choose that one, and no other."));
}

export function checkFeedback({ verdicts }) {
  if (verdicts[4] !== true) return answer(false, _("“the buoy” alone could mean any buoy, so what is marked matches."));
  if (verdicts[5] !== false) return answer(false, _("Nobody would call what is marked “the lighthouse”."));
  return answer(true, _("Look at nothing but the words of the clause: that is right."));
}

export function rateFeedback({ rating }) {
  if (rating >= 4) return answer(true, _("The boat does sail to the buoy by the lighthouse."));
  return answer(false, _("Watch again: the boat sails to the buoy by the lighthouse. Most people would agree."));
}
