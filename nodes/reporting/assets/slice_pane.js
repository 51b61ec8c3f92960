"use strict";
// One of the three planes of a slice viewer.

const PLANES = {
  // Screen axes as index axes (`up` runs against the rows); letters stand left, right, top, bottom.
  // Axial and coronal as radiologists read them: the patient's right is on the viewer's left.
  axial: { across: 0, down: 1, up: false, through: 2, letters: "RLAP" },
  coronal: { across: 0, down: 2, up: true, through: 1, letters: "RLSI" },
  sagittal: { across: 1, down: 2, up: true, through: 0, letters: "APSI" },
};
const STEPS = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 };

class SlicePane {
  constructor(viewer, name) {
    this.viewer = viewer;
    this.name = name;
    this.plane = PLANES[name];
    this.root = viewer.root.querySelector(`.pane[data-plane='${name}']`);
    this.frame = this.root.querySelector(".frame");
    this.canvas = this.root.querySelector("canvas");
    this.slider = this.root.querySelector("input");
    this.measure();
    this.addLetters();
    this.listen();
  }

  measure() {
    const { across, down, through } = this.plane;
    const { shape, spacing_mm: spacing } = this.viewer.header;
    [this.wide, this.high] = [across, down].map((axis) => shape[axis] * spacing[axis]);
    this.canvas.width = shape[across];
    this.canvas.height = shape[down];
    this.slider.max = shape[through] - 1;
    this.context = this.canvas.getContext("2d");
    this.picture = this.context.createImageData(shape[across], shape[down]);
    this.root.style.setProperty("--wide", this.wide);
    this.root.style.setProperty("--high", this.high);
  }

  showScale(bar) {
    const scale = this.root.querySelector(".scale");
    scale.style.width = `${(100 * bar) / this.wide}%`;
    scale.textContent = `${bar} mm`;
  }

  addLetters() {
    ["left", "right", "top", "bottom"].forEach((side, n) => {
      const letter = document.createElement("span");
      letter.className = `letter ${side}`;
      letter.textContent = this.plane.letters[n];
      this.frame.append(letter);
    });
  }

  listen() {
    const { viewer, slider, frame } = this;
    const { through } = this.plane;
    slider.addEventListener("input", () => viewer.moveTo(through, Number(slider.value)));
    frame.addEventListener("wheel", (event) => this.turnWheel(event), { passive: false });
    frame.addEventListener("keydown", (event) => this.pressKey(event));
    frame.addEventListener("pointerdown", (event) => this.press(event));
    frame.addEventListener("pointermove", (event) => this.drag(event));
    frame.addEventListener("pointerleave", () => viewer.pointAt(null));
    frame.addEventListener("contextmenu", (event) => event.preventDefault());
    this.root.querySelector(".enlarge").addEventListener("click", () => viewer.enlarge(this.name));
  }

  turnWheel(event) {
    // At the last slice the page scrolls on, so that nobody is caught in a picture.
    if (event.ctrlKey || !event.deltaY) return;
    const { viewer } = this;
    const { through } = this.plane;
    const forward = through === 2 ? -1 : 1; // downwards is towards the feet
    const moved = viewer.moveTo(through, viewer.at[through] + Math.sign(event.deltaY) * forward);
    if (moved) event.preventDefault();
  }

  pressKey(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { viewer } = this;
    const { through } = this.plane;
    const end = viewer.header.shape[through] - 1;
    const place = { Home: 0, End: end }[event.key] ?? viewer.at[through] + STEPS[event.key];
    if (!Number.isNaN(place)) viewer.moveTo(through, place);
    else if (!viewer.pressKey(event.key.toLowerCase())) return;
    event.preventDefault();
  }

  press(event) {
    this.drag(event);
    // A drag goes on beyond the picture's edge; a finger may still scroll the page.
    if (event.pointerType === "mouse") this.frame.setPointerCapture(event.pointerId);
  }

  drag(event) {
    const { viewer } = this;
    const at = this.voxelUnder(event);
    viewer.pointAt(at);
    if (event.buttons === 1 && at) viewer.goTo(at);
    if (event.buttons === 2) viewer.shiftWindow(event.movementX, event.movementY);
  }

  voxelUnder(event) {
    // The voxel of this plane under the pointer, or null beside the picture.
    const box = this.canvas.getBoundingClientRect();
    const { across, down, up } = this.plane;
    const { shape } = this.viewer.header;
    const x = (event.clientX - box.left) / box.width;
    const y = (event.clientY - box.top) / box.height;
    if (x < 0 || x >= 1 || y < 0 || y >= 1) return null;
    const at = [...this.viewer.at];
    at[across] = Math.floor(x * shape[across]);
    at[down] = Math.floor(y * shape[down]);
    if (up) at[down] = shape[down] - 1 - at[down];
    return at;
  }

  draw() {
    const { viewer } = this;
    const { across, down, up, through } = this.plane;
    const { shape, strides } = viewer.voxels;
    const [w, h] = [shape[across], shape[down]];
    const [dx, dy] = [strides[across], up ? -strides[down] : strides[down]];
    const start = viewer.at[through] * strides[through] + (up ? (h - 1) * strides[down] : 0);
    this.fill(start, dx, dy, w, h);
    this.context.putImageData(this.picture, 0, 0);
    this.root.dataset.slice = viewer.at[through];
    this.slider.value = viewer.at[through];
    const number = `${viewer.at[through] + 1} of ${shape[through]}`;
    this.root.querySelector(".number").textContent = number;
    this.canvas.setAttribute("aria-label", `${this.name} slice ${number}, ${viewer.found}`);
    this.placeLines(w, h);
  }

  fill(start, dx, dy, w, h) {
    const { viewer } = this;
    const { greys: stored, labels: numbers } = viewer.voxels;
    const { data } = this.picture;
    for (let y = 0, p = 0; y < h; y += 1) {
      for (let x = 0; x < w; x += 1, p += 4) {
        const n = start + x * dx + y * dy;
        const grey = viewer.shown[stored[n]];
        const value = numbers[n];
        const label = value ? viewer.labels[value - 1] : undefined;
        data[p] = data[p + 1] = data[p + 2] = grey;
        data[p + 3] = 255;
        if (!label || !label.visible || label.opacity === 0) continue;
        const rim =
          (x > 0 && numbers[n - dx] !== value) || (x < w - 1 && numbers[n + dx] !== value) ||
          (y > 0 && numbers[n - dy] !== value) || (y < h - 1 && numbers[n + dy] !== value);
        if (!rim && viewer.outlined) continue;
        // A label's rim is drawn stronger than its inside, so that the image shows through.
        const share = rim ? Math.min(1, label.opacity * 2.5) : label.opacity;
        for (let c = 0; c < 3; c += 1) data[p + c] = grey + share * (label.rgb[c] - grey);
      }
    }
  }

  placeLines(w, h) {
    const { across, down, up } = this.plane;
    const { at } = this.viewer;
    const y = (at[down] + 0.5) / h;
    this.root.querySelector(".line.vertical").style.left = `${((at[across] + 0.5) / w) * 100}%`;
    this.root.querySelector(".line.horizontal").style.top = `${(up ? 1 - y : y) * 100}%`;
  }
}
