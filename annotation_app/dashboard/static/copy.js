// Copies the link, or a token, to the clipboard. Where browsers don't allow that, it is selected.
const link = document.getElementById("link");
const button = document.getElementById("copy");
const copied = document.getElementById("copied");
const what = link.dataset.what ?? "link";

link.addEventListener("focus", () => link.select());
button.hidden = false;
button.addEventListener("click", () => {
  link.focus();
  // navigator.clipboard is missing on pages without TLS, and its answer may never come.
  if (document.execCommand("copy")) {
    copied.textContent = `The ${what} is copied.`;
    button.focus();
  } else {
    copied.textContent = `The ${what} is selected: copy it with your keyboard or its menu.`;
  }
});
