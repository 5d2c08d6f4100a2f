// Making elements. Text is always set as text, never as HTML.

import { read, write } from "./storage.js";

const SVG = "http://www.w3.org/2000/svg";

export const $ = (id) => document.getElementById(id);

export function h(tag, properties = {}, ...children) {
  return fill(document.createElement(tag), properties, children);
}

export function s(tag, properties = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), properties, children);
}

function fill(element, properties, children) {
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** A radio button or box to tick, with its label around it. */
export function choice(type, name, label, checked, onchange, extra = {}) {
  const input = h("input", { type, name, onchange, ...extra });
  input.checked = checked;
  return h("label", { class: "choice" }, input, h("span", {}, label));
}

/** Say something to people who listen to the page. */
export function announce(text) {
  const live = $("announcements");
  if (!live) return;
  live.textContent = "";
  setTimeout(() => (live.textContent = text), 50);
}

/** Whether a key is typed into something that takes text or arrows itself. */
export function isTyping(event) {
  const at = event.target;
  return (
    at instanceof HTMLTextAreaElement ||
    at instanceof HTMLSelectElement ||
    (at instanceof HTMLInputElement && !["radio", "checkbox", "range"].includes(at.type)) ||
    Boolean(at.closest?.("dialog"))
  );
}

const SINGLE_KEYS = "g3:single-keys";

/** Who dictates to the browser may not want single keys to do anything. */
export const usesSingleKeys = () => read(SINGLE_KEYS) !== "off";
export const useSingleKeys = (yes) => write(SINGLE_KEYS, yes ? "on" : "off");

/** Whether a key is pressed to do something rather than typed. */
export function isShortcut(event) {
  return usesSingleKeys() && !isTyping(event) && !event.ctrlKey && !event.metaKey && !event.altKey;
}

/** Draw something anew and leave the focus where it was, on the element with the same key. */
export function redraw(container, ...children) {
  const key = container.contains(document.activeElement)
    ? document.activeElement.dataset.key
    : undefined;
  container.replaceChildren(...children.flat().filter(Boolean));
  if (key) container.querySelector(`[data-key="${CSS.escape(key)}"]`)?.focus();
}
