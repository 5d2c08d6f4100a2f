// SDC trees as they are edited: a flat list of clauses that say which clause they are in.
// A state is {clauses, next, current, left}; each function gives a new one. What people see of it,
// and where they can put words, is in outline.js.
//
// clause: {id, type, parent: id or null, field: "f" | "l" | "l2" | null, f: [word], r: [word]},
// where a word is its number in the command. `left` are words that belong nowhere;
// drafts of earlier versions don't have it.

const CHILD_FIELDS = ["f", "l", "l2"];

export const empty = { clauses: [], next: 1, current: null, left: [] };

export const find = (state, id) => state.clauses.find((clause) => clause.id === id);
export const children = (state, id) => inOrder(state, state.clauses.filter((c) => c.parent === id));

export function subtree(state, id) {
  return [id, ...children(state, id).flatMap((child) => subtree(state, child.id))];
}

/** All words of a clause and the clauses in it, sorted. */
export function wordsOf(state, id) {
  const own = subtree(state, id).flatMap((part) => ownWords(find(state, part)));
  return [...new Set(own)].sort((a, b) => a - b);
}

export const ownWords = (clause) => [...clause.f, ...clause.r].sort((a, b) => a - b);

/** The clause that holds a word itself. */
export const holder = (state, word) => state.clauses.find((c) => ownWords(c).includes(word));

function inOrder(state, clauses) {
  const rank = (c) => [CHILD_FIELDS.indexOf(c.field), wordsOf(state, c.id)[0] ?? Infinity];
  return [...clauses].sort((a, b) => rank(a)[0] - rank(b)[0] || rank(a)[1] - rank(b)[1]);
}

/** Make a clause of words in a field of another clause, or on its own if `parent` is null. */
export function add(state, type, parent, field, words) {
  const inField = (list) => (type === "OBJECT" ? [list, []] : [[], list]);
  const [f, r] = inField([...words].sort((a, b) => a - b));
  const clause = { id: state.next, type, parent, field: parent === null ? null : field, f, r };
  const clauses = [...free(state, words).clauses, clause];
  return tidy({ ...state, clauses, next: state.next + 1, current: clause.id });
}

export const choose = (state, id) => (find(state, id) ? { ...state, current: id } : state);

/** Give words to a clause's figure or relation. */
export function give(state, id, field, words) {
  return tidy(change(free(state, words), id, (c) => ({ ...c, [field]: sorted(c[field], words) })));
}

/** Take words out of whatever clause they are in. */
export function free(state, words) {
  const rest = (list) => list.filter((word) => !words.includes(word));
  return { ...state, clauses: state.clauses.map((c) => ({ ...c, f: rest(c.f), r: rest(c.r) })) };
}

/** Change a clause's type; a leaf's words go where such a clause has them. */
export function retype(state, id, type) {
  return change(state, id, (c) => {
    const isLeaf = !children(state, id).length;
    if (isLeaf && type === "OBJECT") return { ...c, type, f: sorted(c.f, c.r), r: [] };
    if (isLeaf && c.type === "OBJECT") return { ...c, type, f: [], r: sorted(c.f, c.r) };
    return { ...c, type };
  });
}

/** Put a clause into another one's field, or at the top if `parent` is null. */
export function move(state, id, parent, field) {
  if (parent !== null && subtree(state, id).includes(parent)) return state;
  return tidy(change(state, id, (c) => ({ ...c, parent, field: parent === null ? null : field })));
}

/** Remove a clause; those in it take its place. */
export function remove(state, id) {
  const gone = find(state, id);
  const left = state.clauses
    .filter((c) => c.id !== id)
    .map((c) => (c.parent === id ? { ...c, parent: gone.parent, field: gone.field } : c));
  return { ...state, clauses: left, current: gone.parent ?? left.at(-1)?.id ?? null };
}

/**
 * Remove clauses that have lost all words and hold no others, and descriptions that have lost theirs.
 *
 * Those in `kept` had none before: no word says what to do.
 */
export function pruned(state, kept = []) {
  const bare = state.clauses.filter((c) => !kept.includes(c.id)).find((c) => {
    const inside = children(state, c.id);
    return !ownWords(c).length && (!inside.length || (c.type === "OBJECT" && inside.length === 1 && inside[0].field === "f"));
  });
  return bare ? pruned({ ...remove(state, bare.id), current: state.current }, kept) : state;
}

function change(state, id, how) {
  return { ...state, clauses: state.clauses.map((c) => (c.id === id ? how(c) : c)) };
}

const sorted = (a, b) => [...new Set([...a, ...b])].sort((x, y) => x - y);

/** The words of a figure become a clause of their own where there is more than a figure. */
function tidy(state) {
  const full = state.clauses.find(
    (c) => c.f.length && (c.r.length || state.clauses.some((other) => other.parent === c.id)),
  );
  if (!full) return state;
  const leaf = { id: state.next, type: "OBJECT", parent: full.id, field: "f", f: full.f, r: [] };
  const emptied = change(state, full.id, (c) => ({ ...c, f: [] }));
  return tidy({ ...emptied, clauses: [...emptied.clauses, leaf], next: state.next + 1 });
}

/** As g3.sdc.sdc_notation.to_json writes it. An EVENT without a figure has the unnamed robot. */
export function toJson(state, words) {
  const spans = (list) => list.map((i) => [words[i].text, words[i].start]);
  const clause = (c) => {
    const found = { type: c.type };
    if (c.f.length) found.f = spans(c.f);
    if (c.r.length) found.r = spans(c.r);
    for (const child of children(state, c.id)) {
      (found[child.field] ??= []).push(clause(child));
    }
    if (c.type === "EVENT" && !found.f) found.f = [{ type: "OBJECT" }];
    return found;
  };
  return children(state, null).map(clause);
}

export function fromJson(sdcs, words) {
  const clauses = [];
  // A word there may be several here, as "1.5" is; marks are taken only where they begin a word.
  const numbers = (list) => {
    const ends = list.map(([word, start]) => [start, start + [...word].length]);
    const all = ends.flatMap(([start, end]) =>
      words.flatMap((w, i) => {
        const stop = w.start + [...w.text].length;
        const begins = w.start <= start && start < stop;
        return begins || (start < w.start && w.start < end && /[\p{L}\p{N}]/u.test(w.text)) ? [i] : [];
      }),
    );
    return [...new Set(all)]; // "left-hand" may be three words there
  };
  const read = (value, parent, field) => {
    const isWords = Array.isArray(value.f?.[0]);
    const filled = ["f", "r", "l", "l2"].some((name) => value[name]?.length);
    if (!filled && parent !== null) return; // the unnamed robot
    const id = clauses.length + 1;
    const f = isWords ? numbers(value.f) : [];
    clauses.push({ id, type: value.type, parent, field, f, r: numbers(value.r ?? []) });
    for (const name of CHILD_FIELDS) {
      if (name === "f" && isWords) continue;
      for (const child of value[name] ?? []) read(child, id, name);
    }
  };
  for (const value of sdcs) read(value, null, null);
  return { ...empty, clauses, next: clauses.length + 1, current: clauses.length ? 1 : null };
}

export const text = (numbers, words) => numbers.map((i) => words[i].text).join(" ");
