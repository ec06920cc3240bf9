// Enlarges the part of a plot that a mouse or pen is dragged over; a double click shows all of it
// again. Fingers have the browser's own zoom. The page is complete without it.
const plots = Array.from(document.querySelectorAll("svg.plot"));
const SMALLEST = 8;
for (const svg of plots) {
  const whole = svg.viewBox.baseVal;
  const [width, height] = [whole.width, whole.height];
  const labels = Array.from(svg.querySelectorAll("text:not(.title)"), (text) => [text, text.getAttribute("x"), text.getAttribute("y")]);
  const frame = document.createElementNS(svg.namespaceURI, "rect");
  frame.setAttribute("class", "lens");
  const at = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  let start = null;
  const show = (x, y, zoom) => {
    svg.setAttribute("viewBox", `${x} ${y} ${width / zoom} ${height / zoom}`);
    svg.style.setProperty("--zoom", zoom);
    svg.classList.toggle("zoomed", zoom > 1);
    // Ticks stay at the edge that they belong to.
    for (const [text, left, top] of labels) {
      const is = (side) => (zoom > 1 ? text.classList.contains(side) : false);
      text.setAttribute("x", is("end") ? x + (width / zoom) * 0.06 : left);
      text.setAttribute("y", is("middle") ? y + (height - 4) / zoom : top);
    }
  };
  svg.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch" || event.button !== 0) return;
    start = at(event);
    svg.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  svg.addEventListener("pointermove", (event) => {
    if (!start) return;
    const end = at(event);
    const sides = { x: Math.min(start.x, end.x), y: Math.min(start.y, end.y), width: Math.abs(end.x - start.x), height: Math.abs(end.y - start.y) };
    for (const [name, value] of Object.entries(sides)) frame.setAttribute(name, value);
    svg.append(frame);
  });
  const leave = () => {
    start = null;
    frame.remove();
  };
  svg.addEventListener("pointerup", () => {
    const box = frame.isConnected ? frame.getBBox() : null;
    leave();
    if (!box || SMALLEST > Math.max(box.width, box.height) * svg.getScreenCTM().a) return;
    // As wide to its height as the whole, about the middle of what was dragged over.
    const zoom = Math.min(width / Math.max(box.width, 1e-3), height / Math.max(box.height, 1e-3));
    show(box.x + 0.5 * (box.width - width / zoom), box.y + 0.5 * (box.height - height / zoom), zoom);
  });
  svg.addEventListener("pointercancel", leave);
  const all = () => show(0, 0, 1);
  svg.addEventListener("dblclick", all);
  addEventListener("beforeprint", all);
}
if (plots.length > 0) {
  const hint = document.createElement("p");
  hint.className = "quiet hint";
  hint.textContent = "Drag over a plot to enlarge a part of it; a double click shows all of it again.";
  const contents = document.querySelector("nav");
  if (contents) contents.append(hint);
  else document.querySelector("header").after(hint);
}
