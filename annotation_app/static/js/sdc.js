// SDC trees as they are edited: a flat list of clauses that say which clause they are in.
// A state is {clauses, next, current, field}; each function gives a new one.
//
// clause: {id, type, parent: id or null, field: "f" | "l" | "l2" | null, f: [word], r: [word]},
// where a word is its number in the command.

export const TYPES = ["EVENT", "OBJECT", "PLACE", "PATH"];
export const FIELD_NAMES = { f: "figure", r: "relation", l: "landmark", l2: "second landmark" };
const CHILD_FIELDS = ["f", "l", "l2"];
const ALONE = "alone";

export const empty = { clauses: [], next: 1, current: null, field: ALONE };

export const find = (state, id) => state.clauses.find((clause) => clause.id === id);
export const children = (state, id) => inOrder(state, state.clauses.filter((c) => c.parent === id));
export const currentOf = (state) => find(state, state.current) ?? null;

export function subtree(state, id) {
  return [id, ...children(state, id).flatMap((child) => subtree(state, child.id))];
}

/** All words of a clause and the clauses in it, sorted. */
export function wordsOf(state, id) {
  const own = subtree(state, id).flatMap((part) => {
    const clause = find(state, part);
    return [...clause.f, ...clause.r];
  });
  return [...new Set(own)].sort((a, b) => a - b);
}

export const ownWords = (clause) => [...clause.f, ...clause.r].sort((a, b) => a - b);

/** The clause that holds a word itself. */
export const holder = (state, word) => state.clauses.find((c) => ownWords(c).includes(word));

function inOrder(state, clauses) {
  const rank = (c) => [CHILD_FIELDS.indexOf(c.field), wordsOf(state, c.id)[0] ?? Infinity];
  return [...clauses].sort((a, b) => rank(a)[0] - rank(b)[0] || rank(a)[1] - rank(b)[1]);
}

/** Make a clause of words, in the current clause's chosen field. */
export function add(state, type, words) {
  const parent = state.field === ALONE ? null : currentOf(state);
  const clause = {
    id: state.next,
    type,
    parent: parent?.id ?? null,
    field: parent ? state.field : null,
    f: type === "OBJECT" ? words : [],
    r: type === "OBJECT" ? [] : words,
  };
  const without = free(state, words);
  const added = tidy({
    ...without,
    clauses: [...without.clauses, clause],
    next: state.next + 1,
  });
  return proposeField(added, type === "OBJECT" && parent ? parent.id : clause.id);
}

/** What comes next: the first landmark that is free, here or further up; else a new tree. */
function proposeField(state, id) {
  for (let clause = find(state, id); clause; clause = find(state, clause.parent)) {
    const taken = children(state, clause.id).map((child) => child.field);
    const field = (clause.type === "EVENT" ? ["l", "l2"] : ["l"]).find((f) => !taken.includes(f));
    if (field) return { ...state, current: clause.id, field };
  }
  return { ...state, current: id, field: ALONE };
}

export function choose(state, id) {
  return find(state, id) ? proposeFieldOf(state, id) : state;
}

function proposeFieldOf(state, id) {
  const proposed = proposeField(state, id);
  return proposed.current === id ? proposed : { ...state, current: id, field: "l" };
}

export const chooseField = (state, field) => ({ ...state, field });

/** Give words to the current clause's figure or relation. */
export function give(state, field, words) {
  const current = state.current;
  return tidy(change(free(state, words), current, (c) => ({ ...c, [field]: sorted(c[field], words) })));
}

/** Take words out of whatever clause they are in. */
export function free(state, words) {
  const rest = (list) => list.filter((word) => !words.includes(word));
  return {
    ...state,
    clauses: state.clauses.map((c) => ({ ...c, f: rest(c.f), r: rest(c.r) })),
  };
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
  const next = { ...state, clauses: left };
  const current = gone.parent ?? left.at(-1)?.id ?? null;
  return current === null ? { ...next, current, field: ALONE } : proposeFieldOf(next, current);
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
  const leaf = {
    id: state.next,
    type: "OBJECT",
    parent: full.id,
    field: "f",
    f: full.f,
    r: [],
  };
  const emptied = change(state, full.id, (c) => ({ ...c, f: [] }));
  return tidy({ ...emptied, clauses: [...emptied.clauses, leaf], next: state.next + 1 });
}

/** As g3.sdc_notation.to_json writes it. An EVENT without a figure has the unnamed robot. */
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
  const numbers = (list) =>
    list
      .map(([, start]) => words.findIndex((w) => w.start <= start && start < w.start + [...w.text].length))
      .filter((i) => i >= 0);
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
  const state = { clauses, next: clauses.length + 1, current: null, field: ALONE };
  return clauses.length ? choose(state, 1) : state;
}

/** What must be changed before it is sent, in plain words. */
export function problems(state, words) {
  if (!state.clauses.length) {
    return ["Mark at least one clause: choose words, then a type."];
  }
  return state.clauses
    .filter((c) => !wordsOf(state, c.id).length)
    .map((c) => {
      const above = find(state, c.parent);
      const where = above ? ` in “${text(wordsOf(state, above.id), words)}”` : "";
      return `The ${c.type}${where} has no words. Give it some, or remove it.`;
    });
}

/** What looks unusual, though it may be right. */
export function hints(state, words) {
  const found = [];
  const left = words.map((_, i) => i).filter((i) => /[\p{L}\p{N}]/u.test(words[i].text) && !holder(state, i));
  if (state.clauses.length && left.length) {
    found.push(`Not in any clause yet: ${text(left, words)}.`);
  }
  for (const c of state.clauses) {
    const inside = children(state, c.id);
    if (inside.length && !c.r.length) {
      found.push(`“${text(wordsOf(state, c.id), words)}” has no relation.`);
    }
    if (["PLACE", "PATH"].includes(c.type) && inside.some((child) => child.type === "EVENT")) {
      found.push(`An EVENT is seldom inside a ${c.type}.`);
    }
  }
  return found;
}

export const text = (numbers, words) => numbers.map((i) => words[i].text).join(" ");
