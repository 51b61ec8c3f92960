// What a reader chooses in a scene: one of several robots, and a step of its motion. The parts of
// the section that belong to one choice (`data-choice`) follow. Build: see README.md.
import { makeButton, makeSelect } from "./controls.src.js";

const STEPS_PER_SECOND = 20;
const LEAST_SECONDS = 3;
const MOST_SECONDS = 12;

export class Choices {
  constructor(viewer, data) {
    this.viewer = viewer;
    this.choices = data.choices ?? [];
    this.objects = data.objects.map(({ choice }, n) => ({ choice, item: viewer.content.children[n] }));
    this.section = viewer.root.closest("section") ?? viewer.root;
    this.playing = false;
    if (!this.choices.length) return;
    this.addChoice();
    this.addPlayer();
    this.choose(0);
  }

  addChoice() {
    const place = this.section.querySelector(".choose");
    if (!place || this.choices.length < 2) return;
    place.append(makeSelect(this.choices.map(({ name }) => name), place.dataset.title, (n) => this.choose(n)));
  }

  addPlayer() {
    this.box = this.viewer.root.querySelector(".player");
    this.button = makeButton("Play", "play or stop the motion", () => this.press());
    this.slider = document.createElement("input");
    Object.assign(this.slider, { type: "range", min: 0, step: 1, autocomplete: "off" });
    this.slider.setAttribute("aria-label", "Step of the motion");
    this.slider.addEventListener("input", () => { this.stop(); this.go(Number(this.slider.value)); });
    this.text = document.createElement("output");
    this.box.append(this.button, this.slider, this.text);
  }

  choose(chosen) {
    this.stop();
    this.chosen = chosen;
    for (const { choice, item } of this.objects) {
      const shown = choice === undefined || choice === chosen;
      item.visible = shown && item.wanted;
      item.row.hidden = !shown;
    }
    for (const part of this.section.querySelectorAll("[data-choice]")) {
      part.hidden = Number(part.dataset.choice) !== chosen;
    }
    this.pictures = [...this.section.querySelectorAll(`[data-choice="${chosen}"] [data-step]`)];
    const last = this.choices[chosen].steps.length - 1;
    this.box.hidden = last < 1;
    this.slider.max = last;
    this.go(Math.max(last, 0)); // where the motion leads; playing begins at its start
  }

  go(step) {
    const { steps } = this.choices[this.chosen];
    this.step = step;
    this.slider.value = step;
    this.text.textContent = steps[step] ?? "";
    for (const { choice, item } of this.objects) {
      if (item.setFrame && choice === this.chosen) item.setFrame(step);
    }
    this.showPicture();
    this.moveMarks(steps.length > 1 ? step / (steps.length - 1) : 0);
    this.viewer.draw();
  }

  showPicture() {
    // The camera's picture of this step or the last one before it.
    const screen = this.viewer.root.querySelector(".camera");
    if (!screen) return;
    const before = this.pictures.filter((part) => Number(part.dataset.step) <= this.step);
    const part = before.at(-1) ?? this.pictures[0];
    screen.hidden = !part;
    if (!part) return;
    screen.querySelector("img").src = part.querySelector("img").src;
    screen.querySelector("figcaption").textContent = part.querySelector("figcaption").textContent;
  }

  moveMarks(share) {
    // Lines in charts that stand where the motion is.
    for (const mark of this.section.querySelectorAll(`[data-choice="${this.chosen}"] .now`)) {
      mark.style.transform = `translateX(${share * Number(mark.dataset.width)}px)`;
    }
  }

  press() {
    if (this.playing) { this.stop(); return; }
    if (this.step >= Number(this.slider.max)) this.go(0);
    this.playing = true;
    this.button.textContent = "Stop";
    const last = Number(this.slider.max);
    const seconds = Math.min(MOST_SECONDS, Math.max(LEAST_SECONDS, last / STEPS_PER_SECOND));
    const [begin, from] = [performance.now(), this.step];
    const advance = (now) => {
      if (!this.playing) return;
      const step = Math.min(last, from + Math.floor(((now - begin) / 1000 / seconds) * last));
      if (step !== this.step) this.go(step);
      if (step < last) requestAnimationFrame(advance);
      else this.stop();
    };
    requestAnimationFrame(advance);
  }

  stop() {
    this.playing = false;
    if (this.button) this.button.textContent = "Play";
  }
}
