"use strict";
// Slices of one volume in three planes. Data: see README.md beside this file.
(() => {
  const PLANES = {
    // Screen axes as [index axis, runs with the axis]; letters stand left, right, top, bottom.
    // Axial and coronal as radiologists read them: the patient's right is on the viewer's left.
    axial: { across: 0, down: 1, up: false, through: 2, letters: "RLAP" },
    coronal: { across: 0, down: 2, up: true, through: 1, letters: "RLSI" },
    sagittal: { across: 1, down: 2, up: true, through: 0, letters: "APSI" },
  };
  const DIRECTIONS = ["RL", "AP", "IS"]; // negative and positive end of each patient axis

  // ---- decoding -------------------------------------------------------------------------------
  async function decodeMosaic(image, header) {
    // Tile by tile, since phones limit the size of a canvas.
    await image.decode();
    const [ni, nj, nk] = header.shape;
    const { columns, width, height } = header.tiles;
    const canvas = document.createElement("canvas");
    canvas.width = ni;
    canvas.height = nj;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    const voxels = new Uint8Array(ni * nj * nk);
    for (let k = 0; k < nk; k += 1) {
      const x = (k % columns) * width;
      const y = Math.floor(k / columns) * height;
      context.drawImage(image, x, y, ni, nj, 0, 0, ni, nj);
      const { data } = context.getImageData(0, 0, ni, nj);
      for (let n = 0; n < ni * nj; n += 1) voxels[k * ni * nj + n] = data[4 * n];
    }
    return voxels;
  }

  function decodeLabels(voxels, step) {
    // Labels stand `step` greys apart, so that noise which a browser adds to a canvas against
    // fingerprinting does not turn one label into another.
    return voxels.map((grey) => Math.round(grey / step));
  }

  function valueOfGrey(header) {
    // The value that each grey stands for: the inverse of the curve that made the greys.
    const { knots, greys } = header;
    return Float64Array.from({ length: 256 }, (_, grey) => {
      let at = 1;
      while (at < greys.length - 1 && grey > greys[at]) at += 1;
      const share = (grey - greys[at - 1]) / (greys[at] - greys[at - 1]);
      return knots[at - 1] + share * (knots[at] - knots[at - 1]);
    });
  }

  function parseColour(text) {
    return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
  }

  // ---- one viewer -----------------------------------------------------------------------------
  class SliceViewer {
    constructor(root) {
      this.root = root;
      this.header = JSON.parse(root.querySelector("script[type='application/json']").textContent);
      this.values = valueOfGrey(this.header);
      this.at = this.header.shape.map((n) => Math.floor(n / 2));
      this.labels = this.header.labels.map((label) => ({ ...label, rgb: parseColour(label.colour) }));
      this.window = this.header.windows.find((item) => item.name === this.header.window);
    }

    async open() {
      const grey = this.root.querySelector("img.grey");
      const labels = this.root.querySelector("img.labels");
      this.greyVoxels = await decodeMosaic(grey, this.header);
      this.labelVoxels = labels
        ? decodeLabels(await decodeMosaic(labels, this.header), this.header.label_step)
        : new Uint8Array(this.greyVoxels.length);
      if (this.labels.length) this.at = this.findMiddleOfLabels();
      grey.remove();
      labels?.remove();
      this.panes = Object.keys(PLANES).map((name) => new Pane(this, name));
      this.addWindows();
      this.addLabels();
      this.draw();
      this.root.dataset.state = "ready";
    }

    findMiddleOfLabels() {
      // The first picture shows something: the middle of what is labelled and switched on.
      const [ni, nj, nk] = this.header.shape;
      const shown = new Set(this.labels.flatMap((label, n) => (label.visible ? [n + 1] : [])));
      const sum = [0, 0, 0];
      let count = 0;
      for (let k = 0, n = 0; k < nk; k += 1) {
        for (let j = 0; j < nj; j += 1) {
          for (let i = 0; i < ni; i += 1, n += 1) {
            if (!shown.has(this.labelVoxels[n])) continue;
            sum[0] += i;
            sum[1] += j;
            sum[2] += k;
            count += 1;
          }
        }
      }
      return count ? sum.map((total) => Math.round(total / count)) : this.at;
    }

    offset(i, j, k) {
      return i + this.header.shape[0] * (j + this.header.shape[1] * k);
    }

    moveTo(axis, place) {
      const limit = this.header.shape[axis] - 1;
      const next = Math.min(limit, Math.max(0, Math.round(place)));
      const moved = next !== this.at[axis];
      this.at[axis] = next;
      if (moved) this.draw();
      return moved;
    }

    draw() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        for (const pane of this.panes) pane.draw();
        this.writeReadout();
      });
    }

    greyTable() {
      // Display grey of each stored grey under the chosen window (DICOM PS3.3 C.11.2.1.2.1, linear
      // window without its half-step corrections).
      const { level, width } = this.window;
      return Uint8ClampedArray.from(this.values, (v) => 255 * ((v - level) / width + 0.5));
    }

    place() {
      const m = this.header.patient_from_index;
      return [0, 1, 2].map((r) => m[r][3] + this.at.reduce((sum, n, c) => sum + m[r][c] * n, 0));
    }

    writeReadout() {
      const n = this.offset(...this.at);
      const where = this.place().map((mm, axis) => {
        const letter = DIRECTIONS[axis][mm < 0 ? 0 : 1];
        return `${letter} ${Math.abs(mm).toFixed(0)}`;
      });
      const value = this.values[this.greyVoxels[n]];
      const about = Math.abs(value) < 10 ? value.toPrecision(2) : value.toFixed(0);
      const label = this.labels[this.labelVoxels[n] - 1];
      const parts = [`${where.join("  ")} mm`, `about ${about} ${this.header.unit}`];
      if (label) parts.push(label.name);
      this.root.querySelector(".readout").textContent = parts.join("  ·  ");
    }

    addWindows() {
      const box = this.root.querySelector(".windows");
      for (const item of this.header.windows) {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = item.name;
        const low = item.level - item.width / 2;
        const high = item.level + item.width / 2;
        button.title = `${low.toPrecision(4) * 1} to ${high.toPrecision(4) * 1} ${this.header.unit}`;
        button.addEventListener("click", () => this.chooseWindow(item, box));
        box.append(button);
      }
      this.chooseWindow(this.window, box);
    }

    chooseWindow(item, box) {
      this.window = item;
      for (const button of box.querySelectorAll("button")) {
        button.setAttribute("aria-pressed", String(button.textContent === item.name));
      }
      this.draw();
    }

    addLabels() {
      const box = this.root.querySelector(".parts");
      if (!this.labels.length) box.remove();
      for (const label of this.labels) {
        box.append(makePart(label, () => this.draw()));
      }
    }
  }

  function makePart(part, changed) {
    // A row with a checkbox, the colour, the name and the opacity of one label.
    const row = document.createElement("div");
    row.className = "part";
    const name = document.createElement("label");
    const box = document.createElement("input");
    // Browsers that remember the state of forms would let boxes and picture disagree.
    Object.assign(box, { type: "checkbox", checked: part.visible, autocomplete: "off" });
    box.addEventListener("change", () => {
      part.visible = box.checked;
      changed();
    });
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = part.colour;
    name.append(box, swatch, part.name);
    const opacity = document.createElement("input");
    Object.assign(opacity, {
      type: "range", min: 0, max: 1, step: 0.05, defaultValue: part.opacity, autocomplete: "off",
    });
    opacity.setAttribute("aria-label", `Opacity of ${part.name}`);
    opacity.addEventListener("input", () => {
      part.opacity = Number(opacity.value);
      changed();
    });
    row.append(name, opacity);
    return row;
  }

  // ---- one plane ------------------------------------------------------------------------------
  class Pane {
    constructor(viewer, name) {
      this.viewer = viewer;
      this.plane = PLANES[name];
      const { across, down, through } = this.plane;
      const { shape, spacing_mm: spacing } = viewer.header;
      this.root = viewer.root.querySelector(`.pane[data-plane='${name}']`);
      this.canvas = this.root.querySelector("canvas");
      this.canvas.width = shape[across];
      this.canvas.height = shape[down];
      const [wide, high] = [across, down].map((axis) => shape[axis] * spacing[axis]);
      this.canvas.style.aspectRatio = `${wide} / ${high}`;
      this.root.style.setProperty("--wide", wide);
      this.context = this.canvas.getContext("2d");
      this.picture = this.context.createImageData(shape[across], shape[down]);
      this.slider = this.root.querySelector("input");
      this.slider.max = shape[through] - 1;
      this.addLetters();
      this.listen();
    }

    addLetters() {
      const frame = this.root.querySelector(".frame");
      ["left", "right", "top", "bottom"].forEach((side, n) => {
        const letter = document.createElement("span");
        letter.className = `letter ${side}`;
        letter.textContent = this.plane.letters[n];
        frame.append(letter);
      });
    }

    listen() {
      const { viewer, slider } = this;
      const { through } = this.plane;
      const frame = this.root.querySelector(".frame");
      slider.addEventListener("input", () => viewer.moveTo(through, Number(slider.value)));
      frame.addEventListener("wheel", (event) => {
        // At the last slice the page scrolls on, so that nobody is caught in a picture.
        if (event.ctrlKey || !event.deltaY) return;
        if (viewer.moveTo(through, viewer.at[through] + Math.sign(event.deltaY) * this.forward())) {
          event.preventDefault();
        }
      }, { passive: false });
      frame.addEventListener("keydown", (event) => this.pressKey(event));
      frame.addEventListener("pointerdown", (event) => this.point(event));
      frame.addEventListener("pointermove", (event) => event.buttons === 1 && this.point(event));
    }

    forward() {
      return this.plane.through === 2 ? -1 : 1; // downwards is towards the feet
    }

    pressKey(event) {
      const { viewer } = this;
      const { through } = this.plane;
      const end = viewer.header.shape[through] - 1;
      const steps = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 };
      const place = { Home: 0, End: end }[event.key] ?? viewer.at[through] + steps[event.key];
      if (Number.isNaN(place)) return;
      viewer.moveTo(through, place);
      event.preventDefault();
    }

    point(event) {
      // The other two planes go to the point that is touched.
      const box = this.canvas.getBoundingClientRect();
      const { across, down, up } = this.plane;
      const { shape } = this.viewer.header;
      const x = (event.clientX - box.left) / box.width;
      const y = (event.clientY - box.top) / box.height;
      this.viewer.moveTo(across, Math.floor(x * shape[across]));
      this.viewer.moveTo(down, Math.floor((up ? 1 - y : y) * shape[down]));
    }

    draw() {
      const { viewer } = this;
      const { across, down, up, through } = this.plane;
      const { shape } = viewer.header;
      const strides = [1, shape[0], shape[0] * shape[1]];
      const [w, h] = [shape[across], shape[down]];
      const [dx, dy] = [strides[across], up ? -strides[down] : strides[down]];
      const start = viewer.at[through] * strides[through] + (up ? (h - 1) * strides[down] : 0);
      this.fill(start, dx, dy, w, h, viewer.greyTable());
      this.context.putImageData(this.picture, 0, 0);
      this.root.dataset.slice = viewer.at[through];
      this.slider.value = viewer.at[through];
      this.root.querySelector(".number").textContent = `${viewer.at[through] + 1} of ${shape[through]}`;
      this.placeLines(w, h);
    }

    fill(start, dx, dy, w, h, greys) {
      const { greyVoxels, labelVoxels, labels } = this.viewer;
      const { data } = this.picture;
      for (let y = 0, p = 0; y < h; y += 1) {
        for (let x = 0; x < w; x += 1, p += 4) {
          const n = start + x * dx + y * dy;
          const grey = greys[greyVoxels[n]];
          const value = labelVoxels[n];
          const label = value ? labels[value - 1] : undefined;
          data[p] = data[p + 1] = data[p + 2] = grey;
          data[p + 3] = 255;
          if (!label || !label.visible || label.opacity === 0) continue;
          const rim =
            (x > 0 && labelVoxels[n - dx] !== value) || (x < w - 1 && labelVoxels[n + dx] !== value) ||
            (y > 0 && labelVoxels[n - dy] !== value) || (y < h - 1 && labelVoxels[n + dy] !== value);
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

  for (const root of document.querySelectorAll(".slices")) {
    const viewer = new SliceViewer(root);
    root.viewer = viewer;
    viewer.open().catch((error) => {
      root.dataset.state = "failed";
      root.querySelector(".readout").textContent = "The slices could not be shown in this browser.";
      console.error(error);
    });
  }
})();
