// Numbers over time below a player's video, such as a robot's state and action, in step with it.

import { openCurves } from "./curve-file.js";
import { announce, h } from "./dom.js";
import { keep, read } from "./storage.js";
import { _, number } from "./speech.js";

const HAS_ROOM = !document.querySelector(".one-screen"); // the others fit the window
const OPEN = HAS_ROOM ? "g3:curves" : "g3:curves-in-window";
const HIDDEN = "g3:curves-hidden";
const COLOURS = 6; // --series-0 and so on
const DASHES = [5, 3];
const LEAST_FRAMES = 20;
const ZOOM = 2;
const SECOND = 1;
const MARGIN = 0.06;
const LARGE = "(min-width: 60rem) and (min-height: 60rem)";

/**
 * Show curves below a player. `beside` is the page's data of them; `player` has `video`, `duration`, `go(t)` and `step(by)`.
 *
 * Gives {element, at(t)}: `at` is called as the video goes on.
 */
export function showCurves({ curves: id, curves_start_s: startS }, player) {
  const { video } = player;
  const body = h("div", { class: "curves-body" });
  const element = h("details", { class: "curves" }, h("summary", {}, _("Curves")), body);
  element.open = (read(OPEN) ?? (HAS_ROOM && matchMedia(LARGE).matches ? "open" : "")) === "open";
  let chart = null;
  let isAsked = false;

  async function begin() {
    if (!element.open || isAsked) return;
    isAsked = true;
    try {
      const file = await openCurves(id, (level) => chart?.came(level));
      chart = showChart(file, startS, player, body);
    } catch {
      isAsked = false;
      body.replaceChildren(h("p", { class: "note" }, _("The curves can't be shown. Close and open them to try again.")));
    }
  }
  element.addEventListener("toggle", () => {
    keep(OPEN, element.open ? "open" : "closed");
    begin();
    chart?.redraw();
  });
  begin();

  function follow() {
    chart?.at(video.currentTime);
    if (!video.paused && !video.ended) requestAnimationFrame(follow);
  }
  video.addEventListener("playing", follow);
  return { element, at: (t) => chart?.at(t) };
}

