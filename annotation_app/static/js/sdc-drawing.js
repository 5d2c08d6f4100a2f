// The SDC trees drawn as trees.

import { s } from "./dom.js";
import { children, ownWords, text, FIELD_NAMES } from "./sdc.js";

const CHARACTER = 8;
const LEVEL = 84;
const GAP = 18;
const BOX = 44;

/**
 * An SVG picture; the list of clauses beside it says the same to people who can't see it.
 * `pick(id)` is called for a clause that is clicked; null if the trees are only looked at.
 */
export function drawTrees(state, words, pick) {
  const parts = [];
  let left = 0;
  let deepest = 0;

  const place = (clause, depth) => {
    deepest = Math.max(deepest, depth);
    const below = children(state, clause.id);
    const label = shortened(text(ownWords(clause), words) || "…");
    const width = Math.max([...label].length * CHARACTER + 22, 96);
    const start = left;
    const centres = below.map((child) => ({ child, x: place(child, depth + 1) }));
    let x = start + width / 2;
    if (centres.length) {
      x = Math.max((centres[0].x + centres.at(-1).x) / 2, start + width / 2);
      left = Math.max(left, start + width + GAP);
    } else left = start + width + GAP;
    const y = depth * LEVEL + 4;
    for (const { child, x: childX } of centres) {
      const childY = (depth + 1) * LEVEL + 4;
      const middle = (y + BOX + childY) / 2;
      parts.unshift(
        s("path", { class: "edge", d: `M${x},${y + BOX} C${x},${middle} ${childX},${middle} ${childX},${childY}` }),
      );
      parts.push(
        s("text", { class: "edge-name", x: childX, y: childY - 7 }, FIELD_NAMES[child.field]),
      );
    }
    const isCurrent = clause.id === state.current ? " current" : "";
    parts.push(
      s(
        "g",
        { class: `node type-${clause.type}${isCurrent}`, onclick: pick && (() => pick(clause.id)) },
        s("rect", { x: x - width / 2, y, width, height: BOX, rx: 9 }),
        s("text", { class: "node-type", x, y: y + 16 }, clause.type),
        s("text", { class: "node-words", x, y: y + 34 }, label),
      ),
    );
    return x;
  };
  for (const root of children(state, null)) place(root, 0);
  const width = Math.max(left - GAP + 8, 1);
  const height = deepest * LEVEL + BOX + 8;
  return s(
    "svg",
    { class: "tree", viewBox: `-4 0 ${width} ${height}`, width, height, "aria-hidden": "true" },
    parts,
  );
}

const shortened = (label) => ([...label].length > 26 ? `${[...label].slice(0, 25).join("")}…` : label);
