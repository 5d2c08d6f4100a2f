// Check: does a clause match what was drawn at random for it?

import { $, announce, choice, h, isShortcut, redraw } from "./dom.js";
import { clauseBar, neighbour, showCommand } from "./clauses.js";
import { showMap } from "./map.js";
import { showPicture } from "./picture.js";
import { checkFeedback, different } from "./practice.js";
import { numbered } from "./scene.js";
import { begin, data, payload } from "./work.js";
import { _, listed, pieces } from "./speech.js";

const { clauses } = payload;
const VERDICTS = [
  [true, _("It matches"), "y"],
  [false, _("It doesn't match"), "n"],
  ["cant_tell", _("Can't tell"), "x"],
];

const views = payload.scenes.map(() => null);
const bar = h("div", { class: "steps" });
const stage = h("div", { class: "stage-of-one" });
const panel = h("section", { class: "panel ask", "aria-label": _("Whether it matches") });
$("editor").append(panel, stage, bar);

const work = begin({
  initial: { verdicts: {}, current: clauses[0]?.node },
  draw,
  body: ({ verdicts, watched = {}, speed }) => {
    const times = Object.values(watched);
    return { verdicts, watched_s: times.length ? times.reduce((a, b) => a + b) : undefined, speed };
  },
  problems: ({ verdicts, watched = {} }) => [
    ...clauses.filter((c) => isShownByVideo(c) && watched[c.shown.scene] === undefined)
      .map((c) => _("Watch the video for “%(phrase)s” to its end first.", c)),
    ...clauses.filter((c) => verdicts[c.node] === undefined).map((c) => _("Tell whether “%(phrase)s” matches.", c)),
  ],
  feedback: checkFeedback,
  explain: (state, right) => different(clauses, state, right),
});

/** Whether the question is about a video, not about things in it. */
function isShownByVideo({ shown }) {
  return !shown.objects.length && !shown.places.length && Boolean(payload.scenes[shown.scene].video);
}

function watched(index, { watched_s, speed }) {
  const { state } = work;
  const all = { ...state.watched, [index]: watched_s };
  work.change({ ...state, watched: all, speed: Math.max(speed, state.speed ?? 0) }, { silent: true });
}

/** Scenes are made when they are first looked at, so that few videos are fetched. */
function view(index, state) {
  if (!views[index]) {
    const scene = numbered(payload.scenes[index]);
    // Nobody knows what is where in some videos.
    const isMapped = !scene.map.missing;
    const map = isMapped ? showMap(scene, null, () => {}) : { element: null, show() {}, mark() {} };
    const picture = showPicture(scene, null, map.show);
    if (clauses.some((c) => c.shown.scene === index && isShownByVideo(c))) {
      picture.requireWatching(state.watched?.[index] !== undefined, (what) => watched(index, what));
    }
    const element = h("div", { class: "scene" }, picture.element, map.element);
    views[index] = { scene, map, picture, element };
  }
  return views[index];
}

function judge(verdict) {
  const state = work.state;
  work.change({ ...state, verdicts: { ...state.verdicts, [state.current]: verdict } });
  announce(VERDICTS.find(([value]) => value === verdict)[1]);
}

function go(node) {
  work.change({ ...work.state, current: node }, { silent: true });
  announce(clauses.find((clause) => clause.node === node).phrase);
}

document.addEventListener("keydown", (event) => {
  if (!isShortcut(event)) return;
  const key = event.key.toLowerCase();
  const verdict = VERDICTS.find(([, , letter]) => letter === key);
  if (verdict) judge(verdict[0]);
  else if (key === "[" || key === "]") go(neighbour(clauses, work.state.current, key === "]" ? 1 : -1));
  else return;
  event.preventDefault();
});

function draw(state) {
  const clause = clauses.find((c) => c.node === state.current);
  if (!clause) return;
  const { shown } = clause;
  const { scene, map, picture, element } = view(shown.scene, state);
  showCommand(clause.node);
  if (stage.firstChild !== element) stage.replaceChildren(element);
  picture.mark(shown.objects);
  map.mark(shown.objects, shown.places, []);
  redraw(bar, clauseBar(clauses, clause.node, (c) => state.verdicts[c.node] !== undefined, go));
  redraw(panel, ...parts(clause, scene, state.verdicts));
}

function parts(clause, scene, verdicts) {
  const { shown } = clause;
  const verdict = verdicts[clause.node];
  const isNext = verdict !== undefined && clauses.some((c) => verdicts[c.node] === undefined);
  const names = [
    ...scene.things.filter((t) => shown.objects.includes(t.id)).map((t) => `${data.labels.thing} ${t.number}`),
    ...scene.zones.filter((z) => shown.places.includes(z.id)).map((z) => `${data.labels.place} ${z.letter}`),
  ];
  const phrase = h("q", {}, h("bdi", {}, clause.phrase));
  const heading = names.length
    ? h("h2", {}, pieces(names.length === 1 ? _("Could %(phrase)s mean %(things)s, which is marked?") : _("Could %(phrase)s mean %(things)s, which are marked?"), { phrase, things: listed(names) }))
    : h("h2", {}, pieces(_("Does the whole video show %(phrase)s?"), { phrase }));
  return [
    heading,
    h(
      "fieldset",
      {},
      h("legend", { class: "unseen" }, _("Your verdict")),
      h("div", { class: "choices" }, VERDICTS.map(([value, label]) =>
        choice("radio", "verdict", label, verdict === value, () => judge(value), { "data-key": String(value) }),
      ), clauses.length > 1 && h("button", { type: "button", class: isNext && "primary", "data-key": "next", onclick: () => go(neighbour(clauses, clause.node, 1)) }, _("Next clause"))),
    ),
  ];
}
