// A surface over a picture, on which points, boxes and outlines are drawn by mouse, touch or keys.
//
// It knows nothing of the page: a shape is {id, kind, points, name}, in pixels of the picture. A point has
// one of `points`, a box two opposite corners, a line two or more, an outline three or more. `others` are
// further polygons of an outline, which move and grow with it; `number` is what it is shown as, else its
// place among the shapes.

import { h, s } from "./dom.js";
import { labelLayer, unitOf } from "./label-layer.js";
import { boxAround } from "./labels.js";
import { _, number } from "./speech.js";

const KINDS = {
  point: { key: "p", label: _("Point") },
  box: { key: "b", label: _("Box") },
  line: { key: "l", label: _("Line") },
  outline: { key: "o", label: _("Outline") },
};
const LEAST = { line: 2, outline: 3 };
const REACH_PX = { mouse: 8, pen: 12, touch: 20 };
const SMALLEST_PX = 3;
const CORNER_PX = 5;
const MOST_CORNERS = 60; // outlines of masks have more: they are moved and resized as wholes
const STEP = 1 / 400; // of the picture's width; keys that are held go faster
const QUICK_MS = 250;
const NEW_PART = 0.25;

/** The box around a shape, {x, y, w, h}. */
export const boxOf = (shape) => boxAround([shape.points, ...(shape.others ?? [])].flat());

/** The corners of a shape, as a polygon; a point has one. */
export function cornersOf({ kind, points }) {
  if (kind !== "box") return points;
  const [[x1, y1], [x2, y2]] = points;
  return [[x1, y1], [x2, y1], [x2, y2], [x1, y2]];
}

/**
 * Make a surface of a picture's size.
 *
 * `kinds` are those that may be drawn, `most` how many shapes there may be: one more takes the place of
 * the last. `changed(shapes)` is called after each change, `chose(id)` with what is chosen or null, and
 * `clicked(id)` when one was clicked and not moved, `named(id)` when Enter asks for a shape's name. `newId()` gives the ids of new shapes. A page that has a
 * history of its own gives it: {undo(), redo(), canUndo(), canRedo()}; `changed` tells it if a key goes on.
 *
 * Gives {element, tools, help}: the surface, buttons, and a text about keys, which the page places; and
 * what a page may do.
 */
