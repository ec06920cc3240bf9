// Runs the program once, on files that lie in memory.
import { ConsoleStdout, Directory, File, OpenFile, PreopenDirectory, WASI } from "./shim/index.js";

/// Files by their paths as folders within folders.
function folder(files) {
  const root = new Map();
  for (const [path, content] of files) {
    const names = path.split("/");
    const name = names.pop();
    let at = root;
    for (const inner of names) {
      if (!at.has(inner)) at.set(inner, new Directory(new Map()));
      at = at.get(inner).contents;
    }
    at.set(name, new File(content));
  }
  return root;
}

onmessage = async ({ data: { command, name, files } }) => {
  const text = { out: "", err: "" };
  const collect = (to) => {
    const decoder = new TextDecoder();
    return new ConsoleStdout((bytes) => (text[to] += decoder.decode(bytes, { stream: true })));
  };
  const root = new PreopenDirectory("/", new Map([[name, new Directory(folder(files))]]));
  const descriptors = [new OpenFile(new File([])), collect("out"), collect("err"), root];
  const program = ["truing", command, `/${name}`, "--report", "/report.html"];
  const wasi = new WASI(program, [], descriptors, { debug: false });
  const { instance } = await WebAssembly.instantiateStreaming(fetch("truing.wasm"), {
    wasi_snapshot_preview1: wasi.wasiImport,
  });
  let code = 1;
  try {
    code = wasi.start(instance);
  } catch (error) {
    text.err += `${error}\n`;
  }
  const report = root.dir.contents.get("report.html");
  postMessage({ code, ...text, report: report?.data });
};
