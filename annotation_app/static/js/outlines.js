// The outlines of things over the picture, with their numbers; they can be clicked.

import { s } from "./dom.js";
import { labelLayer, unitOf } from "./label-layer.js";

const REACH_PX = 16;

/** Outlines of a scene's things. `pick(id)` is called for one that is clicked; null if none can be. */
export function showOutlines(scene, pick) {
  const { width, height } = scene.segmentation;
  const element = s("svg", { class: "outlines", viewBox: `0 0 ${width || 1} ${height || 1}`, "aria-hidden": "true" });
  const seen = scene.things.filter((thing) => thing.outline);
  const area = ({ outline: { box } }) => box[2] * box[3];
  const shapes = new Map();
  // Large things first, so that what stands before them lies on top.
  for (const thing of [...seen].sort((a, b) => area(b) - area(a))) {
    const d = thing.outline.polygons.map((p) => `M${p.map((xy) => xy.join(",")).join("L")}Z`).join("");
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
    const wanted = [...seen].sort((a, b) => area(a) - area(b)).map((thing) => {
      const [x, y, w, h] = thing.outline.box;
      return { id: thing.id, kind: "object", text: thing.number, box: { x, y, w, h }, isChosen: shapes.get(thing.id).classList.contains("chosen") };
    });
    labels.put(wanted, { x: 0, y: 0, w: width, h: height }, unit);
  }
  new ResizeObserver(label).observe(element);
  return {
    element,
    /** Mark what is chosen. */
    mark(ids) {
      for (const [id, group] of shapes) group.classList.toggle("chosen", ids.includes(id));
      label();
    },
  };
}
