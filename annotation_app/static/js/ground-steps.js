// What has been answered and what comes next, as a list to go to and fro in.

import { h } from "./dom.js";
import { groundingOf, isProposed, isThing, isUnsure, isWhole } from "./ground-state.js";
import { _, number } from "./speech.js";

/** What was chosen for a clause, in the labels of picture and map. */
function chosenWords(state, clause, scene) {
  const { objects, places, cant_tell } = groundingOf(state, clause.node);
  if (cant_tell) return _("can't tell");
  const thing = (id) => scene.things.find((one) => one.id === id)?.number;
  const zone = (id) => scene.zones.find((one) => one.id === id)?.letter;
  const words = [...objects.map(thing), ...places.map(({ place }) => (place ? zone(place) : _("marked")))].filter(Boolean).join(", ");
  return words;
}

/** What is said of a clause, by its things' labels or its part of the video. */
export function saidOf(state, clause, scene) {
  return isThing(clause) ? chosenWords(state, clause, scene) : partWords(state, clause);
}

function partWords(state, clause) {
  const trim = state.trims[clause.node];
  if (trim) return _("%(from)s–%(to)s s", { from: number(trim[0]), to: number(trim[1]) });
  return isWhole(state, clause.node) ? _("whole video") : "";
}

/** The list. `done(clause)` tells which have an answer; `go(node)` shows one. */
export function stepList({ steps, state, scene, done, go }) {
  const item = (clause) => {
    const is = done(clause);
    const said = saidOf(state, clause, scene);
    const isOpen = isUnsure(state, clause.node) || isProposed(state, clause.node);
    return h("li", {},
      h("button",
        {
          type: "button",
          class: `clause type-${clause.type}`,
          "aria-current": clause.node === state.current ? "step" : null,
          "data-key": `clause ${clause.node}`,
          onclick: () => go(clause.node),
        },
        h("span", { class: is ? "tick-mark" : "open-mark", "aria-hidden": "true" }, is ? "✓" : ""),
        h("bdi", { class: "phrase" }, clause.phrase),
        is ? h("span", { class: "unseen" }, _("done")) : null,
        said ? h("span", { class: "said" }, isOpen ? `${said}?` : said) : null));
  };
  return h("nav", { class: "clause-bar", "aria-label": _("Clauses") }, h("ol", {}, steps.map(item)));
}
