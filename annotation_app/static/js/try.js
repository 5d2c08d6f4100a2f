// Trying a command: what it means, the plan, and the video of it.

import { $, announce, h, s } from "./dom.js";
import { labelLayer, unitOf } from "./label-layer.js";
import { boxAround } from "./labels.js";
import { here, send } from "./server.js";

const LOOK_MS = 700;
const PHASES = {
  waiting: "Waiting for those who came before",
  learning: "Getting the model ready; the very first time it is trained, which takes some minutes",
  reading: "Looking for what the words mean",
  moving: "Carrying the plan out in the simulated world",
  drawing: "Filming what happened",
};
const letter = (number) => String.fromCharCode(65 + (number % 26));
const percent = (share) => (share > 0 && share < 0.005 ? "< 1 %" : `${Math.round(100 * share)} %`);

let current = null; // the attempt that is shown
let chosen = null; // the clause whose candidates are shown in the picture

$("ask").addEventListener("submit", (event) => {
  event.preventDefault();
  begin({ scenario: $("scenario").value, text: $("text").value });
});

const showScene = () => { $("scene").src = here(`/try/scenes/${$("scenario").value}`); };
$("scenario").addEventListener("change", showScene);
showScene(); // browsers keep what was chosen before a page was loaded again
$("go").disabled = false;

async function begin(asked) {
  current = null;
  chosen = null;
  $("found").replaceChildren();
  complain("");
  busy({ phase: "waiting", done: 0, total: 0 });
  const { status, data } = await send("POST", "/api/try", asked).catch(() => ({ status: 0, data: {} }));
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
  } else if (status >= 400 && status !== 429 && status < 500) {
    busy(null);
    complain(data.error);
    return;
  }
  setTimeout(() => follow(id, seen), LOOK_MS);
}

const what = (state) => [state.plan !== null, state.picture !== null, state.phase === "done"].join();

function complain(message) {
  $("problem").replaceChildren(...(message ? [h("p", { class: "problem" }, message)] : []));
}

function busy(state) {
  $("under-way").hidden = !state;
  $("go").disabled = Boolean(state);
  if (!state) return;
  const words = PHASES[state.phase] ?? "";
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

function show(id, state) {
  const { plan, picture, asked } = state;
  if (!plan) return;
  const clauses = plan.clauses;
  if (!clauses.some((clause) => clause.node === chosen)) chosen = clauses[0]?.node ?? null;
  const draw = () => {
    $("found").replaceChildren(
      section("What the robot does", ...steps(plan), insisting(plan, asked), question(plan, asked)),
      section("What the words mean", tree(id, clauses), ...meanings(clauses, draw, picture)),
      picture ? section("What is where", ...shownPicture(id, picture, clauses)) : "",
      state.phase === "done" && picture ? section("What happened", film(id)) : "",
    );
  };
  draw();
  if (state.phase === "done") announce(picture ? "The video is ready." : plan.note);
}

const section = (title, ...parts) => h("section", { class: "card", "aria-label": title }, h("h2", {}, title), ...parts);

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
  const known = plan.clauses.find((clause) => clause.node === plan.node)?.candidates ?? [];
  const named = (thing) => {
    const number = known.findIndex((candidate) => candidate.things.join() === `object ${thing}`);
    return number < 0 ? thing : `${letter(number)}, ${thing}`;
  };
  const options = plan.options.map(([thing, words]) =>
    h("button", { type: "button", onclick: () => answer(thing) }, `${words} (${named(thing)})`));
  return h("div", { class: "stack" }, h("p", { dir: "auto" }, plan.question), h("div", { class: "row" }, options));
}

function tree(id, clauses) {
  const alt = clauses.map((clause) => `${clause.type} “${clause.text}”`).join(", ");
  return h("div", { class: "drawing", tabindex: 0, role: "group", "aria-label": "The clauses as a tree" },
    h("img", { src: here(`/try/${id}/tree.svg`), alt: alt ? `Among them: ${alt}` : "There are no clauses." }));
}

function meanings(clauses, draw, picture) {
  return clauses.map((clause) => {
    const isChosen = clause.node === chosen;
    const choose = () => {
      chosen = clause.node;
      draw();
      document.querySelector(`[data-node="${clause.node}"]`)?.focus();
    };
    return h("div", { class: `meaning type-${clause.type}` },
      h("button", { type: "button", class: "clause", "data-node": clause.node, "aria-pressed": String(isChosen), disabled: !picture, onclick: choose },
        h("b", {}, clause.type), ` ${clause.text}`),
      h("ul", {}, clause.candidates.map((candidate, number) =>
        h("li", {}, h("b", {}, letter(number)), ` ${candidate.words}: ${percent(candidate.probability)}`))));
  });
}

function shownPicture(id, picture, clauses) {
  const clause = clauses.find((one) => one.node === chosen);
  const layer = s("svg", { class: "outlines", viewBox: `0 0 ${picture.width} ${picture.height}`, "aria-hidden": "true" });
  const caps = labelLayer();
  const labels = [];
  // The likeliest lies on top.
  const candidates = clause?.candidates ?? [];
  for (let number = candidates.length - 1; number >= 0; number--) {
    for (const thing of candidates[number].things) {
      const polygons = picture.outlines[thing];
      if (!polygons?.length) continue;
      const d = polygons.map((corners) => `M${corners.map((xy) => xy.join(",")).join("L")}Z`).join("");
      layer.append(s("g", { class: number ? "thing" : "thing chosen" }, s("path", { class: "shape", d })));
      const text = `${letter(number)} ${percent(candidates[number].probability)}`;
      labels.unshift({ id: `${number} ${thing}`, kind: "object", text, box: boxAround(polygons[0]), isChosen: !number });
    }
  }
  layer.append(caps.element);
  const frame = { x: 0, y: 0, w: picture.width, h: picture.height };
  new ResizeObserver(() => unitOf(layer) && caps.put(labels, frame, unitOf(layer))).observe(layer);
  const caption = clause
    ? `What “${clause.text}” may mean, as the world is at the start. The likeliest is yellow.`
    : "The world at the start.";
  return [
    h("div", { class: "screen" }, h("img", { src: here(`/try/${id}/picture.png`), alt: "The world at the start", width: picture.width, height: picture.height }), layer),
    h("p", { class: "note" }, caption),
  ];
}

function film(id) {
  return h("div", { class: "screen" },
    h("video", { src: here(`/try/${id}/video.mp4`), controls: true, muted: true, playsinline: true, preload: "auto", "aria-label": "The robot carries the plan out" }));
}
