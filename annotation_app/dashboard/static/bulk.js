// Ticks all answers on the page, or none.

const every = document.getElementById("every");
const boxes = [...document.querySelectorAll('input[name="answer"]')];
if (every) {
  every.closest("label").hidden = false;
  every.addEventListener("change", () => boxes.forEach((box) => { box.checked = every.checked; }));
  for (const box of boxes) {
    box.addEventListener("change", () => { every.checked = boxes.every((one) => one.checked); });
  }
}
