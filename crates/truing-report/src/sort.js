// Makes column heads sort their table. The page is complete without it.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  if (body.rows.length === 1) continue;
  Array.from(table.tHead.rows[0].cells).forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "ascending";
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      const value = (row) => {
        const cell = row.cells[column];
        return "sort" in cell.dataset ? Number(cell.dataset.sort) : cell.textContent;
      };
      const compare = (a, b) => {
        const [x, y] = [value(a), value(b)];
        if (typeof x !== typeof y) return typeof x === "number" ? -1 : 1;
        const order = typeof x === "number" ? x - y : x.localeCompare(y, "en", { numeric: true });
        return down ? -order : order;
      };
      body.append(...Array.from(body.rows).sort(compare));
    });
  });
}
// Every table as a file for a spreadsheet.
for (const table of document.querySelectorAll("table")) {
  const rows = Array.from(table.rows);
  if (rows.length === 1) continue;
  const button = document.createElement("button");
  button.className = "save";
  button.textContent = "Save as CSV";
  button.addEventListener("click", () => {
    const quoted = (cell) => {
      const text = "sort" in cell.dataset ? cell.dataset.sort : cell.textContent.trim().replaceAll("\u2212", "-");
      return '"' + text.replaceAll('"', '""') + '"';
    };
    const lines = rows.map((row) => Array.from(row.cells).map(quoted).join(","));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([lines.join("\r\n") + "\r\n"], { type: "text/csv" }));
    const heading = table.closest("section")?.querySelector("h2")?.textContent ?? document.title;
    link.download = heading.trim().toLowerCase().replaceAll(/[^a-z0-9]+/g, "-") + ".csv";
    link.click();
    URL.revokeObjectURL(link.href);
  });
  (table.closest(".scroll") ?? table).after(button);
}
// What is folded is printed all the same, also where the style sheet cannot say so.
addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
});
