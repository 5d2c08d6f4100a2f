// What people see of SDC trees: parts of a command in plain words, and the places where more fit.
//
// A part is {id, role, type, words, parts}. "the buoy by the lighthouse" is one OBJECT around
// another; people see the thing, and below it "by", which tells which one. A PLACE without words
// around one OBJECT, as in "crate truck", is seen as a thing that says where.

import { add, children, empty, find, free, give, holder, move, ownWords, pruned, remove, text, wordsOf } from "./sdc.js";
import { _ } from "./speech.js";

/** What a part says. */
export const ROLES = {
  done: _("what to do"),
  who: _("who does it"),
  what: _("what"),
  where: _("where"),
  way: _("which way"),
  which: _("which one"),
  when: _("when or how"),
  happens: _("what happens"),
};
const TYPES = { done: "EVENT", who: "OBJECT", what: "OBJECT", where: "PLACE", way: "PATH", when: "EVENT", happens: "EVENT" };
const EXAMPLES = {
  where: _("on, in, next to"), way: _("to, from, past"), which: _("by, with, that is on"), when: _("until, while, without"),
};

/** The parts of a command, each with those that belong to it. */
export const outline = (state) => children(state, null).map((clause) => partOf(state, clause));

function partOf(state, clause) {
  const below = children(state, clause.id);
  const figures = below.filter((child) => child.field === "f");
  const { id, type } = clause;
  if (isThingOnly(state, clause)) return { ...partOf(state, below[0]), role: roleOf(state, clause) };
  if (isAroundOne(state, clause)) {
    const thing = partOf(state, figures[0]);
    const joined = below.filter((child) => child.field !== "f").map((child) => partOf(state, child));
    const description = { id, role: "which", type, words: clause.r, parts: joined };
    return { ...thing, role: roleOf(state, clause), parts: [...thing.parts, description] };
  }
  return { id, role: roleOf(state, clause), type, words: ownWords(clause), parts: below.map((child) => partOf(state, child)) };
}

/** Whether a clause is a thing with what describes it. */
function isAroundOne(state, clause) {
  const figures = children(state, clause.id).filter((child) => child.field === "f");
  return clause.type === "OBJECT" && figures.length === 1 && figures[0].type === "OBJECT";
}

/** Whether a clause says where or which way by a thing alone. */
function isThingOnly(state, clause) {
  const below = children(state, clause.id);
  return ["PLACE", "PATH"].includes(clause.type) && !ownWords(clause).length && below.length === 1 && below[0].type === "OBJECT";
}

function roleOf(state, { type, field, parent }) {
  const above = find(state, parent);
  if (type === "EVENT") return !above ? "done" : above.type === "EVENT" && roleOf(state, above) !== "when" ? "when" : "happens";
  if (field === "f" && above?.type === "EVENT") return "who";
  return { OBJECT: "what", PLACE: "where", PATH: "way" }[type];
}

/** All parts with what they belong to, in the order in which they are shown. */
export function allParts(parts, above = null) {
  return parts.flatMap((part) => [{ ...part, above }, ...allParts(part.parts, part)]);
}

/** The ids of a part and all that it belongs to. */
export function lineOf(state, id) {
  const all = new Map(allParts(outline(state)).map((part) => [part.id, part]));
  const line = [];
  for (let part = all.get(id); part; part = all.get(part.above?.id)) line.push(part.id);
  return line;
}

/** The places that a part has for words: {key, of, role, example, isFilled}; the current part takes more words. */
export function placesOf(part, chosen, isCurrent = false) {
  const done = ["what", "where", "way", "when", ...(part.words.length && chosen[0] < part.words[0] ? ["who"] : [])];
  const which = part.words.length ? ["which"] : [];
  const roles = part.type === "OBJECT" && part.role !== "which" ? which : {
    done,
    happens: done,
    when: ["what", "where", "way", "happens"],
    where: ["what", "happens"],
    way: ["what", "happens"],
    which: ["what"],
    what: [],
    who: which,
  }[part.role];
  const places = roles.map((role) => ({
    key: `${part.id} ${role}`,
    of: part.id,
    role,
    example: EXAMPLES[role],
    isFilled: part.parts.some((below) => below.role === role),
  }));
  return isCurrent && part.words.length ? [...places, moreOf(part)] : places;
}

export const TOP = { key: "done", of: null, role: "done" };
const moreOf = (part) => ({ key: `${part.id} more`, of: part.id, role: "more" });

/** What a place asks: "Put where?", "by what?". Hints and buttons both say it so. */
export function question(role, words, isNext = false) {
  if (role === "done") return isNext ? _("What to do next?") : _("What to do?");
  if (role === "more") return _("More of “%(words)s”", { words });
  if (role === "which") return _("%(words)s: which one?", { words });
  if (role === "who") return _("%(words)s: who does it?", { words });
  if (role === "when") return _("%(words)s when or how?", { words });
  if (role === "happens") return _("%(words)s what happens?", { words });
  if (role === "what") return _("%(words)s what?", { words });
  if (role === "where") return _("%(words)s where?", { words });
  return _("%(words)s which way?", { words });
}