export function drawing({
  width, height, label = _("Drawing"), kinds = ["box", "outline"], most = Infinity, shapes: first = [],
  changed = () => {}, chose = () => {}, clicked = () => {}, named = () => {}, newId = randomId, history = null,
}) {
  let shapes = first.map(copied);
  let past = [];
  let future = [];
  let chosen = null;
  let corner = null; // of the chosen shape, by its index
  let tool = null;
  let pending = null; // what is being drawn: {kind, points, cursor}
  let act = null; // what the pointer that is down does
  let lastKey = { at: 0, streak: 0, of: null };

  const svg = s("svg", { viewBox: `0 0 ${width || 1} ${height || 1}` });
  const layer = s("g", {});
  const preview = s("path", { class: "preview" });
  const handles = s("g", { class: "handles" });
  let labels = labelLayer();
  svg.append(layer, preview, handles, labels.element);
  const help = h("p", { class: "note", id: `drawing-${randomId()}` }, helpOf(kinds));
  const status = h("p", { class: "unseen", role: "status" });
  const element = h(
    "div",
    { class: "surface", role: "application", tabindex: 0, "aria-label": label, "aria-describedby": help.id },
    svg, status,
  );
  const groups = new Map();
  const button = (text, onclick, more = {}) => h("button", { type: "button", onclick, ...more }, text);
  const toolButtons = kinds.map((kind) =>
    button(KINDS[kind].label, () => use(tool === kind ? null : kind), { "aria-pressed": "false", "data-kind": kind }));
  const closing = button("", finish, { hidden: true });
  const undoing = button(_("Undo"), undo);
  const redoing = button(_("Redo"), redo);
  const removing = button(_("Delete"), () => remove(chosen));
  const tools = h("div", { class: "drawing-tools", role: "group", "aria-label": _("Tools") }, toolButtons, closing, undoing, redoing, removing);

  const find = (id) => shapes.find((shape) => shape.id === id);
  const unit = () => unitOf(svg) || 1;
  const clamped = ([x, y]) => [round(Math.min(Math.max(x, 0), width)), round(Math.min(Math.max(y, 0), height))];
  const say = (text) => {
    status.textContent = "";
    setTimeout(() => (status.textContent = text), 50);
  };

  // Changes and their history

  /** Keep the shapes as they were, unless the same key goes on with the same shape. */
  function remember(goesOn = false) {
    future = [];
    if (!goesOn) past.push(shapes);
  }
  function set(next, goesOn = false) {
    remember(goesOn);
    shapes = next;
    draw();
    changed(shapes.map(copied), goesOn);
  }
  const replace = (shape) => shapes.map((one) => (one.id === shape.id ? shape : one));
  function travel(from, to, text) {
    if (!from.length) return;
    cancel();
    to.push(shapes);
    shapes = from.pop();
    corner = null;
    if (!find(chosen)) choose(null);
    draw();
    say(text);
    changed(shapes.map(copied));
  }
  function undo() { history ? history.undo() : travel(past, future, _("Undone.")); }
  function redo() { history ? history.redo() : travel(future, past, _("Done again.")); }

  function add(shape) {
    const made = { id: newId(), name: "", ...shape };
    set([...shapes.slice(0, most - 1), made]);
    choose(made.id, true);
    say(described(made));
    return made.id;
  }
  function remove(id) {
    const at = shapes.findIndex((shape) => shape.id === id);
    if (at < 0) return;
    const hadFocus = groups.get(id).contains(document.activeElement) || document.activeElement === removing;
    const text = _("%(thing)s is deleted.", { thing: titleOf(find(id)) });
    if (chosen === id) chosen = null;
    set(shapes.filter((shape) => shape.id !== id));
    const next = shapes[Math.min(at, shapes.length - 1)];
    choose(next && hadFocus ? next.id : null);
    if (hadFocus) (next ? groups.get(next.id) : element).focus();
    say(text);
  }
  function rename(id, name) {
    const shape = find(id);
    if (shape && shape.name !== name) set(replace({ ...shape, name }));
  }

  /** Move a shape, or one of its corners, but not out of the picture. */
  function moved(shape, [dx, dy], at = null) {
    if (at !== null) return withCorner(shape, at, ([x, y]) => clamped([x + dx, y + dy]));
    const { x, y, w, h: tall } = boxOf(shape);
    const right = Math.min(Math.max(dx, -x), width - x - w);
    const down = Math.min(Math.max(dy, -y), height - y - tall);
    return mapped(shape, ([px, py]) => [round(px + right), round(py + down)]);
  }
  /** Make a shape larger or smaller, from its upper left corner. */
  function resized(shape, [dx, dy]) {
    const { x, y, w, h: tall } = boxOf(shape);
    const least = SMALLEST_PX * unit();
    const wide = Math.min(Math.max(w + dx, least), width - x);
    const high = Math.min(Math.max(tall + dy, least), height - y);
    const part = (value, from, of, to) => (of ? from + ((value - from) * to) / of : value);
    return mapped(shape, ([px, py]) => [round(part(px, x, w, wide)), round(part(py, y, tall, high))]);
  }

  // Choosing and drawing

  function choose(id, isFocused = false) {
    if (chosen === id) return;
    chosen = id;
    corner = null;
    draw();
    if (id && (isFocused || element.contains(document.activeElement))) groups.get(id).focus({ preventScroll: true });
    chose(id);
  }
  function use(kind) {
    cancel();
    tool = kind;
    element.classList.toggle("surface-on", Boolean(kind));
    for (const one of toolButtons) one.setAttribute("aria-pressed", String(one.dataset.kind === kind));
  }
  function cancel() {
    pending = act = null;
    showPending();
  }
  function finish() {
    if (!pending) return;
    const { kind, points } = pending;
    const box = boxAround(points);
    pending = null;
    showPending();
    const isLarge = Math.max(box.w, box.h) >= SMALLEST_PX * unit() && (kind !== "box" || Math.min(box.w, box.h) >= unit());
    if (kind === "point") add({ kind, points });
    else if (kind === "box" && isLarge) add({ kind, points: ordered(points) });
    else if (points.length >= LEAST[kind] && isLarge) add({ kind, points });
  }
  /** Begin a shape by a key: in the middle of the picture, from where arrows move it. */
  function begin(kind) {
    cancel();
    const side = NEW_PART * Math.min(width, height);
    const shift = (shapes.length % 5) * side * 0.2;
    const [x, y] = [(width - side) / 2 + shift, (height - side) / 2 + shift];
    const box = [clamped([x, y]), clamped([x + side, y + side])];
    const middle = y + side / 2;
    const points = {
      point: [clamped([width / 2 + shift, height / 2 + shift])], box,
      line: [clamped([x, middle]), clamped([x + side, middle])], outline: cornersOf({ kind: "box", points: box }),
    }[kind];
    return add({ kind, points });
  }

  const at = (event) => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return clamped([point.x, point.y]);
  };
  const distance = ([a, b], [c, d]) => Math.hypot(a - c, b - d);
  function cornerAt(p, reach) {
    const shape = find(chosen);
    if (!shape || shape.kind === "point") return null;
    const near = handled(shape).map((xy, i) => [distance(xy, p), i]).sort(([a], [b]) => a - b)[0];
    return near && near[0] <= reach ? near[1] : null;
  }
  /** Whether a shape, or its edge, is at a point. */
  function isAt({ id, kind }, [x, y]) {
    const path = groups.get(id).querySelector(".hit");
    return (kind !== "line" && path.isPointInFill({ x, y })) || path.isPointInStroke({ x, y });
  }
  const area = (shape) => boxOf(shape).w * boxOf(shape).h;
  const shapeAt = (p) => shapes.filter((shape) => isAt(shape, p)).sort((a, b) => area(a) - area(b))[0] ?? null;

  svg.addEventListener("pointerdown", (event) => {
    if (event.button || act) return;
    const p = at(event);
    const reach = (REACH_PX[event.pointerType] ?? REACH_PX.mouse) * unit();
    svg.style.setProperty("--reach", `${reach}`);
    const grip = pending ? null : cornerAt(p, reach);
    const hit = pending ? null : shapeAt(p);
    const base = { pointer: event.pointerId, from: p, hit, isMoved: false, reach };
    if (grip !== null) act = { ...base, kind: "corner", grip, shape: find(chosen) };
    else if (chosen && hit && isAt(find(chosen), p)) act = { ...base, kind: "move", shape: find(chosen) };
    else if (tool) act = { ...base, kind: "draw", isFirst: !pending };
    else if (hit) {
      choose(hit.id, true);
      act = { ...base, kind: "move", shape: hit };
    } else {
      choose(null);
      return;
    }
    if (act.kind === "draw") {
      if (act.isFirst) pending = { kind: tool, points: [] };
      pending.points.push(p);
      showPending();
    }
    svg.setPointerCapture(event.pointerId);
    event.preventDefault();
    if (!element.contains(document.activeElement)) element.focus({ preventScroll: true });
  });
  svg.addEventListener("pointermove", (event) => {
    const p = at(event);
    if (!act) {
      if (pending) showPending(p);
      return;
    }
    if (event.pointerId !== act.pointer) return;
    act.isMoved ||= distance(p, act.from) > act.reach / 2;
    if (!act.isMoved) return;
    if (act.kind === "draw") {
      if (pending.kind === "box" && act.isFirst) showPending(p);
      else {
        pending.points[pending.points.length - 1] = p;
        showPending();
      }
      return;
    }
    const by = [p[0] - act.from[0], p[1] - act.from[1]];
    const next = moved(act.shape, by, act.kind === "corner" ? act.grip : null);
    act.next = next;
    shapes = replace(next);
    draw();
  });
  svg.addEventListener("pointerup", (event) => {
    if (!act || event.pointerId !== act.pointer) return;
    const done = act;
    act = null;
    if (done.kind === "draw") drawn(done, at(event));
    else if (done.next) {
      shapes = replace(done.shape);
      set(replace(tidy(done.next)));
    } else if (done.kind === "move" && done.hit) {
      choose(done.hit.id, true);
      clicked(done.hit.id);
    }
  });
  svg.addEventListener("pointercancel", () => {
    if (act?.shape) shapes = replace(act.shape);
    cancel();
    draw();
  });
  svg.addEventListener("dblclick", () => {
    if (pending?.kind in LEAST) {
      pending.points.pop();
      finish();
    }
  });

  function drawn(done, p) {
    if (!pending) return;
    const { kind, points } = pending;
    // A click chooses what is there; the second of two clicks is a box's other corner.
    if (done.isFirst && !done.isMoved && done.hit && kind !== "point") {
      cancel();
      choose(done.hit.id, true);
    } else if (kind === "point") finish();
    else if (kind === "box") {
      if (done.isFirst && done.isMoved) points.push(p);
      if (points.length > 1) finish();
    } else if (points.length > LEAST[kind] && distance(points.at(-1), kind === "line" ? points.at(-2) : points[0]) <= done.reach) {
      points.pop();
      finish();
    }
    showPending();
  }

  // Keys

  element.addEventListener("keydown", (event) => {
    const { key, shiftKey, altKey } = event;
    const letter = key.toLowerCase();
    if (event.ctrlKey || event.metaKey) {
      if (letter === "z" && !shiftKey) undo();
      else if (letter === "y" || letter === "z") redo();
      else return;
    } else if (altKey || !press(event, find(chosen), letter)) return;
    event.preventDefault();
    event.stopPropagation();
  });

  /** Do what a key is for; false if it is for nothing. */
  function press({ key, shiftKey, timeStamp }, shape, letter) {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[key];
    const kind = kinds.find((one) => KINDS[one].key === letter);
    if (pending) {
      if (key === "Enter") finish();
      else if (key === "Backspace" && pending.points.length > 1) pending.points.pop();
      else if (key === "Escape" || key === "Backspace") cancel();
      else return false;
      showPending();
    } else if (kind && !shiftKey) begin(kind);
    else if (!shape) return false;
    else if (way) push(shape, way, shiftKey, timeStamp);
    else if (key === "Delete" || key === "Backspace") remove(shape.id);
    else if (key === "Enter") named(shape.id);
    else if (key === "Escape") (corner === null ? () => { choose(null); element.focus(); } : () => pick(null))();
    else if (letter === "c" && handled(shape).length) pick(corner === null ? 0 : (corner + 1) % handled(shape).length);
    else if (shape.kind in LEAST && corner !== null && "+=-".includes(key)) recut(shape, key !== "-");
    else return false;
    return true;
  }
  function push(shape, [dx, dy], isResizing, now) {
    const of = `${shape.id} ${isResizing} ${corner}`;
    const isQuick = now - lastKey.at < QUICK_MS && lastKey.of === of;
    lastKey = { at: now, of, streak: isQuick ? lastKey.streak + 1 : 0 };
    const step = STEP * width * Math.min(1 + lastKey.streak / 3, 8);
    const by = [dx * step, dy * step];
    const next = isResizing && shape.kind !== "point" ? resized(shape, by) : moved(shape, by, corner);
    set(replace(tidy(next)), isQuick);
    say(described(next));
  }
  function pick(index) {
    corner = index;
    draw();
    const shape = find(chosen);
    say(index === null ? described(shape) : _("Corner %(number)s of %(count)s", { number: index + 1, count: handled(shape).length }));
  }
  function recut(shape, isMore) {
    const { points } = shape;
    const [x, y] = points[corner];
    // A line goes on after its last corner, the way that it came.
    const isEnd = shape.kind === "line" && corner === points.length - 1;
    const [u, v] = isEnd ? points[corner - 1].map((from, i) => 3 * points[corner][i] - 2 * from) : points[(corner + 1) % points.length];
    if (isMore) set(replace({ ...shape, points: points.toSpliced(corner + 1, 0, clamped([(x + u) / 2, (y + v) / 2])) }));
    else if (points.length > LEAST[shape.kind]) set(replace({ ...shape, points: points.toSpliced(corner, 1) }));
    pick(isMore ? corner + 1 : Math.min(corner, find(shape.id).points.length - 1));
  }

  // What is seen and heard

  const placeOf = (shape) => shapes.findIndex((one) => one.id === shape.id);
  const numberOf = (shape) => shape.number ?? placeOf(shape) + 1;
  const titleOf = (shape) => [numberOf(shape), shape.name || KINDS[shape.kind].label].join(" ");
  function described(shape) {
    const { x, y, w, h: tall } = boxOf(shape);
    const part = (value, of) => `${number((100 * value) / (of || 1), 0)} %`;
    const spot = _("%(x)s from the left, %(y)s from the top", { x: part(x, width), y: part(y, height) });
    if (shape.kind === "point") return `${titleOf(shape)}: ${spot}`;
    const size = _("%(w)s wide, %(h)s high", { w: part(w, width), h: part(tall, height) });
    return `${titleOf(shape)}: ${spot}, ${size}`;
  }

  function draw() {
    const px = unit();
    for (const [id, group] of groups) {
      if (find(id)) continue;
      group.remove();
      groups.delete(id);
    }
    for (const shape of shapes) {
      if (!groups.has(shape.id)) groups.set(shape.id, groupOf(shape));
      const group = groups.get(shape.id);
      const there = layer.children[placeOf(shape)] ?? null;
      if (there !== group) layer.insertBefore(group, there);
      const d = pathOf(shape, px);
      for (const path of group.children) path.setAttribute("d", d);
      group.setAttribute("class", `drawn ${shape.kind}${shape.id === chosen ? " chosen" : ""}`);
      group.setAttribute("aria-label", described(shape));
    }
    const shape = find(chosen);
    const spots = shape && shape.kind !== "point" ? handled(shape) : [];
    handles.replaceChildren(...spots.map(([cx, cy], i) => s("circle", { cx, cy, r: CORNER_PX * px, class: i === corner ? "chosen" : "" })));
    const fresh = labelLayer();
    labels.element.replaceWith(fresh.element);
    labels = fresh;
    if (unitOf(svg)) {
      const wanted = shapes.map((one) => ({ id: one.id, kind: "object", text: String(numberOf(one)), box: boxOf(one), isChosen: one.id === chosen }));
      labels.put(wanted, { x: 0, y: 0, w: width, h: height }, px);
    }
    undoing.disabled = history ? !history.canUndo() : !past.length;
    redoing.disabled = history ? !history.canRedo() : !future.length;
    removing.disabled = !shape;
  }
  function groupOf({ id }) {
    const group = s("g", { tabindex: 0, role: "button", "data-id": id }, s("path", { class: "hit" }), s("path", { class: "casing" }), s("path", { class: "shape" }));
    group.addEventListener("focus", () => choose(id));
    return group;
  }
  function showPending(cursor = null) {
    closing.hidden = !(pending?.kind in LEAST) || pending.points.length < LEAST[pending.kind];
    closing.textContent = pending?.kind === "line" ? _("End the line") : _("Close the outline");
    const points = pending ? [...pending.points, ...(cursor ? [cursor] : [])] : [];
    const shown = pending?.kind === "box" && points.length > 1 ? [...cornersOf({ kind: "box", points }), points[0]] : points;
    const r = CORNER_PX * unit();
    const dots = pending && pending.kind !== "box" ? pending.points.map(([x, y]) => dotAt(x, y, r)).join("") : "";
    preview.setAttribute("d", (shown.length ? `M${shown.map((xy) => xy.join(",")).join("L")}` : "") + dots);
  }

  new ResizeObserver(draw).observe(svg);
  draw();
  return {
    element,
    tools,
    help,
    get shapes() { return shapes.map(copied); },
    get chosen() { return chosen; },
    get tool() { return tool; },
    /** Show other shapes, such as those of another moment; there is nothing to undo then. */
    put(others) {
      if (!act) cancel();
      shapes = others.map(copied);
      [past, future] = [[], []];
      if (!find(chosen)) choose(null);
      draw();
    },
    /** What the pointer draws: a kind, or null if it only chooses and moves. */
    use,
    begin,
    choose,
    rename,
    remove,
    undo,
    redo,
  };
}

