// Drawing things in Ground that nobody has marked: the surface over the picture, and the numbers that they get.

import { cornersOf, drawing } from "./drawing.js";
import { $ } from "./dom.js";
import { boxAround } from "./labels.js";

const SHOWN_S = 0.15; // around the moment at which something was drawn

/**
 * Let things be drawn over a scene's picture. `changed(drawn)` is called with all of them, [{id, polygons,
 * time_s}], `picked(id)` for one that was drawn, clicked, or finished by Enter; `stopped()` when drawing ends.
 *
 * Gives {show(drawn, chosen), at(t), draw(isByKey), stop()}.
 */
export function drawingOver({ scene, picture, video, changed, picked, stopped }) {
  const first = scene.things.length;
  let surface = null;
  let drawn = [];
  let isByKey = false;

  /** Things whose file has no picture's size are drawn in that of the video. */
  function make() {
    const width = scene.segmentation.width || video.videoWidth;
    const height = scene.segmentation.height || video.videoHeight;
    if (surface || !width) return;
    surface = drawing({
      width, height, kinds: ["box"],
      newId: () => `drawn-${crypto.getRandomValues(new Uint32Array(2)).join("")}`,
      changed: keep,
      clicked: (id) => picked(id),
      named: (id) => finish(id),
      history: { undo: () => $("undo").click(), redo: () => $("redo").click(), canUndo: () => true, canRedo: () => true },
    });
    surface.element.classList.add("idle");
    surface.element.addEventListener("keydown", (event) => event.key === "Escape" && stop());
    picture.element.querySelector(".screen").append(surface.element);
    show(drawn, []);
  }

  const now = () => (picture.time <= SHOWN_S ? 0 : Math.round(picture.time * 1000) / 1000);
  const isShown = ({ time_s }) => Math.abs(time_s - now()) <= SHOWN_S;

  function keep(shapes) {
    const polygons = new Map(shapes.map((shape) => [shape.id, [cornersOf(shape)]]));
    const kept = drawn.filter((one) => polygons.has(one.id) || !isShown(one))
      .map((one) => (polygons.has(one.id) ? { ...one, polygons: polygons.get(one.id) } : one));
    const known = new Set(drawn.map(({ id }) => id));
    const added = shapes.filter(({ id }) => !known.has(id)).map(({ id }) => ({ id, polygons: polygons.get(id), time_s: now() }));
    changed([...kept, ...added]);
    if (added.length && !isByKey && surface.tool) finish(added[0].id);
  }
  function finish(id) {
    const hadFocus = surface.element.contains(document.activeElement);
    stop();
    picked(id);
    if (hadFocus) document.querySelector(".ask .actions button:not(:disabled)")?.focus();
  }
  function stop() {
    isByKey = false;
    surface?.use(null);
    surface?.element.classList.add("idle");
    stopped();
  }
  function show(things, chosen) {
    drawn = things;
    if (!surface) return;
    surface.put(drawn.map((one, i) => ({ ...one, number: first + i + 1 })).filter(isShown)
      .map(({ id, number, polygons: [p] }) => ({ id, number, kind: "box", points: [p[0], p[2]], name: "" })));
    if (!surface.element.contains(document.activeElement)) surface.choose(drawn.find(({ id }) => chosen.includes(id))?.id ?? null);
  }

  video.addEventListener("loadedmetadata", make);
  make();
  return {
    show,
    at: () => show(drawn, []),
    stop,
    get isDrawing() { return Boolean(surface) && !surface.element.classList.contains("idle"); },
    /** Begin: with keys a box is there at once, which arrows move and Enter keeps. */
    draw(byKey) {
      if (!surface) return;
      video.pause();
      surface.element.classList.remove("idle");
      isByKey = byKey;
      if (byKey) surface.begin("box");
      else surface.use("box");
    },
  };
}

/** The things that somebody has drawn, as things of a scene that has `count` others. */
export const asThings = (drawn, count) =>
  drawn.map(({ id, polygons }, i) => {
    const { x, y, w, h } = boxAround(polygons.flat());
    return { id, number: String(count + i + 1), outline: { box: [x, y, w, h], polygons }, footprint: polygons[0], isRobot: false, isDrawn: true };
  });
