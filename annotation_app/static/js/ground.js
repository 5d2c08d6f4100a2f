// Ground: what each clause refers to, in the picture and on the map.

import { $, announce, h, isShortcut, redraw } from "./dom.js";
import { neighbour, showCommand } from "./clauses.js";
import { question } from "./ground-ask.js";
import * as ground from "./ground-state.js";
import { saidOf, stepList } from "./ground-steps.js";
import { labelKeys } from "./label-keys.js";
import { showMap } from "./map.js";
import { asThings, drawingOver } from "./ground-drawing.js";
import { showPicture } from "./picture.js";
import { different, groundFeedback } from "./practice.js";
import { numbered } from "./scene.js";
import { showTimeline } from "./timeline.js";
import { begin, data, payload } from "./work.js";
import { _ } from "./speech.js";

const { CUTS, isThing, REVIEW, WATCH } = ground;
const scene = numbered(payload);
const { clauses } = scene;
const LABELS = data.labels;
const asksParts = payload.asks_parts;
const mustWatch = Boolean(scene.video);
const hasMap = !scene.map.missing;
const steps = [...(mustWatch ? [{ node: WATCH, type: "WATCH", phrase: _("Watch the video") }] : []), ...clauses];
// What one step shows is the whole video; of several that follow each other people tell when each begins.
const stages = clauses.filter(({ type, during }) => type === "EVENT" && during === null);
const hasSteps = stages.length > 1;
const cutting = { node: CUTS, type: "CUTS", phrase: _("When each step begins") };
const reviewing = { node: REVIEW, type: "REVIEW", phrase: _("What follows from your answers") };
const asked = [
  ...steps.filter((clause) => clause.node === WATCH || (isThing(clause) && ground.sourceOf(clause, hasMap) === null)),
  ...(hasSteps ? [cutting, ...clauses.filter(({ type, during }) => type === "PATH" && during === null)] : []),
];
const first = asked[0] ?? reviewing;
let complaint = ""; // about the moment at which a step is to begin

const marked = [...scene.things];
let map = null;
let timeline = null;
let drawer = null;
const picture = showPicture(scene, (id) => choose("object", id), moved);
const video = picture.element.querySelector("video");
map = showMap(scene, choose, addPlace);
timeline = showTimeline({
  duration: scene.duration_s,
  frame: 1 / (scene.fps ?? 25),
  marks: [...new Set(scene.steps.flat())].filter((t) => t > 0 && t < scene.duration_s),
  moved: (t) => {
    video.pause();
    picture.seek(t);
  },
  chosen: setPart,
});
const words = h("div", { class: "question" });
const ask = h("section", { class: "panel ask", "aria-label": _("What this clause refers to") }, words, timeline.element);
const lists = h("section", { class: "lists", "aria-label": _("Things and places by their labels") });
const list = h("div", { class: "steps" });
$("editor").append(ask, h("div", { class: "scene" }, picture.element, hasMap ? map.element : null), lists, list);

if (payload.drawing) {
  drawer = drawingOver({
    scene, picture, video,
    changed: (drawn) => work.change(ground.setDrawn(work.state, drawn)),
    picked: (id) => choose("object", id),
    stopped: () => draw(work.state),
  });
}

// Who decides between answers begins with one of them.
const suggested = data.start ? {} : (payload.suggestion ?? {});
const unsure = Object.fromEntries(Object.keys(suggested).map((node) => [node, true]));

const work = begin({
  initial: { groundings: suggested, unsure, trims: {}, whole: [], current: first?.node },
  draw,
  body(state) {
    const { groundings, trims, whole, watched_s, speed, drawn } = full(state);
    const sent = { groundings, trims, whole: asksParts ? whole.map(String) : (state.whole ?? []).map(String), watched_s, speed };
    return drawn?.length ? { ...sent, drawn } : sent;
  },
  problems,
  feedback: (state) => groundFeedback(full(state)),
  explain: (state, right) => different(clauses, full(state), right),
});

/** The state with what follows from its answers. */
function full(state) {
  return ground.filled(state, clauses, { hasMap, hasSteps });
}

function problems(state) {
  const found = full(state);
  const open = clauses.filter((clause) => !ground.isSaid(found, clause) || ground.isUnsure(found, clause.node));
  const told = [
    ...(mustWatch && state.watched_s === undefined ? [_("Watch the video to its end first.")] : []),
    ...open.map((clause) => ground.isUnsure(found, clause.node)
      ? _("Look at what is suggested for “%(phrase)s”: say yes, or choose what is right.", clause)
      : isThing(clause) ? _("Show what “%(phrase)s” is, or choose “can't tell”.", clause)
      : _("Choose which part of the video shows “%(phrase)s”.", clause)),
  ];
  if (told.length || state.current === REVIEW || !proposals(found).length) return told;
  go(REVIEW);
  return [_("Look at what follows from your answers first: say yes, or choose what is right.")];
}

