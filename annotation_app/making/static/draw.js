// Drawing what is where in a video: the surface over the player, the list of things, and keeping them.

import { cornersOf, drawing } from "../../../static/js/drawing.js";
import { polygonsAt } from "../../../static/js/paths-of-things.js";
import { equip } from "../../../static/js/player.js";
import { number } from "../../../static/js/speech.js";

const SAVE_AFTER_MS = 500;
const SAME_S = 0.002;

const $ = (id) => document.getElementById(id);
const box = $("draw");
const data = JSON.parse($("drawn").textContent);
const film = box.querySelector("video");
const frame = box.querySelector(".player");

// Things are {id, name, is_box, moments: [{time_s, polygons, is_keyframe}]}, moments ascending; nothing is
// changed in place, so that earlier states can come back.
let things = data.things;
let past = [];
let future = [];
let following = null; // the request that carries things on, if one does

function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children.filter((child) => child !== null));
  return element;
}

// Where a thing is at a moment

const now = () => {
  const t = film?.currentTime ?? 0;
  return t < 0.5 / (data.fps || 25) ? 0 : Math.round(t * 1000) / 1000;
};

function shapeAt(thing, t, place) {
  const polygons = polygonsAt(thing.moments, t);
  if (!polygons) return null;
  const [first, ...others] = polygons;
  const about = { id: thing.id, name: thing.name, number: place + 1 };
  if (thing.is_box) return { ...about, kind: "box", points: [first[0], first[2]] };
  return { ...about, kind: "outline", points: first, ...(others.length && { others }) };
}
const shapesAt = (t) => things.map((thing, place) => shapeAt(thing, t, place)).filter(Boolean);
const polygonsOf = (shape) => [cornersOf(shape), ...(shape.others ?? [])];

/** A thing with other polygons at a moment: what was carried on from before ends at the next keyframe. */
function corrected(thing, t, polygons) {
  const before = thing.moments.filter((moment) => moment.time_s < t - SAME_S);
  const after = thing.moments.filter((moment) => moment.time_s > t + SAME_S);
  const next = after.findIndex((moment) => moment.is_keyframe);
  const kept = next < 0 ? [] : after.slice(next);
  const time_s = before.length || t ? t : 0;
  return { ...thing, moments: [...before, { time_s, polygons, is_keyframe: true }, ...kept] };
}
const wasCarried = ({ moments }) => moments.some((moment) => !moment.is_keyframe);

// Changes

function put(next, goesOn = false) {
  if (!goesOn) past.push(things);
  future = [];
  things = next;
  show();
  save();
}
function travel(from, to) {
  if (!from.length) return;
  stop();
  to.push(things);
  things = from.pop();
  show();
  save();
}

const surface = drawing({
  width: data.width,
  height: data.height,
  label: `What is where in ${data.video}`,
  shapes: shapesAt(0),
  changed,
  chose: (id) => mark(id),
  named: (id) => $(`name-${id}`)?.select(),
  history: {
    undo: () => travel(past, future),
    redo: () => travel(future, past),
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
  },
});

function changed(shapes, goesOn) {
  const t = now();
  const drawn = new Map(shapes.map((shape) => [shape.id, shape]));
  const shown = new Set(shapesAt(t).map((shape) => shape.id));
  const carried = [];
  const next = things.filter((thing) => drawn.has(thing.id) || !shown.has(thing.id)).map((thing) => {
    const shape = drawn.get(thing.id);
    if (!shape || JSON.stringify(polygonsOf(shape)) === JSON.stringify(polygonsOf(shapeAt(thing, t, 0)))) return thing;
    if (wasCarried(thing)) carried.push(thing.id);
    return corrected(thing, t, polygonsOf(shape));
  });
  const known = new Set(things.map((thing) => thing.id));
  for (const shape of shapes) {
    if (known.has(shape.id)) continue;
    const moment = { time_s: t, polygons: polygonsOf(shape), is_keyframe: true };
    next.push({ id: shape.id, name: "", is_box: shape.kind === "box", moments: [moment] });
  }
  put(next, goesOn);
  if (carried.length) soon(() => follow(carried));
}

