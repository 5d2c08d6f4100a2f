// Trying a command: the world at its start, what the command means, the plan, and a video of it.

import { $, announce, h, s } from "./dom.js";
import { labelLayer, unitOf } from "./label-layer.js";
import { boxAround } from "./labels.js";
import { here, send } from "./server.js";

const LOOK_MS = 250;
const MARGIN_M = 2;
const ASPECT = 4 / 3;
const NARROW_PX = 500; // below, names would cover one another
const PHASES = {
  waiting: "Waiting until the model is ready, or for those who came before",
  queued: "The plan is there. Its video waits for those that came before",
  learning: "Getting the model ready; the very first time it is trained, which takes some minutes",
  reading: "Looking for what the words mean",
  moving: "Carrying the plan out in the simulated world",
  drawing: "Filming what happened",
};
const LATER = [429, 502, 503, 504];
/** Whether asking again is of no use. */
const isRefused = (status) => status >= 400 && !LATER.includes(status);
const FAILED = "Something went wrong on the server. Try again.";
const percent = (share) => (share > 0 && share < 0.005 ? "< 1 %" : `${Math.round(100 * share)} %`);

let current = null; // the attempt that is shown
let chosen = null; // the clause whose candidates are marked
let world = null; // the scene that is shown

$("ask").addEventListener("submit", (event) => {
  event.preventDefault();
  begin({ scenario: $("scenario").value, text: $("text").value });
});
$("scenario").addEventListener("change", () => {
  current = null;
  clear();
  look();
});
look(); // browsers keep what was chosen before a page was loaded again
$("go").disabled = false;

function clear() {
  chosen = null;
  $("found").replaceChildren();
  $("film").hidden = true;
  complain("");
  busy(null);
}

/** Show the scenario's world, as soon as there is a picture of it. */
async function look() {
  const scenario = $("scenario").value;
  world = null;
  $("picture").hidden = false;
  $("picture").replaceChildren(h("p", { class: "note" }, "The picture is being made."));
  $("map").replaceChildren();
  $("key").replaceChildren();
  for (;;) {
    const { status, data } = await send("GET", `/api/try/scenes/${scenario}`).catch(() => ({ status: 0, data: {} }));
    if (scenario !== $("scenario").value) return;
    if (status === 200 || (status === 202 && !world)) {
      world = data;
      mark(null);
    }
    if (status === 200) {
      $("picture").hidden = !world.width;
      return;
    }
    if (isRefused(status)) {
      $("picture").hidden = !world;
      return complain(data.error ?? FAILED);
    }
    await new Promise((done) => setTimeout(done, LOOK_MS));
  }
}

/** Draw the world's picture and map; what a plan's chosen clause may mean is marked in both. */
function mark(plan) {
  if (!world) return;
  const candidates = plan?.clauses.find((clause) => clause.node === chosen)?.candidates ?? [];
  const share = new Map();
  for (const { things, probability } of candidates) {
    for (const thing of things) share.set(thing, Math.max(probability, share.get(thing) ?? 0));
  }
  const likeliest = new Set(candidates[0]?.things ?? []);
  const isNamed = new Set(world.places.map(({ name }) => name));
  const places = (plan?.places ?? []).map((place, i) => ({ ...place, key: `place ${i}`, id: isNamed.has(place.name) ? place.name : `place ${i}` }));
  const inPlan = places.filter(({ key }) => share.has(key));
  const isMeant = new Set(inPlan.map(({ id }) => id));
  const things = world.things.map((thing) => ({ ...thing, key: `object ${thing.id}`, id: `object ${thing.id}`, kind: "object" }));
  const others = world.places.map((place) => ({ ...place, key: place.name, id: place.name }));
  const numbers = new Map([...new Set([...things, ...others, ...places].map(({ id }) => id))].map((id, i) => [id, i + 1]));
  const shapes = [
    ...things,
    ...[...others.filter(({ id }) => !isMeant.has(id)), ...inPlan].map((place) => ({ ...place, kind: "place", outlines: [place.outline] })),
  ].map((shape) => {
    const part = share.has(shape.key) ? percent(share.get(shape.key)) : "";
    const isUnnamed = shape.kind === "place" && !isNamed.has(shape.name);
    const text = `${shape.name} ${part}`.trim();
    return { ...shape, isChosen: likeliest.has(shape.key), part, text, short: isUnnamed ? part : text, number: numbers.get(shape.id) };
  });
  if (world.width) {
    const frame = { x: 0, y: 0, w: world.width, h: world.height };
    const inPicture = shapes.map((shape) => ({ ...shape, parts: shape.outlines.filter((part) => part.length) }));
    $("picture").replaceChildren(
      h("img", { src: here(`/try/scenes/${$("scenario").value}`), alt: "", width: world.width, height: world.height }),
      drawing("outlines", frame, inPicture),
    );
  }
  const onMap = shapes.map((shape) => ({ ...shape, parts: [shape.footprint.map(([x, y]) => [x, -y])] }));
  const around = boxAround(onMap.flatMap(({ parts }) => parts[0]));
  const [w, tall] = [around.w + 2 * MARGIN_M, around.h + 2 * MARGIN_M];
  const wide = Math.max(w, tall * ASPECT);
  const frame = { x: around.x - MARGIN_M - (wide - w) / 2, y: around.y - MARGIN_M, w: wide, h: tall };
  $("map").replaceChildren(drawing("map", frame, onMap));
  $("key").replaceChildren(...explained(shapes));
}

