// Takes a case folder, hands it to the program in a worker, and shows what comes back.
const at = (id) => document.getElementById(id);

/// Files that are dropped, with their paths in the folder; folders are read to the bottom.
async function dropped(items) {
  const entries = Array.from(items, (item) => item.webkitGetAsEntry()).filter(Boolean);
  const files = [];
  const read = async (entry, folder) => {
    if (entry.isFile) {
      const file = await new Promise((done, failed) => entry.file(done, failed));
      files.push([folder + file.name, file]);
      return;
    }
    const reader = entry.createReader();
    for (;;) {
      const some = await new Promise((done, failed) => reader.readEntries(done, failed));
      if (some.length === 0) return;
      for (const inner of some) await read(inner, `${folder}${entry.name}/`);
    }
  };
  for (const entry of entries) await read(entry, "");
  return files;
}

/// The folder that holds `case.toml`: its name, and its files by their names within it.
function caseOf(files) {
  const toml = files.find(([path]) => /(^|\/)case\.toml$/.test(path));
  if (!toml) return null;
  const folder = toml[0].slice(0, -"case.toml".length);
  const inside = files.filter(([path]) => path.startsWith(folder)).map(([path, file]) => [path.slice(folder.length), file]);
  return { name: folder.split("/").at(-2) || "case", inside };
}

async function run(files) {
  for (const id of ["text", "save", "report"]) at(id).hidden = true;
  const chosen = caseOf(files);
  if (!chosen) {
    at("state").textContent = "There is no case.toml among these files.";
    return;
  }
  at("state").textContent = "Working …";
  const contents = await Promise.all(chosen.inside.map(async ([name, file]) => [name, new Uint8Array(await file.arrayBuffer())]));
  const worker = new Worker("worker.js", { type: "module" });
  const started = performance.now();
  const ended = await new Promise((done) => {
    worker.onmessage = ({ data }) => done(data);
    worker.onerror = ({ message }) => done({ code: 1, out: "", err: message });
    worker.postMessage({ command: at("command").value, name: chosen.name, files: contents });
  });
  worker.terminate();
  const seconds = ((performance.now() - started) / 1000).toFixed(1);
  at("state").textContent = ended.code === 0 ? `Done in ${seconds} s.` : `No answer (exit code ${ended.code}).`;
  at("text").textContent = ended.out + ended.err;
  at("text").hidden = false;
  if (!ended.report) return;
  const address = URL.createObjectURL(new Blob([ended.report], { type: "text/html" }));
  at("link").href = address;
  at("report").src = address;
  at("save").hidden = at("report").hidden = false;
}

at("folder").addEventListener("change", ({ target }) => {
  run(Array.from(target.files, (file) => [file.webkitRelativePath || file.name, file]));
});
const drop = at("drop");
drop.addEventListener("dragover", (event) => {
  event.preventDefault();
  drop.classList.add("over");
});
drop.addEventListener("dragleave", () => drop.classList.remove("over"));
drop.addEventListener("drop", async (event) => {
  event.preventDefault();
  drop.classList.remove("over");
  run(await dropped(event.dataTransfer.items));
});
