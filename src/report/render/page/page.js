"use strict";
// The reader's choice of light or dark. It lasts while this page is open, since a file has no place to store it.
(() => {
  const root = document.documentElement, button = document.getElementById("theme");
  root.classList.add("js");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const dark = () => (root.dataset.theme || (system.matches ? "dark" : "light")) === "dark";
  const show = () => {
    button.textContent = dark() ? "Light" : "Dark";
    button.setAttribute("aria-label", dark() ? "Show in light colours" : "Show in dark colours");
    document.dispatchEvent(new Event("colours"));
  };
  button.hidden = false;
  button.addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; show(); });
  system.addEventListener("change", show);
  show();
})();