function proposals(found) {
  return clauses.filter(({ node }) => ground.isProposed(found, node));
}

if (mustWatch) {
  picture.requireWatching(work.state.watched_s !== undefined, (watched) => {
    work.change({ ...work.state, ...watched }, { silent: true });
    if (work.state.current === WATCH) goOn();
  });
  // Things can be clicked at the first moment.
  video.addEventListener("ended", () => {
    const clause = clauseOf(work.state);
    if (clause.node === WATCH || isThing(clause)) picture.seek(0);
  });
}
map.board.addEventListener("stopped", () => ask.querySelector('[data-key="mark"]')?.focus());

function moved(t) {
  map?.show(t);
  timeline?.at(t);
  drawer?.at();
}

function isDone(state, clause) {
  return clause.node === CUTS ? stages.every((stage) => ground.isSaid(state, stage)) : ground.isDone(state, clause);
}

function isHappening(clause) {
  return clause.type === "EVENT" || clause.type === "PATH";
}

function clauseOf(state) {
  return [...steps, cutting, reviewing].find((clause) => clause.node === state.current) ?? first;
}

/** The question after another one: the next that is open, then what follows from the answers; null if nothing is left. */
function questionAfter(node, state) {
  const found = full(state);
  const isStage = stages.some((stage) => stage.node === node);
  const inTurn = isStage ? [...stages, ...asked.filter((one) => one !== cutting)] : asked;
  return ground.nextOpen(inTurn, node, (clause) => isDone(found, clause)) ?? (proposals(found).length ? REVIEW : null);
}

function time_s() {
  return Math.round(picture.time * 10) / 10;
}

function nameOf(kind, id) {
  return kind === "object"
    ? `${LABELS.thing} ${scene.things.find((thing) => thing.id === id).number}`
    : `${LABELS.place} ${scene.zones.find((zone) => zone.id === id).letter}`;
}

/** Keep an answer, and go on where it is complete. */
function answer(next, said, isComplete) {
  const { current } = work.state;
  const to = isComplete ? questionAfter(current, next) : null;
  work.change({ ...next, current: to ?? current });
  if (to !== null) enter(current);
  announce(to === null ? said : `${said}. ${spoken()}`);
}

function choose(kind, id) {
  const clause = clauseOf(work.state);
  if (clause.node === WATCH || !isThing(clause)) return announce(_("This question isn't about a thing."));
  const toggle = kind === "object" ? ground.toggleObject : ground.togglePlace;
  const next = toggle(work.state, clause, id, time_s());
  const grounding = ground.groundingOf(next, clause.node);
  const isChosen = kind === "object" ? grounding.objects.includes(id) : grounding.places.some(({ place }) => place === id);
  answer(next, isChosen ? _("%(thing)s chosen", { thing: nameOf(kind, id) }) : _("%(thing)s not chosen", { thing: nameOf(kind, id) }), isChosen && !ground.isSeveral(next, clause));
}

function addPlace(xy) {
  const clause = clauseOf(work.state);
  answer(ground.addPlace(work.state, clause, { xy }, time_s()), _("Place marked"), !ground.isSeveral(work.state, clause));
}

function cantTell() {
  const next = ground.toggleCantTell(work.state, work.state.current, time_s());
  const { cant_tell } = ground.groundingOf(next, work.state.current);
  answer(next, cant_tell ? _("Can't tell") : _("Not can't tell"), cant_tell);
}

function confirm() {
  const { current } = work.state;
  const found = full(work.state);
  if (current === REVIEW) return $("submit").click();
  if (ground.isProposed(found, current)) {
    const { groundings, trims, whole } = work.state;
    const isWhole = ground.isWhole(found, current);
    const kept = found.groundings[current] ? { groundings: { ...groundings, [current]: found.groundings[current] } }
      : isWhole ? { whole: [...(whole ?? []), current] } : { trims: { ...trims, [current]: found.trims[current] } };
    answer(ground.confirmed({ ...work.state, ...kept }, current), _("Kept"), true);
  } else if (ground.isUnsure(work.state, current)) answer(ground.confirmed(work.state, current), _("Kept"), true);
}

