// What people learn from the practice sentence of Segment: which word is in the wrong place, and
// how it is done, step by step.

import { TOP, allParts, outline, placesOf, question } from "./outline.js";
import { text } from "./sdc.js";

/** Places and ways are often the same to people: "Sail where? To the buoy." */
const alike = (role) => (role === "way" ? "where" : role);

/** Of each word: the words it is with, what they say, and the words that they belong to. */
function placings(state) {
  const found = new Map();
  for (const { words, role, above } of allParts(outline(state))) {
    for (const word of words) found.set(word, { words, role, above: above?.words ?? null });
  }
  return found;
}

const same = (one, other) => String(one) === String(other);

/** {good, text, words}: the first word that isn't where it is in the right tree, and those with it. */
export function differences(state, right, words) {
  const found = placings(state);
  const wanted = placings(right);
  const said = (numbers) => `“${text(numbers, words)}”`;
  for (const word of [...wanted.keys()].sort((a, b) => a - b)) {
    const is = found.get(word);
    const be = wanted.get(word);
    const place = `“${question(be.role, be.above ? text(be.above, words) : "")}”`;
    if (!is) return bad(be.words, `${said([word])} has no place yet. Choose ${said(be.words)}, then ${place}.`);
    if (!same(is.words, be.words)) {
      const many = is.words.filter((other) => !be.words.includes(other));
      if (many.length) return bad(many, `${said(many)} doesn't belong with ${said(be.words)}. Choose ${said(be.words)}, then ${place}.`);
      return bad(be.words, `${said(be.words)} belong together. Choose all of these words, then ${place}.`);
    }
    if (alike(is.role) !== alike(be.role) || !same(is.above, be.above)) {
      return bad(be.words, `${said(be.words)} isn't in its place. Choose ${said(be.words)}, then ${place}.`);
    }
  }
  const extra = [...found.keys()].filter((word) => !wanted.has(word));
  if (extra.length) return bad(extra, `${said(extra)} needs no place. Choose it, then “Leave it out”.`);
  return { good: true, text: "That is how we would do it, too.", words: [] };
}

const bad = (words, why) => ({ good: false, text: why, words });

/** The steps to the right tree: {taken, place(state), said}. */
export function lesson(right, words) {
  return allParts(outline(right)).map(({ words: taken, role, above }) => {
    const label = question(role, above ? text(above.words, words) : "");
    const place = (state) => {
      if (!above) return TOP;
      const there = allParts(outline(state)).find((part) => same(part.words, above.words));
      return placesOf(there, taken).find((one) => one.role === role);
    };
    const many = taken.length > 1 ? "Choose these words" : "Choose the word";
    return { taken, place, said: `${many}: “${text(taken, words)}”. Then choose the place “${label}”.` };
  });
}
