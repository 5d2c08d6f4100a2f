// The question about a clause, and what can be done besides clicking.

import { h } from "./dom.js";
import { CUTS, groundingOf, isDone, isProposed, isSeveral, isThing, isUnsure, isWhole, partOf, REVIEW, WATCH } from "./ground-state.js";
import { _, number, pieces } from "./speech.js";

const button = (key, onclick, properties, ...text) => h("button", { type: "button", "data-key": key, onclick, ...properties }, ...text);
const cap = (key) => h("kbd", { "aria-hidden": "true" }, key);

/** The question's parts. `acts` is what the page does; `all` tells whether everything is done. */
export function question(clause, state, acts) {
  if (clause.node === WATCH) return watch(state, acts);
  if (clause.node === CUTS) return cuts(state, acts);
  if (clause.node === REVIEW) return review(acts);
  return isThing(clause) ? thing(clause, state, acts) : happening(clause, state, acts);
}

function words(acts, asked, clause, hint) {
  return h("div", { class: "asked" },
    h("h2", {}, h("span", { class: "count" }, acts.count), ...pieces(asked, { phrase: clause && h("q", {}, h("bdi", {}, clause.phrase)) })),
    h("p", { class: "hint" }, hint));
}

function onwards(acts, isPrimary) {
  return [
    button("back", acts.back, { disabled: !acts.back }, _("Back")),
    button("next", acts.next, { class: isPrimary ? "primary" : null, disabled: !acts.next }, _("Next")),
    // On a telephone the page's own button is far below.
    acts.isReady ? button("send", acts.send, { class: "primary send-here" }, acts.sendWord) : null,
  ];
}

function watch(state, acts) {
  const isWatched = state.watched_s !== undefined;
  const hint = acts.isReady ? acts.ready : isWatched ? _("You have watched it. Go on with the next question.")
    : _("It shows what the command was meant to bring about. Then you are asked about its words.");
  return [
    words(acts, isWatched ? _("The video") : _("First, watch the video to its end."), null, hint),
    h("div", { class: "actions" }, button("play", acts.play, { class: isWatched ? null : "primary" }, isWatched ? _("Play it again") : _("Play the video")), ...onwards(acts, isWatched)),
  ];
}

/** When each of several steps begins that follow one another. */
function cuts(state, acts) {
  const { step, isSet } = acts.cuts;
  const hint = acts.cuts.problem ? acts.cuts.problem : acts.isReady ? acts.ready
    : isSet ? _("“Again” changes it.")
    : _("Play the video. At the moment at which this begins, press “It begins here”.");
  return [
    words(acts, isSet ? _("When each step begins") : _("When does %(phrase)s begin?"), step, hint),
    h("div", { class: "actions" },
      isSet ? null : button("cut", acts.cuts.here, { class: "primary" }, _("It begins here"), " ", cap("E")),
      acts.cuts.again ? button("again", acts.cuts.again, {}, _("Again")) : null,
      button("single", acts.cuts.single, {}, _("Another order, or gaps")),
      ...onwards(acts, isSet && !acts.isReady)),
  ];
}

/** What follows from the answers, to be confirmed with one key. */
function review(acts) {
  return [
    words(acts, _("Is this right, too?"), null, _("It follows from your answers. Click what isn’t right.")),
    h("ul", { class: "follows" }, acts.proposals.map(({ clause, said, go }) =>
      h("li", {}, button(`proposed ${clause.node}`, go, { class: `clause type-${clause.type}` }, h("bdi", { class: "phrase" }, clause.phrase), h("span", { class: "said" }, said))))),
    h("div", { class: "actions" }, button("right", acts.send, { class: "primary" }, _("Yes: %(button)s", { button: acts.sendWord }), " ", cap("Y")), button("back", acts.back, {}, _("Back"))),
  ];
}