/** The next step begins at this moment of the video. */
function cut() {
  const cuts = [...(work.state.cuts ?? []), time_s()];
  video.pause();
  complaint = "";
  if (cuts.at(-1) <= (cuts.at(-2) ?? 0) || cuts.at(-1) >= scene.duration_s) {
    complaint = _("It can’t begin at this moment: play on, and press when it does.");
    draw(work.state);
    return announce(complaint);
  }
  answer(ground.setCuts(work.state, stages, cuts, scene.duration_s), _("Set"), cuts.length + 1 === stages.length);
}

function cutAgain() {
  complaint = "";
  picture.seek(0);
  work.change(ground.setCuts(work.state, stages, [], scene.duration_s));
}

function setSeveral(is) {
  work.change(ground.setSeveral(work.state, work.state.current, is));
}

function setPart(part) {
  const { current } = work.state;
  if (isHappening(clauseOf(work.state))) work.change(ground.setPart(work.state, current, part));
}

function setEnd(i) {
  video.pause();
  timeline.set(i, picture.time);
  const { state } = work;
  if (state.trims[state.current]) answer(state, _("Set"), true);
}

/** Go to a clause; when it is about a thing again, to the moment at which things can be clicked. */
function go(node) {
  if (map.isMarking) map.stop(true);
  const before = work.state.current;
  work.change({ ...work.state, current: node }, { silent: true });
  enter(before);
  announce(spoken());
}

function enter(before) {
  const wasAboutVideo = before === CUTS || clauses.some((clause) => clause.node === before && isHappening(clause));
  if (wasAboutVideo && work.state.current !== CUTS && !isHappening(clauseOf(work.state)) && video.paused) picture.seek(0);
}

function goOn() {
  const { current } = work.state;
  go(questionAfter(current, work.state) ?? neighbour(steps, steps.some(({ node }) => node === current) ? current : steps[0].node, 1));
}

function spoken() {
  return ask.querySelector("h2").textContent;
}

const press = labelKeys(() => [...scene.things.map(({ number }) => number), ...scene.zones.map(({ letter }) => letter)], (label) => {
  const thing = scene.things.find(({ number }) => number === label);
  if (thing) choose("object", thing.id);
  else choose("place", scene.zones.find(({ letter }) => letter === label).id);
});

document.addEventListener("keydown", (event) => {
  if (!isShortcut(event) || map.isMarking) return;
  const key = event.key.toLowerCase();
  const clause = clauseOf(work.state);
  if (key === "[" || key === "]") go(neighbour(inOrder(full(work.state)), clause.node, key === "]" ? 1 : -1));
  else if (key === "e" && clause.node === CUTS) cut();
  else if (key === "x" && isThing(clause)) cantTell();
  else if (key === "y") confirm();
  else if (key === "m" && hasMap && isThing(clause)) map.startMarking();
  else if (key === "d" && drawer && isThing(clause)) startDrawing(true);
  else if (key === "s" && isThing(clause)) setSeveral(!ground.isSeveral(work.state, clause));
  else if (!isThing(clause) || !press(event.key)) return;
  event.preventDefault();
});

/** All questions, of things and of the video, in the order in which the keys go through them. */
function inOrder(state) {
  const at = steps.findIndex(({ type }) => type === "EVENT" || type === "PATH");
  const happening = at < 0 ? steps.length : at;
  return [...steps.slice(0, happening), ...(hasSteps ? [cutting] : []), ...steps.slice(happening), ...(proposals(state).length ? [reviewing] : [])];
}

/** What the question's buttons do. `state` is filled. */
function actsOn(clause, state) {
  const isReady = asked.every((one) => isDone(state, one)) && !proposals(state).length;
  const at = asked.findIndex((one) => one.node === clause.node);
  const during = clauses.find((one) => one.node === clause.during);
  const hasPart = during && asksParts && ground.isSaid(state, during);
  const cuts = state.cuts ?? [];
  return {
    cuts: {
      step: isDone(state, cutting) ? null : stages[cuts.length + 1],
      isSet: isDone(state, cutting),
      problem: complaint,
      here: cut,
      again: cuts.length ? cutAgain : null,
      single: () => go(stages[0].node),
    },
    proposals: proposals(state).map((one) => ({ clause: one, said: saidOf(state, one, scene), go: () => go(one.node) })),
    count: at < 0 ? "" : _("%(number)s of %(count)s", { number: at + 1, count: asked.length }),
    isReady,
    ready: _("All questions are answered. Look over the list, then press “%(button)s”.", { button: $("submit").textContent }),
    send: () => $("submit").click(),
    sendWord: $("submit").textContent,
    back: clause.node === REVIEW ? () => go(asked.at(-1).node) : at > 0 ? () => go(asked[at - 1].node) : null,
    next: isReady && at === asked.length - 1 ? null : at < 0 || isDone(state, clause) ? goOn : () => go(neighbour(asked, clause.node, 1)),
    play: () => video.play(),
    mark: hasMap ? map.startMarking : null,
    draw: drawer ? (event) => (drawer.isDrawing ? drawer.stop() : startDrawing(!event.detail)) : null,
    isDrawing: Boolean(drawer?.isDrawing),
    several: setSeveral,
    cantTell,
    confirm,
    chosen: saidOf(state, clause, scene),
    unmark: (i) => work.change(ground.removePlace(work.state, clause.node, i, time_s())),
    steps: scene.steps.map(([from, to]) => [from, Math.min(to, scene.duration_s)]),
    part: (part) => answer(ground.setPart(work.state, clause.node, part), _("Set"), true),
    starts: () => setEnd(0),
    ends: () => setEnd(1),
    whole: () => answer(ground.setWhole(work.state, clause.node), _("The whole video"), true),
    same: hasPart && !ground.isProposed(state, clause.node) ? { phrase: during.phrase, act: () => answer(asDuring(full(work.state), clause.node, during.node), _("The same part"), true) } : null,
  };
}

