// Copies the link to the clipboard. Where browsers don't allow that, the link is selected.
const link = document.getElementById("link");
const button = document.getElementById("copy");
const copied = document.getElementById("copied");

link.addEventListener("focus", () => link.select());
button.hidden = false;
button.addEventListener("click", async () => {
  try {
    await navigator.clipboard.writeText(link.value);
    copied.textContent = "The link is copied.";
  } catch {
    link.focus();
    link.select();
    copied.textContent = "The link is selected: copy it with your keyboard or its menu.";
  }
});
