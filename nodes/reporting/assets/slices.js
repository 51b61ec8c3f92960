"use strict";
// Slices of one volume in three planes, tied by one cross-hair. Needs slice_voxels.js, slice_pane.js.

const SCALE_BARS_MM = [1, 2, 5, 10, 20, 50, 100, 200, 500];

class SliceViewer {
  constructor(root) {
    this.root = root;
    this.header = JSON.parse(root.querySelector("script[type='application/json']").textContent);
    this.voxels = new SliceVoxels(this.header);
    this.at = [...this.header.at];
    this.labels = this.header.labels.map((label) => ({ ...label, rgb: parseColour(label.colour) }));
    this.outlined = false;
    this.large = "";
  }

  async open() {
    const grey = this.root.querySelector("img.grey");
    const labels = this.root.querySelector("img.labels");
    await this.voxels.decode(grey, labels);
    grey.remove();
    labels?.remove();
    this.panes = Object.keys(PLANES).map((name) => new SlicePane(this, name));
    this.layOut();
    this.addPlace();
    this.addWindows();
    if (this.labels.length) this.addLabels();
    this.drawNow();
    this.root.dataset.state = "ready";
  }

  layOut() {
    // One scale for all planes: frames as wide as their pictures, and all as high as the highest.
    const panes = this.root.querySelector(".panes");
    const total = this.panes.reduce((sum, pane) => sum + pane.wide, 0);
    panes.style.setProperty("--total", total);
    panes.style.setProperty("--highest", Math.max(...this.panes.map((pane) => pane.high)));
    const narrowest = Math.min(...this.panes.map((pane) => pane.wide));
    const bar = SCALE_BARS_MM.findLast((mm) => mm <= narrowest / 3) ?? SCALE_BARS_MM[0];
    for (const pane of this.panes) pane.showScale(bar);
  }

  enlarge(name) {
    this.large = this.large === name ? "" : name;
    this.root.querySelector(".panes").classList.toggle("enlarged", this.large !== "");
    for (const pane of this.panes) {
      const button = pane.root.querySelector(".enlarge");
      pane.root.classList.toggle("large", pane.name === this.large);
      button.textContent = pane.name === this.large ? "shrink" : "enlarge";
    }
  }

  // ---- where the cross-hair is ------------------------------------------------------------------
  moveTo(axis, place) {
    const at = [...this.at];
    at[axis] = Math.round(place);
    return this.goTo(at);
  }