let waiting = 0;
function soon(what) {
  clearTimeout(waiting);
  waiting = setTimeout(what, 2 * SAVE_AFTER_MS);
}

function rename(id, name) {
  if (things.find((thing) => thing.id === id)?.name === name) return;
  put(things.map((thing) => (thing.id === id ? { ...thing, name } : thing)));
}

// The list

function row(thing, place) {
  const input = make("input", { id: `name-${thing.id}`, value: thing.name, placeholder: "thing", maxLength: 200, autocomplete: "off" });
  input.setAttribute("list", "names");
  input.setAttribute("aria-label", `Name of thing ${place + 1}`);
  input.addEventListener("focus", () => surface.choose(thing.id));
  input.addEventListener("change", () => rename(thing.id, input.value.trim()));
  input.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    rename(thing.id, input.value.trim());
    surface.element.querySelector(`[data-id="${CSS.escape(thing.id)}"]`)?.focus();
  });
  const remove = make("button", { type: "button", textContent: "×", className: "remove" });
  remove.setAttribute("aria-label", `Delete thing ${place + 1}`);
  remove.addEventListener("click", () => put(things.filter((one) => one.id !== thing.id)));
  const item = make("li", {}, make("span", { className: "cap-number", textContent: place + 1 }), input, remove);
  item.dataset.id = thing.id;
  const first = thing.moments[0].time_s;
  const last = thing.moments.at(-1).time_s;
  if (first || last) {
    const go = make("button", { type: "button", className: "link", textContent: last > first ? `${number(first)} to ${number(last)} s` : `at ${number(first)} s` });
    go.setAttribute("aria-label", `Thing ${place + 1}: ${go.textContent}. Show it`);
    go.addEventListener("click", () => seek(first));
    item.append(go);
  }
  return item;
}

function show() {
  const focused = document.activeElement?.id;
  const typed = document.activeElement?.value;
  surface.put(shapesAt(now()));
  $("things").replaceChildren(...things.map(row));
  if (focused?.startsWith("name-") && $(focused)) {
    $(focused).focus();
    if (document.activeElement.value !== typed) document.activeElement.select();
  }
  $("none").hidden = things.length > 0;
  if ($("following")) $("following").hidden = !things.length;
  const known = new Set([...$("names").options].map((option) => option.value));
  for (const { name } of things) if (name && !known.has(name)) $("names").append(make("option", { value: name }));
  const count = document.querySelector(".films [aria-current] .note");
  if (count) count.textContent = things.length ? `${things.length} ${things.length === 1 ? "thing" : "things"}` : "Draw";
  mark(surface.chosen);
}
function mark(id) {
  for (const item of $("things").children) item.classList.toggle("chosen", item.dataset.id === id);
}

// Carrying things on

async function post(address, body, more = {}) {
  const reply = await fetch(address, {
    method: "POST",
    headers: { "X-CSRFToken": box.dataset.token, "Content-Type": "application/json", Accept: "application/json" },
    body: JSON.stringify(body),
    ...more,
  });
  const told = await reply.json().catch(() => ({}));
  if (!reply.ok) throw Object.assign(new Error(told.error ?? `The server refused it (${reply.status}).`), { status: reply.status });
  return told;
}

function stop() {
  following?.abort();
  following = null;
  if ($("follow")) $("follow").textContent = "Follow them to the end";
}

