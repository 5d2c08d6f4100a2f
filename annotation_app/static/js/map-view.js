// Looking at a part of the map: by buttons, the wheel, two fingers, and dragging.

import { h } from "./dom.js";
import { _ } from "./speech.js";

const STEP = 1.5;
const MOST = 12;
const DRAG_PX = 6;

/**
 * Let an SVG be looked at closely. `whole` is its viewBox as {x, y, w, h}; `isBusy()` tells
 * whether the pointer is used for something else; `changed()` is called when the view has changed.
 */
export function zoomable(svg, whole, isBusy, changed) {
  let view = { ...whole };
  let dragged = false; // whether the press that ends was a drag, so that it is no click

  function set(next) {
    const w = Math.min(whole.w, Math.max(whole.w / MOST, next.w));
    const tall = (w / whole.w) * whole.h;
    view = {
      w,
      h: tall,
      x: Math.min(Math.max(next.x, whole.x), whole.x + whole.w - w),
      y: Math.min(Math.max(next.y, whole.y), whole.y + whole.h - tall),
    };
    svg.setAttribute("viewBox", `${view.x} ${view.y} ${view.w} ${view.h}`);
    const isClose = view.w < 0.999 * whole.w;
    svg.classList.toggle("close", isClose);
    closer.disabled = view.w <= (1.001 * whole.w) / MOST;
    away.disabled = all.disabled = !isClose;
    changed();
  }

  /** Zoom so that a point stays where it is. */
  function zoom(factor, point = [view.x + view.w / 2, view.y + view.h / 2]) {
    const w = Math.min(whole.w, Math.max(whole.w / MOST, view.w / factor));
    const share = w / view.w;
    set({ w, x: point[0] - (point[0] - view.x) * share, y: point[1] - (point[1] - view.y) * share });
  }

  function pointAt(clientX, clientY) {
    const point = new DOMPoint(clientX, clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [point.x, point.y];
  }

  const button = (label, text, onclick) => h("button", { type: "button", "aria-label": label, title: label, onclick }, text);
  const closer = button(_("Closer"), "+", () => zoom(STEP));
  const away = button(_("Further away"), "−", () => zoom(1 / STEP));
  const all = button(_("The whole map"), "⤢", () => set(whole));
  const element = h("div", { class: "zoom", role: "group", "aria-label": _("Zoom of the map") }, closer, away, all);

  svg.addEventListener("wheel", (event) => {
    const scrolls = document.documentElement.scrollHeight > innerHeight + 4;
    if (scrolls && !event.ctrlKey) return;
    event.preventDefault();
    zoom(2 ** (-event.deltaY / 240), pointAt(event.clientX, event.clientY));
  }, { passive: false });

  // Dragging moves a map that is looked at closely; otherwise the page scrolls.
  let from = null;
  svg.addEventListener("pointerdown", (event) => {
    dragged = false;
    from = event.isPrimary && !isBusy() && view.w < 0.999 * whole.w ? [event.clientX, event.clientY] : null;
  });
  svg.addEventListener("pointermove", (event) => {
    if (!from || pinch) return;
    const [dx, dy] = [event.clientX - from[0], event.clientY - from[1]];
    if (!dragged && Math.hypot(dx, dy) < DRAG_PX) return;
    dragged = true;
    svg.setPointerCapture(event.pointerId);
    const [x, y] = pointAt(event.clientX, event.clientY);
    const [x0, y0] = pointAt(...from);
    from = [event.clientX, event.clientY];
    set({ ...view, x: view.x - (x - x0), y: view.y - (y - y0) });
  });
  for (const name of ["pointerup", "pointercancel"]) svg.addEventListener(name, () => (from = null));

  let pinch = null;
  const spread = ([a, b]) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  const between = ([a, b]) => [(a.clientX + b.clientX) / 2, (a.clientY + b.clientY) / 2];
  const onTouch = (event) => {
    if (event.touches.length !== 2 || isBusy()) {
      pinch = null;
      return;
    }
    event.preventDefault();
    const fingers = [...event.touches];
    if (pinch) zoom(spread(fingers) / pinch, pointAt(...between(fingers)));
    pinch = spread(fingers);
    dragged = true;
  };
  for (const name of ["touchstart", "touchmove"]) svg.addEventListener(name, onTouch, { passive: false });
  for (const name of ["touchend", "touchcancel"]) svg.addEventListener(name, () => (pinch = null));

  closer.disabled = false;
  away.disabled = all.disabled = true;
  return {
    element,
    get view() { return view; },
    /** Whether the click that comes ends a drag or a pinch. */
    get wasDragged() { return dragged; },
  };
}