function asDuring(found, node, during) {
  return found.trims[during] ? ground.setPart(work.state, node, found.trims[during]) : ground.setWhole(work.state, node);
}

/** By a key a box begins in the middle of the picture. */
function startDrawing(isByKey) {
  drawer.draw(isByKey);
  draw(work.state);
  announce(isByKey ? _("A box is in the middle of the picture. Arrows move it, with Shift they resize it. Enter keeps it.") : _("Draw a box around it."));
}

function draw(answers) {
  scene.things.splice(0, Infinity, ...marked, ...asThings(answers.drawn ?? [], marked.length));
  const state = full(answers);
  const clause = clauseOf(state);
  if (!clause) return;
  const isAboutThing = isThing(clause);
  const grounding = ground.groundingOf(state, clause.node);
  showCommand(typeof clause.node === "number" ? clause.node : clause.node === CUTS ? stages[(state.cuts ?? []).length + 1]?.node ?? null : null);
  picture.mark(grounding.objects);
  drawer?.show(answers.drawn ?? [], grounding.objects);
  map.prefer(clause.type === "PLACE" ? "place" : "object");
  map.mark(
    grounding.objects,
    grounding.places.map((place) => place.place),
    grounding.places.filter((place) => place.xy).map((place) => place.xy),
  );
  redraw(words, ...question(clause, state, actsOn(clause, state)));
  timeline.element.hidden = !isHappening(clause);
  timeline.show(ground.partOf(state, clause.node));
  redraw(list, stepList({ steps: inOrder(state), state, scene, done: (one) => isDone(state, one), go }));
  showCurrent();
  redraw(lists, isAboutThing ? chips(grounding) : []);
  lists.hidden = !isAboutThing;
  document.body.classList.toggle("all-done", asked.every((one) => isDone(state, one)) && !proposals(state).length);
}

/** Scroll the list, and not the page, to the current question. */
function showCurrent() {
  const at = list.querySelector("[aria-current]");
  if (!at || list.scrollHeight <= list.clientHeight) return;
  const [box, own] = [list.getBoundingClientRect(), at.getBoundingClientRect()];
  if (own.top < box.top) list.scrollTop += own.top - box.top;
  else if (own.bottom > box.bottom) list.scrollTop += own.bottom - box.bottom;
}

/** All things and places by their labels: for keys, and for who can't click in the picture. */
function chips(grounding) {
  const chip = (kind, id, label, name, checked) => {
    const box = h("input", { type: "checkbox", "aria-label": name, "data-key": `${kind} ${id}`, onchange: () => choose(kind, id) });
    box.checked = checked;
    return h("label", { class: `chip ${kind}` }, box, h("span", { "aria-hidden": "true" }, label));
  };
  const robot = (thing) => (thing.isRobot ? ` (${LABELS.robot})` : "");
  return [
    h("fieldset", {}, h("legend", {}, _("Things")), scene.things.map((thing) =>
      chip("object", thing.id, `${thing.number}${robot(thing)}`, `${nameOf("object", thing.id)}${robot(thing)}`, grounding.objects.includes(thing.id)))),
    scene.zones.length ? h("fieldset", {}, h("legend", {}, _("Places")), scene.zones.map((zone) =>
      chip("place", zone.id, zone.letter, nameOf("place", zone.id), grounding.places.some((p) => p.place === zone.id)))) : null,
  ].filter(Boolean);
}
