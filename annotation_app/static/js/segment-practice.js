// What people learn from the practice sentence of Segment: which word is in the wrong place, and
// how it is done, step by step.

import { TOP, addUnsaid, allParts, nameOf, outline, placesOf, placings, put, question, unsaid } from "./outline.js";
import { text } from "./sdc.js";
import { _ } from "./speech.js";

/** Places and ways are often the same to people: "Sail where? To the buoy." */
const alike = (role) => (role === "way" ? "where" : role);

const same = (one, other) => String(one) === String(other);

/** {good, text, words}: the first word that isn't where it is in the right tree, and those with it. */
export function differences(state, right, words) {
  const found = placings(state);
  const wanted = placings(right);
  const said = (numbers) => _("“%(quoted)s”", { quoted: text(numbers, words) });
  for (const word of [...wanted.keys()].sort((a, b) => a - b)) {
    const is = found.get(word);
    const be = wanted.get(word);
    const place = _("“%(quoted)s”", { quoted: question(be.role, be.above ? text(be.above, words) : "", found.size > 0) });
    const values = { right: said(be.words), place };
    if (!is) return bad(be.words, _("%(word)s has no place yet. Choose %(right)s, then %(place)s.", { ...values, word: said([word]) }));
    if (!same(is.words, be.words)) {
      const many = is.words.filter((other) => !be.words.includes(other));
      if (many.length) return bad(many, _("%(wrong)s doesn't belong with %(right)s. Choose %(right)s, then %(place)s.", { ...values, wrong: said(many) }));
      return bad(be.words, _("%(right)s belong together. Choose all of these words, then %(place)s.", values));
    }
    if (alike(is.role) !== alike(be.role) || !same(is.above, be.above)) {
      return bad(be.words, _("%(right)s isn't in its place. Choose %(right)s, then %(place)s.", values));
    }
  }
  const extra = [...found.keys()].filter((word) => !wanted.has(word));
  if (extra.length) return bad(extra, _("%(wrong)s needs no place. Choose it, then “Leave it out”.", { wrong: said(extra) }));
  return { good: true, text: _("That is how we would do it, too."), words: [] };
}

const bad = (words, why) => ({ good: false, text: why, words });

/** The steps to the right tree: {taken, place(state), act(state), said}. */
export function lesson(right, words) {
  return allParts(outline(right)).map(({ words: taken, role, above }, at) => {
    const isNext = at > 0;
    if (!taken.length) {
      return { taken, place: () => null, act: addUnsaid, said: _("No word says what to do. Press “%(label)s”.", { label: unsaid(isNext) }) };
    }
    const label = question(role, above ? nameOf(above, words) : "", isNext);
    const place = (state) => {
      if (!above) return TOP;
      const there = allParts(outline(state)).findLast((part) => same(part.words, above.words));
      return placesOf(there, taken).find((one) => one.role === role);
    };
    const values = { words: text(taken, words), label };
    const said = taken.length > 1
      ? _("Choose these words: “%(words)s”. Then choose the place “%(label)s”.", values)
      : _("Choose the word: “%(words)s”. Then choose the place “%(label)s”.", values);
    return { taken, place, act: (state) => put(state, place(state), taken), said };
  });
}
