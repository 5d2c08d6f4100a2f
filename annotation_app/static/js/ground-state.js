// What somebody has grounded so far: pure functions of a state that JSON can say.
//
// {groundings: {node: {objects, places, cant_tell, time_s}}, trims: {node: [start, end]}, whole: [nodes],
//  half: {node: [start or null, end or null]}, several: {node: bool},
//  unsure: {node: true} for what a program suggested and nobody has looked at, cuts: [moments at which
//  the next step begins], current: a node, "watch", "cuts" or "review", watched_s,
//  drawn: [{id, polygons, time_s}]}
//
// What is shown and sent is a state that is `filled` with what follows from its answers.

export const WATCH = "watch";
export const CUTS = "cuts";
export const REVIEW = "review";
const NOTHING = { objects: [], places: [], cant_tell: false, time_s: 0 };

export const isThing = (clause) => clause.type === "OBJECT" || clause.type === "PLACE";
export const groundingOf = (state, node) => state.groundings[node] ?? NOTHING;
export const isWhole = (state, node) => Boolean(state.whole?.includes(node));
/** The part of the video that has been set for a clause; an end may be null. */
export const partOf = (state, node) => state.trims[node] ?? state.half?.[node] ?? [null, null];

/** Whether a clause has what a program suggested, and nobody has said that it is right. */
export const isUnsure = (state, node) => Boolean(state.unsure?.[node]);

const without = (of, node) => Object.fromEntries(Object.entries(of ?? {}).filter(([key]) => key !== String(node)));
const count = ({ objects, places }) => objects.length + places.length;

/** Whether several things may be chosen for a clause: if its words say so, or somebody does. */
export function isSeveral(state, clause) {
  return state.several?.[clause.node] ?? (clause.several || count(groundingOf(state, clause.node)) > 1);
}

/** Whether something is said of a clause, by people or as a proposal. */
export function isSaid(state, { node, type }) {
  if (!isThing({ type })) return Boolean(state.trims[node]) || isWhole(state, node);
  const grounding = groundingOf(state, node);
  return grounding.cant_tell || count(grounding) > 0;
}

export const isDone = (state, clause) =>
  clause.node === WATCH ? state.watched_s !== undefined : isSaid(state, clause) && !isUnsure(state, clause.node) && !isProposed(state, clause.node);

/** Whether what is said of a clause follows from other answers, in a filled state. */
export const isProposed = (state, node) => Boolean(state.proposed?.[node]);

/**
 * A state with what follows from its answers: the same thing under another name, a place by the thing
 * that it is told by where there is no map, the part of the video that shows what is around it, and the
 * whole video where there is but one step.
 */
export function filled(state, clauses, { hasMap, hasSteps }) {
  let next = { ...state, groundings: { ...state.groundings }, trims: { ...state.trims }, whole: [...(state.whole ?? [])], proposed: {} };
  const isOpen = (clause) => (!isSaid(next, clause) || isUnsure(next, clause.node)) && !next.half?.[clause.node];
  const isKnown = (source) => isSaid(next, source) && !isUnsure(next, source.node);
  const open = clauses.filter(isOpen);
  for (let pass = 0; pass < open.length; pass += 1) {
    for (const clause of open.filter(isOpen)) {
      const source = clauses.find(({ node }) => node === sourceOf(clause, hasMap));
      if (isThing(clause)) {
        if (!source || !isKnown(source)) continue;
        next.groundings[clause.node] = groundingOf(next, source.node);
        next.unsure = without(next.unsure, clause.node);
      } else if (source ? isKnown(source) : !hasSteps) {
        if (source && next.trims[source.node]) next.trims[clause.node] = next.trims[source.node];
        else next.whole.push(clause.node);
      } else continue;
      next.proposed[clause.node] = true;
    }
  }
  return next;
}

/** The clause from whose answer that of another one follows; null if there is none. */
export const sourceOf = (clause, hasMap) =>
  (isThing(clause) ? clause.follows ?? (hasMap ? null : clause.at) : clause.during) ?? null;