function showChart(file, startS, player, body) {
  const frame = 1 / file.rate;
  const hidden = new Set(JSON.parse(read(HIDDEN) ?? "[]"));
  const names = [...new Set(file.curves.map(({ group }) => group))];
  const groups = names.map((name) => plotOf(name, file.curves.flatMap((curve, index) => (curve.group === name ? [{ ...curve, index }] : []))));
  const view = { from: 0, to: 1 };
  let now = player.video.currentTime || 0;
  let hovered = null;
  let sought = null; // where a drag has come to, while the video is still on its way to an earlier place
  let isStale = true; // the curves themselves are to be drawn, not only the line of the moment
  let scheduled = 0;
  let missing = -1; // the array of which parts haven't come that should be drawn
  let colours = [];

  const zoomIn = h("button", { type: "button", class: "small", title: _("Show less time (+)"), "aria-label": _("Show less time"), onclick: () => zoom(1 / ZOOM) }, "+");
  const zoomOut = h("button", { type: "button", class: "small", title: _("Show more time (−)"), "aria-label": _("Show more time"), onclick: () => zoom(ZOOM) }, "−");
  const span = h("span", { class: "quiet" });
  body.replaceChildren(h("div", { class: "curves-tools", dir: "ltr" }, zoomOut, zoomIn, span), ...groups.map(({ box }) => box));
  new ResizeObserver(redraw).observe(body);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  player.video.addEventListener("seeked", schedule);
  zoom(Infinity);

  function plotOf(name, curves) {
    const canvas = h("canvas", { "aria-hidden": "true" });
    const line = h("div", { class: "now" });
    const hover = h("div", { class: "now hovered", hidden: true });
    const [high, low] = [h("span", { class: "high" }), h("span", { class: "low" })];
    const plot = h("div", {
      class: "curve-plot", role: "slider", tabindex: 0, dir: "ltr", "aria-label": _("Time in the curves of %(group)s", { group: name }),
      "aria-valuemin": 0, onkeydown: byKey, onpointerdown: grab, onpointermove: point, onpointerleave: () => point(null),
    }, canvas, line, hover, high, low);
    const chips = curves.map((curve, i) => {
      const input = h("input", { type: "checkbox", onchange: () => choose([curve], input.checked) });
      const value = h("output", { dir: "ltr" });
      curve.key = `${name} ${curve.name}`;
      const sample = h("i", { class: i >= COLOURS ? "sample dashed" : "sample", "data-series": i % COLOURS, "aria-hidden": "true" });
      const chip = h("label", { class: "curve-chip" }, input, sample, h("span", { dir: "auto", title: curve.name }, curve.name), value);
      Object.assign(curve, { input, value, series: i % COLOURS, isDashed: i >= COLOURS });
      return chip;
    });
    const all = h("button", { type: "button", class: "link", onclick: () => choose(curves, curves.some((curve) => hidden.has(curve.key))) });
    const box = h("div", { class: "curve-group", role: "group", "aria-label": name }, h("p", { class: "curve-title" }, h("b", { dir: "auto" }, name), all), plot, h("div", { class: "curve-chips" }, chips));
    const group = { name, curves, box, plot, canvas, line, hover, high, low, all };
    mark(group);
    return group;
  }
  function mark({ curves, all }) {
    for (const { key, input } of curves) input.checked = !hidden.has(key);
    all.textContent = curves.some(({ key }) => hidden.has(key)) ? _("Show all") : _("Hide all");
  }
  function choose(curves, isShown) {
    for (const { key } of curves) isShown ? hidden.delete(key) : hidden.add(key);
    keep(HIDDEN, JSON.stringify([...hidden].slice(-500)));
    groups.forEach(mark);
    redraw();
  }

  // Time

  const within = (t) => Math.max(0, Math.min(t, player.duration));
  function zoom(factor) {
    const all = player.duration || (file.samples * frame);
    const length = Math.min(Math.max((view.to - view.from) * factor, LEAST_FRAMES * frame), all);
    const share = factor === Infinity ? 0 : (now - view.from) / (view.to - view.from);
    place(now - share * length, length);
    zoomOut.disabled = length >= all;
    zoomIn.disabled = length <= LEAST_FRAMES * frame;
    if (factor !== Infinity) announce(span.textContent);
  }
  function place(from, length) {
    const all = player.duration || (file.samples * frame);
    view.from = Math.max(0, Math.min(from, all - length));
    view.to = view.from + length;
    span.textContent = _("%(from)s to %(to)s s", { from: number(view.from), to: number(view.to) });
    redraw();
  }
  /** Keep a moment in view. */
  function follow(t) {
    const length = view.to - view.from;
    if (t < view.from) place(t, length);
    else if (t > view.to) place(t - length, length);
  }
  function at(t) {
    if (sought !== null) return;
    now = t;
    follow(t);
    schedule();
  }
  const timeAt = (plot, x) => {
    const box = plot.getBoundingClientRect();
    return within(view.from + ((x - box.left) / box.width) * (view.to - view.from));
  };
  function grab(event) {
    if (event.button) return;
    const plot = event.currentTarget;
    plot.focus({ preventScroll: true });
    plot.setPointerCapture(event.pointerId);
    hovered = null;
    drag(plot, event.clientX);
  }
  function drag(plot, x) {
    sought = now = timeAt(plot, x);
    follow(now);
    schedule();
  }
  function point(event) {
    if (event?.buttons && event.currentTarget.hasPointerCapture(event.pointerId)) drag(event.currentTarget, event.clientX);
    else hovered = event && event.pointerType !== "touch" ? timeAt(event.currentTarget, event.clientX) : null;
    schedule();
  }
  function byKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
    if (way && !event.shiftKey) player.step(way);
    else if (way) player.go(within(now + way * SECOND));
    else if (event.key === "Home") player.go(0);
    else if (event.key === "End") player.go(player.duration);
    else if (event.key === "+") zoom(1 / ZOOM);
    else if (event.key === "-" || event.key === "−") zoom(ZOOM);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // Drawing

  function redraw() {
    isStale = true;
    schedule();
  }
  function schedule() {
    scheduled ||= requestAnimationFrame(draw);
  }
  function draw() {
    scheduled = 0;
    if (!body.offsetWidth) return; // closed
    if (isStale) {
      isStale = false;
      const style = getComputedStyle(body);
      colours = Array.from({ length: COLOURS }, (_each, i) => style.getPropertyValue(`--series-${i}`));
      for (const group of groups) drawCurves(group);
    }
    const t = hovered ?? now;
    const place = (line, at) => line.style.setProperty("left", `${(100 * (at - view.from)) / (view.to - view.from)}%`);
    const values = valuesAt(t);
    for (const group of groups) {
      const { curves, plot, line, hover, format } = group;
      place(line, now);
      hover.hidden = hovered === null;
      if (hovered !== null) place(hover, hovered);
      const told = [];
      for (const curve of curves) {
        const value = values ? values[curve.index] : NaN;
        const text = Number.isNaN(value) ? "–" : format.format(value);
        if (curve.value.textContent !== text) curve.value.textContent = text;
        if (!hidden.has(curve.key)) told.push(`${curve.name} ${text}`);
      }
      plot.setAttribute("aria-valuemax", player.duration);
      plot.setAttribute("aria-valuenow", now);
      plot.setAttribute("aria-valuetext", _("%(time)s seconds", { time: number(now) }) + (told.length ? `: ${told.join(", ")}` : ""));
    }
    if (sought !== null && !player.video.seeking) {
      const to = sought;
      sought = null;
      player.go(to);
    }
  }
  /** The numbers of the frame that is shown at a time; null if they haven't come yet. */
  function valuesAt(t) {
    const row = Math.max(0, Math.min(Math.floor((t + startS) * file.rate + 1e-3), file.samples - 1));
    const part = file.part(0, row, row + 1);
    if (!part) return null;
    const [[first, numbers]] = part;
    const { width } = file.levels[0];
    return numbers.subarray((row - first) * width, (row - first + 1) * width);
  }
  /** The least and the greatest of what is shown of a group, at any time. */
  function rangeOf(curves) {
    const level = file.levels.length - 1;
    const { width, rows } = file.levels[level];
    let [low, high] = [Infinity, -Infinity];
    for (const [, numbers] of file.part(level, 0, rows) ?? []) {
      for (let at = 0; at < numbers.length; at += width) {
        for (const { index, key } of curves) {
          if (hidden.has(key)) continue;
          const [least, most] = level ? [numbers[at + 2 * index], numbers[at + 2 * index + 1]] : [numbers[at + index], numbers[at + index]];
          if (least < low) low = least;
          if (most > high) high = most;
        }
      }
    }
    if (low > high) return [0, 1];
    return low === high ? [low - 0.5, high + 0.5] : [low, high];
  }
  function drawCurves(group) {
    const { canvas, curves, high, low } = group;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const ratio = devicePixelRatio || 1;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const [least, most] = rangeOf(curves);
    const digits = Math.max(0, Math.min(3 - Math.floor(Math.log10(most - least)), 4));
    group.format = new Intl.NumberFormat(document.documentElement.lang || "en", { minimumFractionDigits: digits, maximumFractionDigits: digits, signDisplay: "negative" });
    high.textContent = group.format.format(most);
    low.textContent = group.format.format(least);
    const down = (-height * (1 - 2 * MARGIN)) / (most - least); // pixels for each unit
    const zero = height * (1 - MARGIN) - down * least;
    const shown = curves.filter(({ key }) => !hidden.has(key));
    const level = levelFor(width);
    const rate = file.rate / file.levels[level].step;
    const across = width / (view.to - view.from) / rate; // pixels for each row
    const left = (level ? across / 2 : 0) - (width * (startS + view.from)) / (view.to - view.from);
    const rows = file.levels[level].rows;
    const first = Math.max(Math.floor((view.from + startS) * rate) - 1, 0);
    const end = Math.min(Math.ceil((view.to + startS) * rate) + 2, rows);
    const part = end > first ? file.part(level, first, end) : [];
    pen.lineWidth = 1; // a hairline is drawn in half the time of a wider line
    pen.lineJoin = "bevel";
    for (const { index, series, isDashed } of shown) {
      pen.strokeStyle = colours[series];
      pen.setLineDash(isDashed ? DASHES : []);
      pen.beginPath();
      trace(pen, part, { width: file.levels[level].width, offset: level ? 2 * index : index, more: level ? 1 : 0, first, end }, { across, left, down, zero });
      pen.stroke();
    }
  }
  /** The finest array that has come of those that have a row for each pixel. */
  function levelFor(width) {
    const seconds = view.to - view.from;
    let level = 0;
    file.levels.forEach((one, i) => (one.step ??= i ? file.levels[i - 1].step * Math.round(file.levels[i - 1].rows / one.rows) : 1));
    while (level + 1 < file.levels.length && (seconds * file.rate) / file.levels[level + 1].step >= width) level += 1;
    const has = (k) => {
      const rate = file.rate / file.levels[k].step;
      const end = Math.min(Math.ceil((view.to + startS) * rate) + 2, file.levels[k].rows);
      return file.part(k, Math.max(Math.floor((view.from + startS) * rate) - 1, 0), end);
    };
    missing = has(level) ? -1 : level;
    while (level + 1 < file.levels.length && !has(level)) level += 1;
    return level;
  }
  /** Draw rows as a line; several on a pixel as the least and the greatest of them. */
  function trace(pen, part, { width, offset, more, first, end }, { across, left, down, zero }) {
    let pixel = -Infinity;
    let [low, high] = [Infinity, -Infinity];
    let isBroken = true;
    const put = () => {
      if (low > high) return;
      if (isBroken) pen.moveTo(pixel, zero + down * low);
      else pen.lineTo(pixel, zero + down * low);
      if (high !== low) pen.lineTo(pixel, zero + down * high);
      isBroken = false;
      [low, high] = [Infinity, -Infinity];
    };
    for (const [start, numbers] of part ?? []) {
      const last = Math.min(end, start + numbers.length / width);
      for (let row = Math.max(first, start); row < last; row += 1) {
        const at = (row - start) * width + offset;
        const least = numbers[at];
        if (Number.isNaN(least)) {
          put();
          isBroken = true;
          continue;
        }
        const place = left + across * row;
        if (place - pixel >= 1) {
          put();
          pixel = place;
        }
        if (least < low) low = least;
        if (numbers[at + more] > high) high = numbers[at + more];
      }
    }
    put();
  }

  return {
    at,
    redraw,
    /** A part has come: numbers of the moment, or curves in more detail. */
    came: (level) => (level === missing ? redraw() : schedule()),
  };
}
