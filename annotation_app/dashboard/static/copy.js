// Copies the link, or a token, to the clipboard. Where browsers don't allow that, it is selected.
const link = document.getElementById("link");
const button = document.getElementById("copy");
const copied = document.getElementById("copied");
const what = link.dataset.what ?? "link";

link.addEventListener("focus", () => link.select());
button.hidden = false;
button.addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(link.value);
    copied.textContent = `The ${what} is copied.`;
  } catch {
    link.focus();
    link.select();
    copied.textContent = `The ${what} is selected: copy it with your keyboard or its menu.`;
  }
});