/** Have the parts of steps that follow each other begin and end at certain moments. */
export function setCuts(state, steps, cuts, duration) {
  let next = { ...state, cuts };
  if (cuts.length + 1 < steps.length) return steps.reduce((found, { node }) => setPart(found, node, [null, null]), next);
  steps.forEach(({ node }, i) => { next = setPart(next, node, [cuts[i - 1] ?? 0, cuts[i] ?? duration]); });
  return next;
}

/** Keep what a program suggested for a clause. */
export function confirmed(state, node) {
  return state.unsure ? { ...state, unsure: without(state.unsure, node) } : state;
}

export function setSeveral(state, node, is) {
  return { ...state, several: { ...state.several, [node]: is } };
}

function set(state, node, part, time_s) {
  const next = { ...groundingOf(state, node), cant_tell: false, ...part, time_s };
  return confirmed({ ...state, groundings: { ...state.groundings, [node]: next } }, node);
}

/** Choose a thing, or not; it takes the place of what was chosen unless several may be. */
export function toggleObject(state, clause, id, time_s) {
  const { objects, places } = groundingOf(state, clause.node);
  if (objects.includes(id)) return set(state, clause.node, { objects: objects.filter((one) => one !== id) }, time_s);
  const part = isSeveral(state, clause) ? { objects: [...objects, id], places } : { objects: [id], places: [] };
  return set(state, clause.node, part, time_s);
}

/** The same for one of the map's places. */
export function togglePlace(state, clause, id, time_s) {
  const { places } = groundingOf(state, clause.node);
  if (places.some(({ place }) => place === id)) return set(state, clause.node, { places: places.filter(({ place }) => place !== id) }, time_s);
  return addPlace(state, clause, { place: id }, time_s);
}

/** Add a place, {place} or {xy}. */
export function addPlace(state, clause, place, time_s) {
  const { objects, places } = groundingOf(state, clause.node);
  const part = isSeveral(state, clause) ? { objects, places: [...places, place] } : { objects: [], places: [place] };
  return set(state, clause.node, part, time_s);
}

export function removePlace(state, node, index, time_s) {
  const { places } = groundingOf(state, node);
  return set(state, node, { places: places.filter((_, i) => i !== index) }, time_s);
}

export function toggleCantTell(state, node, time_s) {
  return set(state, node, { ...NOTHING, cant_tell: !groundingOf(state, node).cant_tell }, time_s);
}

/** Have other things that were drawn; what is no longer there is chosen nowhere. */
export function setDrawn(state, drawn) {
  const gone = (state.drawn ?? []).map(({ id }) => id).filter((id) => !drawn.some((one) => one.id === id));
  const kept = ([node, one]) => [node, { ...one, objects: one.objects.filter((id) => !gone.includes(id)) }];
  return { ...state, drawn, groundings: Object.fromEntries(Object.entries(state.groundings).map(kept)) };
}

/** Set a part of the video, of which an end may be null. */
export function setPart(state, node, part) {
  const isSet = part[0] !== null && part[1] !== null;
  return {
    ...state,
    trims: isSet ? { ...state.trims, [node]: part } : without(state.trims, node),
    half: isSet || part.every((end) => end === null) ? without(state.half, node) : { ...state.half, [node]: part },
    whole: (state.whole ?? []).filter((one) => one !== node),
  };
}

export function setWhole(state, node) {
  const others = (state.whole ?? []).filter((one) => one !== node);
  return { ...state, trims: without(state.trims, node), half: without(state.half, node), whole: [...others, node] };
}

/** The clause to go on with: the next that isn't done, from a node on and then from the start; null if all are. */
export function nextOpen(steps, node, done) {
  const at = steps.findIndex((clause) => clause.node === node);
  return [...steps.slice(at + 1), ...steps.slice(0, at)].find((clause) => !done(clause))?.node ?? null;
}
