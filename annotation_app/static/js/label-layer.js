// Labels over a drawing, as key caps of the same size however large the drawing is shown.

import { s } from "./dom.js";
import { layOut, overlap } from "./labels.js";

const HEIGHT_PX = 20;
const LETTER_PX = 9;
const SIDES_PX = 10;

/**
 * A layer of labels. `put(labels, frame, unit)` draws them, [{id, text, kind, box, isChosen, isMinor}], in a
 * frame of the drawing's own units, of which `unit` are a pixel. What is chosen comes first; what
 * lies outside of the frame has no label.
 */
export function labelLayer() {
  const element = s("g", { class: "labels" });
  const lines = s("g", {});
  element.append(lines);
  const made = new Map();

  function cap(label) {
    const key = `${label.kind} ${label.id}`;
    if (!made.has(key)) {
      const parts = [s("rect", {}), s("text", {}, label.text)];
      made.set(key, s("g", { "data-id": label.id, "data-kind": label.kind }, ...parts));
      element.append(made.get(key));
    }
    return made.get(key);
  }

  function put(labels, frame, unit) {
    const inPixels = (box) => ({ x: box.x / unit, y: box.y / unit, w: box.w / unit, h: box.h / unit });
    const seen = labels.filter((label) => overlap(label.box, frame));
    const wanted = [...seen.filter((l) => l.isChosen), ...seen.filter((l) => !l.isChosen)].map((label) => ({
      id: `${label.kind} ${label.id}`,
      w: SIDES_PX + LETTER_PX * label.text.length,
      h: HEIGHT_PX,
      box: inPixels(label.box),
      isMinor: label.isMinor && !label.isChosen,
    }));
    const placed = layOut(wanted, inPixels(frame));
    lines.replaceChildren();
    const keys = new Set(labels.map((label) => `${label.kind} ${label.id}`));
    for (const [key, group] of made) if (!keys.has(key)) group.setAttribute("class", "cap left-out");
    for (const label of labels) {
      const group = cap(label);
      const spot = placed.get(`${label.kind} ${label.id}`);
      group.setAttribute("class", `cap ${label.kind}${label.isChosen ? " chosen" : ""}${spot ? "" : " left-out"}`);
      if (!spot) continue;
      group.setAttribute("transform", `translate(${spot.x * unit} ${spot.y * unit}) scale(${unit})`);
      const [rect, text] = group.children;
      text.textContent = label.text;
      for (const [name, value] of Object.entries({ width: spot.w, height: spot.h, rx: 5 })) rect.setAttribute(name, value);
      for (const [name, value] of Object.entries({ x: spot.w / 2, y: spot.h / 2 })) text.setAttribute(name, value);
      if (spot.line) {
        const [x1, y1, x2, y2] = [spot.x + spot.w / 2, spot.y + spot.h / 2, ...spot.line].map((v) => v * unit);
        lines.append(s("line", { x1, y1, x2, y2 }));
      }
    }
  }
  return { element, put };
}

/** How many of a drawing's units are a pixel on the screen, as its box is fitted into it. */
export function unitOf(svg) {
  const { width, height } = svg.viewBox.baseVal;
  const shown = svg.getBoundingClientRect();
  return shown.width && shown.height ? Math.max(width / shown.width, height / shown.height) : 0;
}
