// Adds files to the study's folder in parts, one file after the other.

const PART = 768 * 1024;
const box = document.getElementById("upload");
const input = document.getElementById("files");
const list = document.getElementById("uploads");
const drop = input.closest("label");

function row(file) {
  const item = document.createElement("li");
  const name = document.createElement("bdi");
  name.textContent = file.name;
  const progress = document.createElement("progress");
  progress.max = file.size || 1;
  progress.value = 0;
  progress.setAttribute("aria-label", `Part of ${file.name} that is there`);
  item.append(name, progress);
  list.append(item);
  return {
    at: (bytes) => { progress.value = bytes; },
    wrong(text, replace) {
      progress.remove();
      const why = document.createElement("span");
      why.className = "wrong";
      why.textContent = text;
      item.append(why);
      if (!replace) return;
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = `Replace ${file.name}`;
      button.addEventListener("click", () => { item.remove(); replace(); });
      item.append(button);
    },
  };
}

async function send(file, name, shown, replacing) {
  for (let offset = 0; offset === 0 || offset < file.size; offset += PART) {
    const about = new URLSearchParams({ file: name, offset, size: file.size, ...(replacing && { replace: "yes" }) });
    const reply = await fetch(`${box.dataset.url}?${about}`, {
      method: "POST",
      headers: { "X-CSRFToken": box.dataset.token, "Content-Type": "application/octet-stream", Accept: "application/json" },
      body: file.slice(offset, offset + PART),
    });
    if (!reply.ok) {
      const told = await reply.json().catch(() => ({}));
      const error = new Error(told.error ?? `The server refused it (${reply.status}).`);
      throw Object.assign(error, { mayReplace: told.may_replace });
    }
    shown.at(Math.min(offset + PART, file.size));
  }
}

let waiting = 0; // for how many choices of files
let failed = 0;

async function add(files, replaced) {
  waiting += 1;
  for (const [file, shown] of [...files].map((file) => [file, row(file)])) {
    const name = replaced ?? file.name;
    try {
      await send(file, name, shown, replaced !== undefined);
    } catch (error) {
      failed += 1;
      const text = error instanceof TypeError ? "There is no network. Add it again." : error.message;
      shown.wrong(text, error.mayReplace && (() => add([file], name)));
    }
  }
  waiting -= 1;
  if (waiting) return;
  // What is there now is listed by the page; what failed stays to be read.
  if (!failed) location.assign(location.pathname);
  failed = 0;
}

function watch(input, replaced) {
  const chosen = () => add(input.files, replaced).then(() => { input.value = ""; });
  input.addEventListener("change", chosen);
  if (input.files.length) chosen(); // before this script had come
}

watch(input);
document.getElementById("droppable").hidden = false;
for (const other of document.querySelectorAll("[data-replace]")) {
  other.closest("label").hidden = false;
  watch(other, other.dataset.replace);
}
for (const name of ["dragover", "dragleave", "drop"]) {
  drop.addEventListener(name, (event) => {
    event.preventDefault();
    drop.classList.toggle("over", name === "dragover");
    if (name === "drop") add(event.dataTransfer.files);
  });
}