/** What the button says by which there is an action without words. */
export const unsaid = (isNext) => (isNext ? _("No word says what to do next") : _("No word says it"));

/** What a part is called: by its words, else by those in it; "Do" where no word says what to do. */
export function nameOf(part, words) {
  if (part.words.length) return text(part.words, words);
  return part.type === "EVENT" ? _("Do") : allParts(part.parts).map((below) => text(below.words, words)).join(" ");
}

/** Whether something says what to do, if only that no word does. */
export const hasAction = (state) => state.clauses.some(({ type }) => type === "EVENT");

/** Have an action that no word says: "Tires to the truck". */
export const addUnsaid = (state) => add(state, "EVENT", null, null, []);

/** Have a place or way said by a thing alone: "crate truck". */
export const asThing = (state, id) => add(state, "OBJECT", id, "l", find(state, id).r);

/** Put words into a place; the part that they make is the current one, with what belonged to them. */
export function put(state, { of, role }, words) {
  const from = partWith(state, words);
  const there = allParts(outline(state)).find((part) => part.role === role && (part.above?.id ?? null) === of && part.words.some((word) => words.includes(word)));
  if (there && there !== from && role !== "more") return reworded(state, there, words);
  if (from?.type === "OBJECT" && from.role !== "which" && TYPES[role] === "OBJECT") {
    const [settling, , parent, field] = settled(state, find(state, of), role, "OBJECT");
    const whole = around(state, find(state, from.id)).id;
    return closedUp(state, pruned({ ...move(settling, whole, parent, field), current: from.id }));
  }
  if (from?.type === "OBJECT" && role === "done") return actionOf(state, find(state, from.id));
  const below = from ? sdcBelow(state, from) : [];
  const without = { ...free(state, words), left: (state.left ?? []).filter((word) => !words.includes(word)) };
  const made = placed(without, of, role, words);
  if (role === "more") return absorbed(state, made);
  const moved = below.reduce((next, child) => move(next, child.id, made.current, child.field), made);
  return closedUp(state, pruned({ ...moved, current: made.current }));
}

/** Have a part say more or fewer words; what belongs to it stays. */
function reworded(state, { id, type, role, words: before }, words) {
  const bare = free(state, [...before, ...words]);
  const left = (state.left ?? []).filter((word) => !words.includes(word));
  return absorbed(state, { ...give({ ...bare, left }, id, type === "OBJECT" && role !== "which" ? "f" : "r", words), current: id });
}

/** Where a part has taken all words of a place in it, as in "hang on" and "to", the place's things are its own. */
function absorbed(before, after) {
  const taken = after.clauses.find((c) => c.parent === after.current && ["PLACE", "PATH"].includes(c.type)
    && !ownWords(c).length && ownWords(find(before, c.id)).length);
  return pruned(taken ? { ...remove(after, taken.id), current: after.current } : after);
}

/** Make a thing an action: where the thing was described, the description says where. */
function actionOf(state, thing) {
  const whole = around(state, thing);
  const retyped = (c) => (c.id === thing.id ? { ...c, type: "EVENT", f: [], r: c.f, parent: null, field: null }
    : c.id === whole.id ? { ...c, type: "PLACE", parent: thing.id, field: "l" } : c);
  return pruned({ ...state, clauses: state.clauses.map(retyped), current: thing.id });
}

/** Where an EVENT's first landmark has gone elsewhere, the second is the first. */
function closedUp(before, after) {
  const has = (state, id, field) => state.clauses.some((c) => c.parent === id && c.field === field);
  const open = after.clauses.filter((c) => c.type === "EVENT" && has(before, c.id, "l") && !has(after, c.id, "l"));
  const ids = open.map((c) => c.id);
  return { ...after, clauses: after.clauses.map((c) => (ids.includes(c.parent) && c.field === "l2" ? { ...c, field: "l" } : c)) };
}

/** The part that has these words and no others. */
export const partWith = (state, words) => allParts(outline(state)).find((part) => String(part.words) === String(words));

/** The clauses that go where a part goes: all in it, but not the thing that it describes. */
function sdcBelow(state, { id, role }) {
  return children(state, id).filter((child) => role !== "which" || child.field !== "f");
}

function placed(state, of, role, words) {
  if (role === "done") return add(state, "EVENT", null, null, words);
  const whole = find(state, of);
  if (role === "more") {
    return { ...give(state, of, whole.type === "OBJECT" && whole.f.length ? "f" : "r", words), current: of };
  }
  if (role === "which") return described(state, whole, words);
  const type = TYPES[role];
  return add(...settled(state, whole, role, type), words);
}

