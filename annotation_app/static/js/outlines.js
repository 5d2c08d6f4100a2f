// The outlines of things over the picture, with their numbers; they can be clicked.

import { s } from "./dom.js";
import { labelLayer, unitOf } from "./label-layer.js";
import { boxAround } from "./labels.js";
import { seenAt } from "./paths-of-things.js";

const REACH_PX = 16;

/** Outlines of a scene's things. `pick(id)` is called for one that is clicked; null if none can be. */
export function showOutlines(scene, pick) {
  const { width, height } = scene.segmentation;
  const element = s("svg", { class: "outlines", viewBox: `0 0 ${width || 1} ${height || 1}`, "aria-hidden": "true" });
  const seen = scene.things.filter((thing) => thing.outline);
  const area = ({ outline: { box } }) => box[2] * box[3];
  const shapes = new Map();
  const places = new Map(seen.map(({ id, outline: { box: [x, y, w, h] } }) => [id, { x, y, w, h }]));
  // Large things first, so that what stands before them lies on top.
  for (const thing of [...seen].sort((a, b) => area(b) - area(a))) {
    const d = pathOf(thing.outline.polygons);
    const group = s("g", { class: "thing", "data-id": thing.id }, s("path", { class: "hit", d }), s("path", { class: "shape", d }));
    shapes.set(thing.id, group);
    element.append(group);
  }
  const labels = labelLayer();
  element.append(labels.element);
  if (pick) {
    element.addEventListener("click", (event) => {
      const id = event.target.closest("[data-id]")?.dataset.id;
      // A second click of a double click would answer the next question.
      if (id && event.detail <= 1) pick(id);
    });
  }
  function label() {
    const unit = unitOf(element);
    if (!unit) return;
    element.style.setProperty("--reach", `${2 * REACH_PX * unit}`);
    const there = seen.filter(({ id }) => places.get(id));
    const wanted = there.sort((a, b) => area(a) - area(b)).map(({ id, number }) =>
      ({ id, kind: "object", text: number, box: places.get(id), isChosen: shapes.get(id).classList.contains("chosen") }));
    labels.put(wanted, { x: 0, y: 0, w: width, h: height }, unit);
  }
  new ResizeObserver(label).observe(element);
  return {
    element,
    /** Show where things are at a moment; those that are known at the first one only are there if it `isFirst`. */
    at(t, isFirst) {
      for (const { id, outline } of seen) {
        const polygons = outline.moments ? seenAt(outline.moments, t) : isFirst ? outline.polygons : null;
        places.set(id, polygons && boxAround(polygons.flat()));
        const group = shapes.get(id);
        group.classList.toggle("away", !polygons);
        if (polygons && outline.moments) for (const path of group.children) path.setAttribute("d", pathOf(polygons));
      }
      label();
    },
    /** Mark what is chosen. */
    mark(ids) {
      for (const [id, group] of shapes) group.classList.toggle("chosen", ids.includes(id));
      label();
    },
  };
}

const pathOf = (polygons) => polygons.map((p) => `M${p.map((xy) => xy.join(",")).join("L")}Z`).join("");
