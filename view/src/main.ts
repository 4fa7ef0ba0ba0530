// The live view of `clearance node --view`, and the view without a node, which has sliders.

import { Chart } from "./chart";
import { Geometry } from "./geometry";
import type { Update } from "./messages";
import { pictureNote } from "./note";
import { showGeometry, showPadding, showUpdate } from "./panel";
import { Sliders } from "./sliders";
import { Stage } from "./stage";
import { follow } from "./updates";

/** Time (ms) that numbers wait for the picture before, so that both are of the same state. */
const PATIENCE = 1000;

const note = document.getElementById("scene-note") as HTMLElement;
const fit = document.getElementById("fit") as HTMLButtonElement;
const stage = openStage();
const chart = new Chart(document.getElementById("chart") as HTMLElement);
const sliders = new Sliders(
  document.getElementById("sliders") as HTMLElement,
  document.getElementById("slider-fault") as HTMLElement,
);
const geometry = new Geometry(() => {
  stage?.set(geometry);
  showGeometry(geometry);
  showPadding(geometry);
});
fit.addEventListener("click", () => stage?.fit());

let latest: Update | null = null;
let waitingSince = 0;
follow((update) => {
  geometry.follow(update);
  chart.note(update);
  if (!latest) waitingSince = performance.now();
  latest = update;
});

const frame = () => {
  requestAnimationFrame(frame);
  const isLate = performance.now() - waitingSince > PATIENCE;
  if (latest && (!stage?.isDrawing() || isLate)) {
    present(latest);
    latest = null;
  }
  stage?.draw();
};
frame();

/** Numbers, labels and picture change together. */
function present(update: Update): void {
  showUpdate(update);
  sliders.show(update);
  chart.draw();
  if (!stage) return;
  const drawn = stage.show(update);
  const text = pictureNote(update, drawn, stage.isAbout(update));
  if (note.textContent !== text) note.textContent = text;
  note.hidden = text === "";
}

/** Without WebGL there is no picture, but the numbers are there. */
function openStage(): Stage | null {
  try {
    return new Stage(document.getElementById("scene") as HTMLCanvasElement);
  } catch (error) {
    note.textContent = `This browser can not draw the robot: ${error instanceof Error ? error.message : String(error)}`;
    fit.hidden = true;
    return null;
  }
}
