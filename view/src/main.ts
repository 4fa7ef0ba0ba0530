// The live view of `clearance node --view`.

import { Chart } from "./chart";
import { Geometry } from "./geometry";
import type { Update } from "./messages";
import { showGeometry, showUpdate } from "./panel";
import { Stage } from "./stage";
import { follow } from "./updates";

const stage = openStage();
const chart = new Chart(document.getElementById("chart") as HTMLElement);
const geometry = new Geometry(() => {
  stage?.set(geometry);
  showGeometry(geometry);
});

let latest: Update | null = null;
follow((update) => {
  geometry.follow(update);
  chart.note(update);
  latest = update;
});

const frame = () => {
  requestAnimationFrame(frame);
  if (!latest) return;
  showUpdate(latest);
  stage?.show(latest);
  chart.draw();
  latest = null;
};
frame();

/** Without WebGL there is no picture, but the numbers are there. */
function openStage(): Stage | null {
  const note = document.getElementById("scene-note") as HTMLElement;
  try {
    return new Stage(document.getElementById("scene") as HTMLCanvasElement, () => (note.hidden = true));
  } catch (error) {
    note.textContent = `This browser can not draw the robot: ${error instanceof Error ? error.message : String(error)}`;
    return null;
  }
}
