// 3-D view of a scene in the patient frame (LPS, mm). Scene format and build: see README.md.
import {
  Box3, DirectionalLight, Group, HemisphereLight, PerspectiveCamera, Scene, Sphere, Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Choices } from "./choices3d.src.js";
import { makeButton, makeSelect } from "./controls.src.js";
import { BUILDERS, decodeBase64, setOpacity } from "./scene3d.src.js";

const VIEWS = {
  // Direction from the middle to the eye; superior and inferior lean a hair towards anterior, so
  // that posterior is up and left stays left.
  A: [0, -1, 0], P: [0, 1, 0], L: [1, 0, 0], R: [-1, 0, 0], S: [0, -1e-4, 1], I: [0, -1e-4, -1],
};
const NAMES = { A: "anterior", P: "posterior", L: "left", R: "right", S: "superior", I: "inferior" };
const SIDES = {
  A: "the front (anterior)", P: "the back (posterior)", L: "the patient's left",
  R: "the patient's right", S: "above (superior)", I: "below (inferior)",
};
const FIELD_OF_VIEW_DEG = 28;

// ---- one viewer -------------------------------------------------------------------------------
class Viewer {
  constructor(root, data) {
    this.root = root;
    this.canvas = root.querySelector("canvas");
    this.stage = root.querySelector(".stage");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
    this.scene = new Scene();
    this.content = new Group();
    this.scene.add(this.content);
    this.camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 1, 10000);
    this.camera.up.set(0, 0, 1);
    this.build(data);
    this.light();
    this.control();
    this.addViews();
    this.addLetters();
    this.addTags(data);
    this.choices = new Choices(this, data);
    this.follow();
    this.resize();
    this.look("A", 0.35);
  }

  build(data) {
    const buffers = data.buffers.map((text) => decodeBase64(findBuffer(text)));
    const parts = this.root.querySelector(".parts");
    for (const object of data.objects) {
      const builder = BUILDERS[object.kind];
      if (!builder) throw new Error(`This viewer knows no object of the kind ${object.kind}.`);
      const item = builder(object, buffers);
      item.name = object.name;
      item.visible = object.visible ?? true;
      item.wanted = item.visible;
      setOpacity(item, object.opacity ?? 1);
      this.content.add(item);
      item.row = this.makePart(item, object);
      parts.append(item.row);
      if (object.paints) parts.append(this.makePaints(item, object.paints));
    }
    // The view at first is of what is shown at first.
    const shown = this.content.children.filter((item) => item.visible);
    this.box = new Box3();
    for (const item of shown.length ? shown : this.content.children) this.box.expandByObject(item);
    if (this.box.isEmpty()) this.box.set(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
    this.sphere = this.box.getBoundingSphere(new Sphere());
    this.sortBySize();
    this.tellExtent(data);
  }

  tellExtent(data) {
    // Of the anatomy alone: marks may stand out of it.
    const box = new Box3();
    this.content.children.forEach((item, n) => { if (!data.objects[n].mark) box.expandByObject(item); });
    if (box.isEmpty()) return;
    const [wide, deep, high] = box.getSize(new Vector3()).toArray().map((mm) => mm.toFixed(0));
    this.root.querySelector(".extent").textContent =
      `All surfaces together: ${wide} mm wide, ${deep} mm deep, ${high} mm high.`;
  }

  sortBySize() {
    // Translucent parts are blended from the inside out: what is larger lies around what is smaller.
    for (const item of this.content.children) {
      const size = new Box3().setFromObject(item).getSize(new Vector3());
      item.renderOrder = size.x * size.y * size.z;
    }
  }

  light() {
    this.scene.add(new HemisphereLight("#ffffff", "#8a8f98", 1.5));
    const key = new DirectionalLight("#ffffff", 1.9);
    key.position.set(-0.6, 0.8, 1); // over the viewer's left shoulder, wherever the viewer is
    this.camera.add(key);
    this.camera.add(key.target);
    key.target.position.set(0, 0, -1);
    this.scene.add(this.camera);
  }

  control() {
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.minDistance = this.sphere.radius * 0.2;
    this.controls.maxDistance = this.sphere.radius * 20;
    this.controls.addEventListener("change", () => this.draw());
    // The wheel zooms only after a click, so that it does not catch a reader who scrolls past.
    this.controls.enableZoom = false;
    this.canvas.addEventListener("focus", () => { this.controls.enableZoom = true; });
    this.canvas.addEventListener("blur", () => { this.controls.enableZoom = false; });
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.focus({ preventScroll: true });
      this.controls.enableZoom = true;
      if (event.pointerType === "touch") this.root.dataset.touched = "true";
    }, { capture: true });
    this.canvas.addEventListener("keydown", (event) => this.pressKey(event));
  }

  pressKey(event) {
    const step = Math.PI / 24;
    const turn = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
    const zoom = { "+": 0.9, "=": 0.9, "-": 1 / 0.9 };
    if (turn[event.key]) this.turn(...turn[event.key]);
    else if (zoom[event.key]) this.zoom(zoom[event.key]);
    else return;
    event.preventDefault();
  }

  turn(around, over) {
    const arm = this.camera.position.clone().sub(this.controls.target);
    const polar = Math.acos(arm.z / arm.length()) + over;
    const azimuth = Math.atan2(arm.y, arm.x) + around;
    const safe = Math.min(Math.PI - 1e-4, Math.max(1e-4, polar));
    arm.setLength(arm.length()).set(
      arm.length() * Math.sin(safe) * Math.cos(azimuth),
      arm.length() * Math.sin(safe) * Math.sin(azimuth),
      arm.length() * Math.cos(safe),
    );
    this.camera.position.copy(this.controls.target).add(arm);
    this.controls.update();
  }

  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
  }

  fit(direction) {
    // The least distance from which every corner of the box and its letters are in the picture.
    const right = new Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new Vector3().crossVectors(direction, right);
    const tangent = Math.tan((FIELD_OF_VIEW_DEG / 2) * (Math.PI / 180));
    const { min, max } = this.box.clone().expandByScalar(this.sphere.radius * 0.08);
    let distance = this.sphere.radius;
    for (let corner = 0; corner < 8; corner += 1) {
      const arm = new Vector3(
        corner & 1 ? max.x : min.x, corner & 2 ? max.y : min.y, corner & 4 ? max.z : min.z,
      ).sub(this.sphere.center);
      const near = arm.dot(direction);
      const high = Math.abs(arm.dot(up)) / tangent;
      const wide = Math.abs(arm.dot(right)) / (tangent * this.camera.aspect);
      distance = Math.max(distance, near + high, near + wide);
    }
    return distance;
  }

  look(name, lean = 0) {
    // Look from one side of the patient; `lean` turns the eye a little left and up, in radians.
    const direction = new Vector3(...VIEWS[name]);
    direction.x += Math.sin(lean);
    direction.z += Math.sin(lean) / 2;
    // Bodies are round: the corners of their boxes are empty, and may be cut a little.
    const distance = 0.9 * this.fit(direction.normalize());
    this.controls.target.copy(this.sphere.center);
    this.camera.position.copy(direction.setLength(distance)).add(this.sphere.center);
    this.camera.near = distance / 100;
    this.camera.far = distance * 30;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  addViews() {
    const box = this.root.querySelector(".views");
    for (const [name, meaning] of Object.entries(SIDES)) {
      box.append(makeButton(name, `from ${meaning}`, () => this.look(name)));
    }
    box.append(makeButton("Reset", "the view at first", () => this.look("A", 0.35)));
  }

  makePart(item, object) {
    const row = document.createElement("div");
    row.className = "part";
    const name = document.createElement("label");
    const box = document.createElement("input");
    // Browsers that remember the state of forms would let boxes and picture disagree.
    Object.assign(box, { type: "checkbox", checked: item.visible, autocomplete: "off" });
    box.addEventListener("change", () => {
      item.wanted = box.checked;
      item.visible = box.checked;
      this.draw();
    });
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = object.colour;
    name.append(box, swatch, object.name);
    const opacity = document.createElement("input");
    Object.assign(opacity, {
      type: "range", min: 0.05, max: 1, step: 0.05, defaultValue: item.material.opacity, autocomplete: "off",
    });
    opacity.setAttribute("aria-label", `Opacity of ${object.name}`);
    opacity.addEventListener("input", () => { setOpacity(item, Number(opacity.value)); this.draw(); });
    row.append(name, opacity);
    return row;
  }

  makePaints(item, paints) {
    // What the colours of a surface tell: one paint at a time, with its key.
    const box = document.createElement("div");
    box.className = "paints";
    const key = document.createElement("ul");
    const show = (n) => {
      item.paint(n);
      key.replaceChildren(...paints[n].colours.map((colour, kind) => {
        const line = document.createElement("li");
        const swatch = document.createElement("span");
        swatch.className = "swatch";
        swatch.style.background = colour;
        line.append(swatch, paints[n].meanings[kind]);
        return line;
      }));
    };
    const choice = makeSelect(paints.map(({ name }) => name), "Colours show", (n) => {
      show(n);
      this.draw();
    });
    box.append(choice, key);
    show(0);
    return box;
  }

  addLetters() {
    const axes = this.root.querySelector(".axes");
    const middle = this.box.getCenter(new Vector3());
    const half = this.box.getSize(new Vector3()).multiplyScalar(0.5).addScalar(this.sphere.radius * 0.07);
    this.letters = Object.keys(NAMES).map((name) => {
      const element = document.createElement("span");
      element.textContent = name;
      element.title = NAMES[name];
      axes.append(element);
      const out = new Vector3(...VIEWS[name].map(Math.round));
      return { element, out, place: out.clone().multiply(half).add(middle) };
    });
  }

  addTags(data) {
    const box = this.root.querySelector(".tags");
    this.tags = data.objects.flatMap((object, n) => (object.tags ?? []).map(({ text, at }) => {
      const element = document.createElement("span");
      element.textContent = text;
      box.append(element);
      return { element, item: this.content.children[n], place: new Vector3(...at) };
    }));
  }

  follow() {
    new ResizeObserver(() => this.resize()).observe(this.stage);
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.draw());
    const paper = window.matchMedia("print");
    paper.addEventListener("change", () => this.drawNow());
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.drawNow();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.drawNow(); });
  }

  drawNow() {
    this.renderer.setClearColor(getComputedStyle(this.stage).backgroundColor);
    this.renderer.render(this.scene, this.camera);
    this.placeLetters();
    this.placeTags();
    this.root.dataset.drawn = Number(this.root.dataset.drawn ?? 0) + 1;
  }

  onScreen(place) {
    // Where a place of the patient is in the picture, in pixels from its upper left corner.
    const { clientWidth: width, clientHeight: height } = this.stage;
    const screen = place.clone().project(this.camera);
    return [((screen.x + 1) / 2) * width, ((1 - screen.y) / 2) * height];
  }

  placeTags() {
    // Names of places that lie close together step down until none covers another.
    const taken = [];
    for (const { element, item, place } of this.tags) {
      element.hidden = !item.visible;
      if (element.hidden) continue;
      const [x, y] = this.onScreen(place);
      const wide = 9 * element.textContent.length;
      const covers = (row) => taken.some((tag) => (
        Math.abs(tag.row - row) < 15 && x < tag.x + tag.wide && tag.x < x + wide
      ));
      let row = y;
      while (covers(row)) row += 3;
      taken.push({ x, row, wide });
      element.style.transform = `translate(${x.toFixed(1)}px, ${row.toFixed(1)}px) translate(8px, -50%)`;
    }
  }

  placeLetters() {
    const eye = this.camera.position.clone().sub(this.sphere.center).normalize();
    for (const { element, out, place } of this.letters) {
      const [x, y] = this.onScreen(place);
      const facing = out.dot(eye);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
      // A letter that points at the eye or away from it would lie on the picture's middle.
      element.style.opacity = Math.abs(facing) > 0.93 ? 0 : facing < -0.2 ? 0.45 : 1;
    }
  }
}


// ---- all viewers of a page ----------------------------------------------------------------------
const roots = [...document.querySelectorAll(".viewer3d")];
const scenes = roots.map((root) => (
  JSON.parse(root.querySelector("script[type='application/json']").textContent)
));

function findBuffer(text) {
  // "=2.5" is buffer 5 of scene 2: what several scenes of a page show stands in it once.
  if (!text.startsWith("=")) return text;
  const [scene, buffer] = text.slice(1).split(".").map(Number);
  return scenes[scene].buffers[buffer];
}

for (const [n, root] of roots.entries()) {
  try {
    root.viewer = new Viewer(root, scenes[n]);
    root.dataset.state = "ready";
  } catch (error) {
    root.dataset.state = "failed";
    const failure = root.querySelector(".failure");
    failure.hidden = false;
    failure.textContent = `The 3-D view cannot be shown: ${error.message}`;
  }
}
