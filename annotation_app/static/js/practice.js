// What people are told about their answers to practice items: the study's own, and the app's, which
// are about a boat.

import { _ } from "./speech.js";

const answer = (good, text) => ({ good, text });

/**
 * What a study says to an answer to a practice item of its own. There is a verdict only where the
 * answer is like one that was kept as right or wrong, or has another form of right: a rating, or
 * parts that `explain` can compare with those of the right answer.
 */
export function ownFeedback(own, body, explain) {
  if (body.rating !== undefined) {
    const isRight = own.right.includes(body.rating);
    return answer(isRight, isRight ? own.good : own.again);
  }
  const wrong = own.wrong.find((one) => essence(one.answer) === essence(body));
  if (wrong) return answer(false, wrong.why);
  if (own.answer && essence(own.answer) === essence(body)) return answer(true, own.good);
  if (own.answer && explain) return answer(false, explain(own.answer) || own.again);
  return { text: _("Compare yours: %(examples)s", { examples: own.good }) };
}

/** What like answers share: no times, no capitals, no order of what was chosen. */
function essence(body) {
  const plain = (text) => text.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, " ").trim();
  if (body.success) return body.success;
  if (body.verdict) return `${body.verdict} ${plain(body.text ?? "")}`;
  if (body.text !== undefined) return plain(body.text);
  if (body.subtasks) return body.subtasks.map(({ text }) => plain(text)).join("; ");
  if (body.moments) return body.moments.map(({ style, text }) => `${style} ${plain(text)}`).sort().join("; ");
  if (body.groundings) {
    return JSON.stringify(Object.entries(body.groundings).map(([node, one]) => [node, chosen(one)]).sort());
  }
  return JSON.stringify(sorted(body.verdicts ?? body.sdcs));
}

/** The same value with its fields in order, however it was written. */
function sorted(value) {
  if (Array.isArray(value)) return value.map(sorted);
  return value instanceof Object ? Object.entries(value).sort().map(([name, inner]) => [name, sorted(inner)]) : value;
}

const chosen = ({ objects, places, cant_tell }) => [[...objects].sort(), places, Boolean(cant_tell)];

/** The clauses of which an answer says something else than the right one. */
export function different(clauses, one, other) {
  const said = (body, node) => JSON.stringify(body.groundings?.[node] ? chosen(body.groundings[node]) : body.verdicts?.[node]);
  const found = clauses.filter(({ node }) => said(one, node) !== said(other, node));
  return found.length ? _("Look again at “%(phrase)s”.", found[0]) : "";
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

export function momentsFeedback() {
  return {
    text: _("Compare yours with some that would do: somebody might say “Now to the buoy, please” when the boat begins to turn. “What is on the small island?” has the answer “a lighthouse”. A path follows the boat to the buoy."),
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

export function markFeedback({ success, quality }) {
  if (success !== "success") return answer(false, _("Watch again: the boat gets to the buoy by the lighthouse, as it was to do."));
  if (quality < 3) return answer(false, _("The boat sails there without a detour. Somebody could learn it from this video."));
  return answer(true, _("The boat does sail to the buoy by the lighthouse."));
}

export function correctFeedback({ verdict }) {
  if (verdict !== "right") return answer(false, _("Watch again: the boat sails to the buoy by the lighthouse. Most people would agree."));
  return answer(true, _("The boat does sail to the buoy by the lighthouse."));
}