/** Labels of what a clause may mean have the best spots, then those of places. */
const rank = ({ isChosen, part, kind }) => (isChosen ? 0 : part ? 1 : kind === "place" ? 2 : 3);

/** What the numbers stand for; things of the same name share a line. */
function explained(shapes) {
  const lines = new Map();
  for (const shape of [...shapes].sort((a, b) => rank(a) - rank(b))) {
    const key = `${shape.text} ${shape.isChosen}`;
    lines.set(key, { ...shape, all: [...(lines.get(key)?.all ?? []), shape.number] });
  }
  return [...lines.values()].map(({ text, all, isChosen }) => h("li", { class: isChosen ? "chosen" : "" }, h("b", {}, all.join(", ")), ` ${text}`));
}

/** Shapes over a picture or on a map, with their names, or with numbers where these have no room. */
function drawing(kind, frame, shapes) {
  const layer = s("svg", { class: kind, viewBox: `${frame.x} ${frame.y} ${frame.w} ${frame.h}`, "aria-hidden": "true" });
  const seen = shapes.filter(({ parts }) => parts.length);
  for (const { kind: sort, isChosen, is_robot: isRobot, parts } of [...seen].sort((a, b) => a.isChosen - b.isChosen)) {
    const d = parts.map((corners) => `M${corners.map((xy) => xy.join(",")).join("L")}Z`).join("");
    const of = `${sort === "place" ? "zone" : "thing"}${isChosen ? " chosen" : ""}${isRobot ? " robot" : ""}`;
    layer.append(s("g", { class: of }, s("path", { class: sort === "place" ? "place-shape" : "shape", d })));
  }
  const caps = labelLayer();
  layer.append(caps.element);
  const sorted = [...seen].sort((a, b) => rank(a) - rank(b));
  const put = () => {
    const unit = unitOf(layer);
    if (!unit) return;
    const isNarrow = layer.getBoundingClientRect().width < NARROW_PX;
    $("key").hidden = !isNarrow;
    const isAsked = sorted.some(({ part }) => part);
    const labels = sorted.map(({ id, kind: sort, short, number, part, parts, isChosen }) =>
      ({ id, kind: sort, text: isNarrow ? String(number) : short, box: boxAround(parts[0]), isChosen, isMinor: isAsked && !part }));
    caps.put(labels, frame, unit);
  };
  new ResizeObserver(put).observe(layer);
  return layer;
}

async function begin(asked) {
  const leaves = current ?? "";
  current = null;
  clear();
  mark(null);
  busy({ phase: "waiting", done: 0, total: 0 });
  const { status, data } = await send("POST", "/api/try", { ...asked, leaves }).catch(() => ({ status: 0, data: {} }));
  if (status !== 200) {
    busy(null);
    complain(data.error ?? "The server can't be reached. Try again.");
    return;
  }
  current = data.id;
  follow(data.id, "");
}

/** Look at an attempt until it is done; `before` is what was shown of it. */
async function follow(id, before) {
  if (current !== id) return;
  const { status, data } = await send("GET", `/api/try/${id}`).catch(() => ({ status: 0, data: {} }));
  if (current !== id) return;
  const seen = status === 200 ? what(data) : before;
  if (status === 200) {
    const isOver = data.phase === "done" || (data.problem && data.phase !== "drawing");
    busy(isOver ? null : data);
    complain(data.problem);
    if (seen !== before) show(id, data);
    if (isOver) return;
  } else if (isRefused(status)) {
    busy(null);
    complain(data.error ?? FAILED);
    return;
  }
  setTimeout(() => follow(id, seen), LOOK_MS);
}

const what = (state) => [state.plan !== null, state.phase === "done"].join();

function complain(message) {
  $("problem").hidden = !message;
  $("problem").replaceChildren(...(message ? [h("p", { class: "problem" }, message)] : []));
}

