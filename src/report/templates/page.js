"use strict";
// Tables that are sorted by a click on a head, and values under the pointer in plots.

// A cell as a number: 1.2·10⁻⁷, 12 %, 3.4 (...); else its text.
function value(text) {
  const plain = text.replace(/[⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹]+/g, (power) => [...power].map((c) => "-+0123456789"["⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(c)]).join(""))
                    .replace(/\s*[·×]\s*10/, "e").replace(/−/g, "-");
  const number = parseFloat(plain);
  return Number.isNaN(number) ? text : number;
}

for (const table of document.querySelectorAll(".wide table")) {
  const head = table.rows[0];
  if (table.rows.length < 4) continue;
  [...head.cells].forEach((cell, column) => {
    if (!cell.textContent.trim()) return;
    const button = document.createElement("button");
    button.textContent = cell.textContent;
    button.title = "sort by this column";
    cell.replaceChildren(button);
    button.addEventListener("click", () => {
      const down = cell.getAttribute("aria-sort") === "ascending", rows = [...table.rows].slice(1);
      const order = (a, b) => {
        const x = value(a.cells[column]?.textContent ?? ""), y = value(b.cells[column]?.textContent ?? "");
        if (typeof x === "number" && typeof y === "number") return x - y;
        return typeof x === typeof y ? String(x).localeCompare(String(y)) : typeof x === "number" ? -1 : 1;
      };
      rows.sort((a, b) => (down ? order(b, a) : order(a, b)));
      for (const row of rows) head.parentNode.append(row);
      for (const other of head.cells) other.removeAttribute("aria-sort");
      cell.setAttribute("aria-sort", down ? "descending" : "ascending");
    });
  });
}

for (const svg of document.querySelectorAll("figure svg[data-axes]")) {
  const axes = JSON.parse(svg.dataset.axes), [left, right, top, bottom] = axes.pixels, size = svg.viewBox.baseVal;
  const label = document.createElement("output");
  label.className = "reading";
  svg.after(label);
  const between = ([low, high], part, log) => (log ? low * (high / low) ** part : low + (high - low) * part);
  const text = (number) => Number(number.toPrecision(4)).toString();
  svg.addEventListener("pointermove", (event) => {
    const box = svg.getBoundingClientRect();
    const px = (event.clientX - box.left) / box.width * size.width, py = (event.clientY - box.top) / box.height * size.height;
    if (px < left || px > right || py < top || py > bottom) { label.textContent = ""; return; }
    const x = between(axes.x, (px - left) / (right - left), axes.log_x), y = between(axes.y, (bottom - py) / (bottom - top), axes.log_y);
    label.textContent = `${text(x)}, ${text(y)}`;
  });
  svg.addEventListener("pointerleave", () => { label.textContent = ""; });
}