const round = (value) => Math.round(value * 10) / 10;
const copied = (shape) => structuredClone(shape);
const randomId = () => String(crypto.getRandomValues(new Uint32Array(1))[0] >>> 1);
const handled = (shape) => (shape.kind === "point" || shape.points.length > MOST_CORNERS ? [] : cornersOf(shape));
const dotAt = (x, y, r) => `M${x - r},${y}a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${-2 * r},0`;

function ordered([[x1, y1], [x2, y2]]) {
  return [[Math.min(x1, x2), Math.min(y1, y2)], [Math.max(x1, x2), Math.max(y1, y2)]];
}
const tidy = (shape) => (shape.kind === "box" ? { ...shape, points: ordered(shape.points) } : shape);

function mapped(shape, change) {
  const others = shape.others?.map((polygon) => polygon.map(change));
  return { ...shape, points: shape.points.map(change), ...(others && { others }) };
}

/** A shape one of whose corners is elsewhere: a box stays one. */
function withCorner(shape, index, change) {
  const next = change(cornersOf(shape)[index]);
  if (shape.kind !== "box") return { ...shape, points: shape.points.with(index, next) };
  return { ...shape, points: [cornersOf(shape)[(index + 2) % 4], next] };
}

function pathOf(shape, unit) {
  if (shape.kind === "point") return dotAt(...shape.points[0], 1.4 * CORNER_PX * unit);
  const end = shape.kind === "line" ? "" : "Z";
  return [cornersOf(shape), ...(shape.others ?? [])].map((polygon) => `M${polygon.map((xy) => xy.join(",")).join("L")}${end}`).join("");
}

function helpOf(kinds) {
  const begins = { point: _("P begins a point."), box: _("B begins a box."), line: _("L begins a line."), outline: _("O begins an outline.") };
  const lines = kinds.map((kind) => begins[kind]);
  lines.push(_("Arrow keys move it, Tab goes to the next, Delete removes it, Enter names it, Ctrl+Z undoes."));
  if (kinds.some((kind) => kind !== "point")) lines.push(_("Shift and arrow keys resize it."));
  if (kinds.some((kind) => kind in LEAST)) lines.push(_("C goes to the next corner, which + adds and − removes."));
  return lines.join(" ");
}