function busy(state) {
  $("go").disabled = Boolean(state) && !state.plan; // the next one needn't wait for a video
  $("under-way").hidden = !state;
  if (!state) return;
  $("film").hidden = false;
  $("film").querySelector(".screen")?.remove();
  const words = PHASES[state.phase === "waiting" && state.plan ? "queued" : state.phase] ?? "";
  if ($("phase").textContent !== words) {
    $("phase").textContent = words;
    announce(words);
  }
  const bar = $("progress");
  if (state.total) {
    bar.max = state.total;
    bar.value = state.done;
  } else bar.removeAttribute("value");
}

function show(id, { plan, asked, phase, has_video: hasVideo }) {
  if (phase === "done") {
    $("film").hidden = !hasVideo;
    if (hasVideo) $("film").append(film(id));
    announce(hasVideo ? "The video is ready." : plan?.note ?? "");
  }
  if (!plan) return;
  const clauses = plan.clauses;
  if (!clauses.some((clause) => clause.node === chosen)) chosen = clauses[0]?.node ?? null;
  const draw = () => {
    mark(plan);
    $("found").replaceChildren(
      section("", "What the robot does", ...steps(plan), insisting(plan, asked), question(plan, asked),
        clauses.length ? h("h2", {}, "What the words mean") : null,
        clauses.length ? h("p", { class: "note" }, "Choose words to see what they may mean. The likeliest is yellow in the picture and on the map.") : null,
        h("div", { class: "meanings" }, meanings(clauses, draw))),
      section(" all", "The clauses", tree(id, clauses)),
    );
  };
  draw();
}

const section = (kind, title, ...parts) => h("section", { class: `card${kind}`, "aria-label": title }, h("h2", {}, title), ...parts);

function steps(plan) {
  if (!plan.steps.length) return [h("p", { class: "problem" }, plan.missing.length ? `${plan.note}.` : `Nothing: ${plan.note}.`)];
  return [
    h("ol", {}, plan.steps.map((step) => h("li", {}, step))),
    h("p", { class: "quiet" }, `The probability that this was meant: ${percent(plan.probability)}.`),
  ];
}

/** Where something isn't there, the plan is made with what there is only if somebody wants that. */
function insisting(plan, asked) {
  if (!plan.missing.length) return null;
  const missing = plan.missing.map((noun) => `no ${noun}`).join(" and ");
  if (plan.steps.length) return h("p", { class: "note" }, `There is ${missing} here: this is done with what there is.`);
  const insist = () => begin({ ...asked, insist: true });
  return h("p", { class: "row" }, h("button", { type: "button", onclick: insist }, "Do it with what there is"));
}

function question(plan, asked) {
  if (!plan.question) return null;
  const answer = (thing) => begin({ ...asked, answers: { ...asked.answers, [plan.node]: thing } });
  const options = plan.options.map(([thing, words]) =>
    h("button", { type: "button", onclick: () => answer(thing) }, `${words} (${thing})`));
  const words = h("input", { type: "text", maxlength: 200, "aria-label": "Answer in words", placeholder: "or in words: both, the one by the cone, neither" });
  const reply = (event) => {
    event.preventDefault();
    if (words.value.trim()) answer(words.value.trim());
  };
  return h("div", { class: "stack" }, h("p", { dir: "auto" }, plan.question), h("div", { class: "row" }, options),
    h("form", { class: "row", onsubmit: reply }, words, h("button", {}, "Answer")));
}

function tree(id, clauses) {
  const alt = clauses.map((clause) => `${clause.type} “${clause.text}”`).join(", ");
  return h("div", { class: "drawing tree", tabindex: 0, role: "group", "aria-label": "The clauses as a tree" },
    h("img", { src: here(`/try/${id}/tree.svg`), alt: alt ? `Among them: ${alt}` : "There are no clauses." }));
}

function meanings(clauses, draw) {
  return clauses.map((clause) => {
    const choose = () => {
      chosen = clause.node;
      draw();
      document.querySelector(`[data-node="${clause.node}"]`)?.focus();
    };
    return h("div", { class: `meaning type-${clause.type}` },
      h("button", { type: "button", class: "clause", "data-node": clause.node, "aria-pressed": String(clause.node === chosen), onclick: choose },
        h("b", {}, clause.type), ` ${clause.text}`),
      h("ul", {}, clause.candidates.map(({ words, probability }) => h("li", {}, `${words} `, h("b", {}, percent(probability))))));
  });
}

function film(id) {
  return h("div", { class: "screen" },
    h("video", { src: here(`/try/${id}/video.mp4`), controls: true, muted: true, playsinline: true, preload: "auto", "aria-label": "The robot carries the plan out" }));
}
