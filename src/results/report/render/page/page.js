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

// Tables whose heads sort their rows. A value is the text of its cell, or `data-value` where the text has another order.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
  const value = (row, column) => {
    const cell = row.cells[column], text = cell.dataset.value ?? cell.textContent.trim();
    return text !== "" && isFinite(text) ? Number(text) : text;
  };
  const order = (a, b) => (typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b)));
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const known = head.getAttribute("aria-sort");
      // Numbers are most interesting from above, words from the start of the alphabet.
      const down = known ? known === "ascending" : head.classList.contains("number");
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const rows = [...body.rows].map((row) => [value(row, column), row]);
      rows.sort((a, b) => (down ? order(b[0], a[0]) : order(a[0], b[0])));
      body.append(...rows.map(([, row]) => row));
    });
  });
}

// Sections are open where there is room for them. A link into a closed one opens it.
for (const part of document.querySelectorAll("details.part:not(.deep)")) part.open = matchMedia("(min-width: 701px)").matches;
const reveal = (hash) => {
  const target = document.getElementById(hash.slice(1));
  for (let folded = target?.closest("details:not([open])"); folded; folded = folded.parentElement.closest("details:not([open])")) folded.open = true;
  target?.scrollIntoView();
};
addEventListener("hashchange", () => reveal(location.hash));
document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href^='#']");
  if (link && link.hash === location.hash) reveal(link.hash);
});
if (location.hash) reveal(location.hash);

// When the file was written.
const made = document.getElementById("made");
if (made) {
  const date = new Date(document.lastModified);
  made.dateTime = date.toISOString();
  made.textContent = "Written on " + date.toLocaleDateString("en-GB", { dateStyle: "long" });
  made.hidden = false;
}