function thing(clause, state, acts) {
  const grounding = groundingOf(state, clause.node);
  const several = isSeveral(state, clause);
  const isPlace = clause.type === "PLACE";
  const marked = grounding.places.map((place, i) => [place, i]).filter(([place]) => place.xy).map(([, i], n) =>
    h("span", { class: "marked" }, _("Marked place %(number)s", { number: n + 1 }), " ", button(`unmark ${i}`, () => acts.unmark(i), { class: "link" }, _("remove"))));
  const is = isDone(state, clause);
  const follows = isProposed(state, clause.node);
  const unsure = follows || isUnsure(state, clause.node);
  const hint = acts.isDrawing ? _("Draw a box around it. Escape ends.") : follows ? FOLLOWS : acts.isReady ? acts.ready : unsure ? SUGGESTED : hintFor(isPlace, several, is, Boolean(acts.mark));
  return [
    words(acts, isPlace ? _("Where is %(phrase)s?") : several ? _("What are %(phrase)s?") : _("What is %(phrase)s?"), clause, hint),
    h("div", { class: "actions" },
      unsure ? button("right", acts.confirm, { class: "primary" }, _("Yes, %(chosen)s", acts), " ", cap("Y")) : null,
      ...marked,
      h("label", { class: "choice" }, severalBox(several, acts), h("span", {}, _("Several"), " ", cap("S"))),
      acts.draw ? button("draw", acts.draw, { "aria-pressed": acts.isDrawing }, _("Draw it"), " ", cap("D")) : null,
      acts.mark ? button("mark", acts.mark, {}, _("Mark a place"), " ", cap("M")) : null,
      button("cant", acts.cantTell, { "aria-pressed": grounding.cant_tell }, _("Can't tell"), " ", cap("X")),
      ...onwards(acts, is && !acts.isReady)),
  ];
}

const FOLLOWS = _("This follows from your other answers. Say yes, or choose what is right.");
const SUGGESTED = _("A program suggests what is marked. It makes mistakes, so look yourself: say yes, or choose what is right.");

function severalBox(several, acts) {
  const box = h("input", { type: "checkbox", "data-key": "several", onchange: () => acts.several(!several) });
  box.checked = several;
  return box;
}

function hintFor(isPlace, several, is, hasMap) {
  if (several && is) return _("Choose all that are meant, then press Next.");
  if (several) return hasMap ? _("Click each of them, in the picture or on the map. Then press Next.") : _("Click each of them, in the picture. Then press Next.");
  if (is) return _("You can choose another one, or press Next.");
  if (!hasMap) return _("Click it in the picture, or press the number of its label.");
  return isPlace ? _("Click a dashed place on the map, or press its letter. If none is right, mark the place.")
    : _("Click it in the picture or on the map, or press the number of its label.");
}

function happening(clause, state, acts) {
  const [start, end] = partOf(state, clause.node);
  const whole = isWhole(state, clause.node);
  const isSet = start !== null && end !== null;
  const follows = isProposed(state, clause.node);
  const steps = acts.steps.length > 1
    ? acts.steps.map(([from, to], i) => button(`part ${i}`, () => acts.part([from, to]), {}, _("Part %(number)s: %(from)s–%(to)s s", { number: i + 1, from: number(from), to: number(to) }))) : [];
  return [
    words(acts, _("When does the video show %(phrase)s?"), clause, follows ? FOLLOWS : acts.isReady ? acts.ready : partHint(start, end, whole, isSet)),
    h("div", { class: "actions" },
      follows ? button("right", acts.confirm, { class: "primary" }, _("Yes, %(chosen)s", acts), " ", cap("Y")) : null,
      button("starts", acts.starts, { class: start === null && !whole ? "primary" : null }, _("It starts here")),
      button("ends", acts.ends, { class: start !== null && end === null ? "primary" : null }, _("It ends here")),
      ...steps,
      acts.same ? button("same", acts.same.act, {}, ...pieces(_("The same as %(phrase)s"), { phrase: h("q", {}, h("bdi", {}, acts.same.phrase)) })) : null,
      button("whole", acts.whole, { "aria-pressed": whole && !follows }, _("The whole video")),
      ...onwards(acts, isSet && !acts.isReady && !follows)),
  ];
}

function partHint(start, end, whole, isSet) {
  if (whole) return _("It is the whole video. You can choose a part instead.");
  if (isSet) return _("From %(start)s s to %(end)s s. Move the handles if that isn't right, or press Next.", { start: number(start), end: number(end) });
  if (start !== null) return _("Play on until it is over, then press “It ends here”.");
  if (end !== null) return _("Go to the moment when it begins, then press “It starts here”.");
  return _("Play the video. When it begins, press “It starts here”; when it is over, “It ends here”.");
}