/** Where a new clause goes: the object of an EVENT is its landmark, a place or path comes after it. */
function settled(state, whole, role, type) {
  if (role === "who") return [state, type, whole.id, "f"];
  const below = children(state, whole.id);
  const first = below.filter((child) => child.field === "l");
  if (role === "when" || role === "happens") return [state, type, whole.id, role === "when" ? "l2" : "l"];
  if (whole.type !== "EVENT") return [state, type, whole.id, first.length ? "l2" : "l"];
  if (type !== "OBJECT") return [state, type, whole.id, first.length ? "l2" : "l"];
  if (first.some((child) => child.type === "OBJECT")) return [state, type, whole.id, "l"];
  const after = first.map((child) => child.id);
  const clauses = state.clauses.map((c) => (after.includes(c.id) ? { ...c, field: "l2" } : c));
  return [{ ...state, clauses }, type, whole.id, "l"];
}

/** A thing with all that describes it. */
function around(state, thing) {
  const isFigure = thing.field === "f" && isAroundOne(state, find(state, thing.parent));
  return isFigure ? around(state, find(state, thing.parent)) : thing;
}

/** A thing gets words that join it to what describes it. */
function described(state, thing, words) {
  const outer = around(state, thing);
  if (outer === thing) return { ...give(state, thing.id, "r", words), current: thing.id };
  const id = state.next;
  const wrapper = { id, type: "OBJECT", parent: outer.parent, field: outer.field, f: [], r: [...words] };
  const clauses = state.clauses.map((c) => (c.id === outer.id ? { ...c, parent: id, field: "f" } : c));
  return { ...state, clauses: [...clauses, wrapper], next: id + 1, current: id };
}

// Translators: words with spaces between them, which join commands or are polite.
const SELDOM = new Set(_("and but now or please then").split(" "));

/** The first word that wants a place and has none yet; null if there is none. */
export function nextWord(state, words) {
  const wants = ({ text: word }, i) =>
    /[\p{L}\p{N}]/u.test(word) && !SELDOM.has(word.toLowerCase()) && !holder(state, i) && !state.left?.includes(i);
  const found = words.findIndex(wants);
  return found < 0 ? null : found;
}

/** What must be changed before it is sent, in plain words. */
export function problems(state, words) {
  if (!state.clauses.length) return [_("Give the words their places first: begin with those that say what to do.")];
  return state.clauses
    .filter((c) => !wordsOf(state, c.id).length)
    .map((c) => {
      const above = find(state, c.parent);
      return above && wordsOf(state, above.id).length
        ? _("A part of “%(words)s” has no words. Give it some, or remove it.", { words: text(wordsOf(state, above.id), words) })
        : _("A part has no words. Give it some, or remove it.");
    });
}

/**
 * What people are asked before it is sent: {text, label, mend(state)}, the last two where a press suffices.
 *
 * `actions` are words that nearly always say what to do, `wheres` those that a program thinks to say
 * where, null if it can't; `unsure` are those of a suggestion that it isn't sure of.
 */
export function doubts(state, words, { actions = [], wheres = null, unsure = [], suggestion = empty }) {
  if (!hasAction(state)) return [{ text: _("Nothing says what to do. Choose the words that do, or “No word says it”.") }];
  const asThings = actions.filter((word) => holder(state, word)?.type === "OBJECT" && holder(state, word).f.includes(word));
  const alone = state.clauses.filter((c) => ["PLACE", "PATH"].includes(c.type) && !children(state, c.id).length && wheres && !wheres.includes(c.r[0]));
  return [
    ...asThings.map((word) => ({
      text: _("“%(words)s” is a thing here. Does it say what to do? Then choose it, and “%(place)s”.", {
        words: words[word].text, place: question("done", "", true) }),
    })),
    ...alone.map((c) => ({
      text: _("“%(words)s” says where, without a word like “on” or “to”. Is it a thing?", { words: text(c.r, words) }),
      label: _("It is a thing"),
      mend: (now) => asThing(now, c.id),
    })),
    ...unchanged(state, suggestion, unsure).map(({ words: part, role, above }) => ({
      text: role
        ? _("The program isn't sure of “%(words)s” as “%(place)s”. If it is wrong, choose it, then its place.", {
          words: text(part, words), place: question(role, above ? text(above, words) : "") })
        : _("The program has left out “%(words)s”, and isn't sure. If it belongs somewhere, choose it, then its place.", { words: text(part, words) }),
    })),
  ];
}

/** Of each word: the words it is with, what they say, and the words that they belong to. */
export function placings(state) {
  const found = new Map();
  for (const { words, role, above } of allParts(outline(state))) {
    for (const word of words) found.set(word, { words, role, above: above?.words ?? null });
  }
  return found;
}

/** The placings of some words that are those of a suggestion, each once. */
function unchanged(state, suggestion, numbers) {
  const before = placings(suggestion);
  const now = placings(state);
  const placing = (all, word) => JSON.stringify(all.get(word) ?? { words: [word] });
  const same = numbers.filter((word) => placing(before, word) === placing(now, word));
  return [...new Set(same.map((word) => placing(now, word)))].map((one) => JSON.parse(one));
}