  goTo(at) {
    const { shape } = this.header;
    const next = at.map((n, axis) => Math.min(shape[axis] - 1, Math.max(0, n)));
    const moved = next.some((n, axis) => n !== this.at[axis]);
    this.at = next;
    if (moved) this.draw();
    return moved;
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.drawNow(); });
  }

  drawNow() {
    this.found = this.voxels.describe(this.at);
    this.shown = this.greyTable();
    this.box.value = writePlace(this.voxels.place(this.at));
    this.root.querySelector(".cross .found").textContent = this.found;
    for (const pane of this.panes) pane.draw();
  }

  pointAt(at) {
    const [place, found] = [".place", ".found"].map((name) => this.root.querySelector(`.pointer ${name}`));
    place.textContent = at ? writePlace(this.voxels.place(at)) : "–";
    if (!at) found.textContent = "";
    else found.textContent = `${this.voxels.describe(at)} · ${this.awayFrom(at)} mm away`;
  }

  awayFrom(at) {
    // From the cross-hair: the pointer is its ruler.
    const here = this.voxels.place(this.at);
    return Math.hypot(...this.voxels.place(at).map((mm, axis) => mm - here[axis])).toFixed(1);
  }

  goToPlace(text) {
    const place = readPlace(text);
    const at = place && this.voxels.voxel(place);
    if (at) this.goTo(at);
  }

  addPlace() {
    this.box = this.root.querySelector(".cross .place");
    const copy = this.root.querySelector(".copy");
    this.box.addEventListener("focus", () => this.box.select());
    this.box.addEventListener("change", () => {
      this.goToPlace(this.box.value);
      this.drawNow(); // what cannot be read, or lies outside, gives way to where the cross-hair is
    });
    document.addEventListener("click", (event) => {
      // A place in any table of the page.
      const cell = event.target.closest("td.place");
      if (cell) this.goToPlace(cell.textContent);
    });
    copy.addEventListener("click", async () => {
      this.box.select();
      // Where the clipboard is closed to the page, the older way works on what is selected.
      await navigator.clipboard.writeText(this.box.value).catch(() => document.execCommand("copy"));
      copy.textContent = "copied";
      setTimeout(() => { copy.textContent = "copy"; }, 1200);
    });
  }

  // ---- window ---------------------------------------------------------------------------------
  greyTable() {
    // Display grey of each stored grey under the chosen window (DICOM PS3.3 C.11.2.1.2.1, linear
    // window without its half-step corrections).
    const { level, width } = this.window;
    if (this.header.plain) return new Uint8ClampedArray(256); // labels stand on black
    return Uint8ClampedArray.from(this.voxels.values, (v) => 255 * ((v - level) / width + 0.5));
  }

  addWindows() {
    const box = this.root.querySelector(".windows");
    for (const item of this.header.windows) {
      const low = item.level - item.width / 2;
      const high = item.level + item.width / 2;
      const range = `${low.toPrecision(4) * 1} to ${high.toPrecision(4) * 1} ${this.header.unit}`;
      box.append(makeButton(item.name, range, () => this.chooseWindow(item)));
    }
    [this.levelBox, this.widthBox] = ["level", "width"].map((name) => this.root.querySelector(`.${name}`));
    for (const input of [this.levelBox, this.widthBox]) {
      input.addEventListener("change", () => {
        const [level, width] = [this.levelBox, this.widthBox].map((item) => item.valueAsNumber);
        this.chooseWindow(Number.isFinite(level) && width > 0 ? { level, width } : this.window);
      });
    }
    this.chooseWindow(this.header.windows.find((item) => item.name === this.header.window));
  }

  chooseWindow(item) {
    this.window = item;
    this.levelBox.value = item.level.toPrecision(4) * 1;
    this.widthBox.value = item.width.toPrecision(4) * 1;
    for (const button of this.root.querySelectorAll(".windows button")) {
      button.setAttribute("aria-pressed", String(button.textContent === item.name));
    }
    this.draw();
  }

  shiftWindow(right, down) {
    // 400 pixels to the right double the width; 400 down raise the level by one width.
    const { level, width } = this.window;
    this.chooseWindow({ level: level + (down * width) / 400, width: width * 2 ** (right / 400) });
  }

  pressKey(key) {
    const { windows } = this.header;
    if (key === "w") this.chooseWindow(windows[(windows.indexOf(this.window) + 1) % windows.length]);
    else if (key === "l" && this.labels.length) this.showAll(!this.labels.some((label) => label.visible));
    else if (key === "o" && this.labels.length) this.outline(!this.outlined);
    else return false;
    return true;
  }

  // ---- labels ---------------------------------------------------------------------------------
  addLabels() {
    const styles = this.root.querySelector(".styles");
    styles.append(makeButton("filled", "labels as areas", () => this.outline(false)));
    styles.append(makeButton("outlined", "labels as outlines", () => this.outline(true)));
    const rows = this.root.querySelector(".parts");
    this.rows = this.labels.map((label) => makePart(label, () => this.draw()));
    rows.append(...this.rows);
    const all = { name: "all labels", visible: true, opacity: this.labels[0].opacity };
    const row = makePart(all, (changed) => {
      if (changed === "visible") this.showAll(all.visible);
      else this.fadeAll(all.opacity);
    });
    row.querySelector(".swatch").remove();
    this.root.querySelector(".all").append(row);
    this.outline(false);
  }

  outline(outlined) {
    this.outlined = outlined;
    const chosen = outlined ? "outlined" : "filled";
    for (const button of this.root.querySelectorAll(".styles button")) {
      button.setAttribute("aria-pressed", String(button.textContent === chosen));
    }
    this.draw();
  }

  showAll(visible) {
    for (const row of [...this.rows, this.root.querySelector(".all .part")]) {
      row.querySelector("input[type=checkbox]").checked = visible;
    }
    for (const label of this.labels) label.visible = visible;
    this.draw();
  }

  fadeAll(opacity) {
    this.labels.forEach((label, n) => {
      label.opacity = opacity;
      this.rows[n].querySelector("input[type=range]").value = opacity;
    });
    this.draw();
  }
}

function parseColour(text) {
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
}

function makeButton(text, title, act) {
  const button = document.createElement("button");
  Object.assign(button, { type: "button", textContent: text, title });
  button.addEventListener("click", act);
  return button;
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
    changed("visible");
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
    changed("opacity");
  });
  row.append(name, opacity);
  return row;
}

for (const root of document.querySelectorAll(".slices")) {
  const viewer = new SliceViewer(root);
  root.viewer = viewer;
  viewer.open().catch((error) => {
    root.dataset.state = "failed";
    root.querySelector(".cross .found").textContent = "The slices could not be shown in this browser.";
    console.error(error);
  });
}