/** Carry things that are seen now on to the end, or to where somebody has corrected them. */
async function follow(ids) {
  stop();
  const from = now();
  let left = things.filter((thing) => ids.includes(thing.id) && polygonsAt(thing.moments, from))
    .map((thing) => ({ id: thing.id, polygons: polygonsAt(thing.moments, from) }));
  if (!left.length) return;
  const { signal } = (following = new AbortController());
  $("follow").textContent = "Stop";
  const lost = [];
  past.push(things);
  future = [];
  things = things.map((thing) => {
    const one = left.find(({ id }) => id === thing.id);
    return one ? corrected(thing, from, one.polygons) : thing;
  });
  try {
    for (let t = from, isEnd = false; left.length && !isEnd;) {
      $("followed").textContent = `Following: ${number(t)} of ${number(data.duration_s)} s`;
      const told = await post(data.follow, { start_s: t, outlines: left.map((one) => one.polygons) }, { signal });
      left = left.map((one, i) => ({ ...one, ...carriedOn(one, told.things[i], told.lost_s[i], lost) })).filter((one) => !one.isDone);
      show();
      [t, isEnd] = [told.until_s, told.is_end];
    }
    $("followed").textContent = lost.length
      ? `${lost.map(({ place, t }) => `Thing ${place} was lost at ${number(t)} s`).join(", ")}. Go there and correct it: it goes on from there.`
      : "Followed to the end. Play the video, and correct what is wrong: it goes on from there.";
  } catch (error) {
    if (signal.aborted) $("followed").textContent = "Stopped.";
    else $("followed").textContent = error instanceof TypeError ? "There is no network. Try again." : error.message;
  }
  if (following?.signal === signal) stop();
  save();
}

/** Take what was found of a thing, up to its next keyframe; where it goes on from. */
function carriedOn({ id }, moments, lostS, lost) {
  const place = things.findIndex((thing) => thing.id === id);
  if (place < 0) return { isDone: true };
  const thing = things[place];
  const start = moments[0]?.time_s ?? 0;
  const key = thing.moments.find((moment) => moment.is_keyframe && moment.time_s > start)?.time_s ?? Infinity;
  const taken = moments.filter((moment) => moment.time_s < key - SAME_S);
  const all = [...thing.moments, ...taken].sort((a, b) => a.time_s - b.time_s);
  things = things.with(place, { ...thing, moments: all });
  if (lostS !== null && lostS < key) lost.push({ place: place + 1, t: lostS });
  return { polygons: taken.at(-1)?.polygons, isDone: lostS !== null || taken.length < moments.length || !taken.length };
}

// Keeping

let state = data.state;
let isDirty = false;
let isSaving = false;
let timer = 0;

function save() {
  isDirty = true;
  $("kept").textContent = "";
  clearTimeout(timer);
  timer = setTimeout(send, SAVE_AFTER_MS);
}
async function send() {
  if (isSaving || !isDirty) return;
  isSaving = true;
  isDirty = false;
  try {
    ({ state } = await post(data.save, { video: data.video, state, things }));
    if (!isDirty) $("kept").textContent = "Saved.";
  } catch (error) {
    isDirty = true;
    $("kept").textContent = `Not saved: ${error instanceof TypeError ? "there is no network." : error.message}`;
    if (error instanceof TypeError) timer = setTimeout(send, 10 * SAVE_AFTER_MS);
    isSaving = false;
    return;
  }
  isSaving = false;
  if (isDirty) send();
}
addEventListener("beforeunload", (event) => {
  if (isDirty || isSaving) {
    send();
    event.preventDefault();
  }
});
document.addEventListener("visibilitychange", () => document.hidden && send());

// The page

function seek(t) {
  film.pause();
  film.currentTime = t;
}
frame.querySelector(".screen").append(surface.element);
$("tools").append(surface.tools, make("details", {}, make("summary", { textContent: "Keys" }), surface.help));
surface.use("box");
if (film) {
  equip(frame, () => surface.put(shapesAt(now())));
  const play = () => {
    surface.put(shapesAt(now()));
    if (!film.paused) requestAnimationFrame(play);
  };
  film.addEventListener("play", play);
  surface.element.addEventListener("pointerdown", () => film.pause(), { capture: true });
  surface.element.addEventListener("keydown", () => film.pause(), { capture: true });
  $("follow").addEventListener("click", () => (following ? stop() : follow(things.map((thing) => thing.id))));
}
show();
