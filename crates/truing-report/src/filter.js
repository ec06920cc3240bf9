// Shows only the rows that hold every word typed. The page is complete without it.
const index = document.querySelector("main.index");
const rows = index ? Array.from(index.querySelectorAll("tbody tr")) : [];
if (rows.length > 1) {
  const field = document.createElement("input");
  field.type = "search";
  field.placeholder = "filter: a kind, an effect, a verdict …";
  field.setAttribute("aria-label", "show only rows with these words");
  const shown = document.createElement("span");
  shown.className = "quiet";
  const line = document.createElement("p");
  line.className = "filter";
  line.append(field, " ", shown);
  index.querySelector("header").append(line);
  const folds = Array.from(index.querySelectorAll("details.folded"));
  const open = folds.map((fold) => fold.open);
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    for (const row of rows) {
      const fold = row.closest("details");
      const text = (row.textContent + (fold ? fold.firstElementChild.textContent : "")).toLowerCase();
      row.hidden = !words.every((word) => text.includes(word));
      if (!row.hidden) count += 1;
    }
    folds.forEach((fold, i) => {
      const some = Array.from(fold.querySelectorAll("tbody tr")).some((row) => !row.hidden);
      fold.hidden = !some;
      fold.open = words.length > 0 ? some : open[i];
    });
    shown.textContent = words.length > 0 ? `${count} of ${rows.length} cases` : "";
  });
}
