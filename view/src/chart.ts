// The distances of the robot from itself and from the world over the last minute.

import uPlot from "uplot";

import type { Nearest, Update } from "./messages";
import { roundLength } from "./units";

/** How much time is shown (s). */
const WINDOW = 60;

/** Colours as in view.css. */
const SELF = "#4f81bd";
const WORLD = "#d9822b";

export class Chart {
  private readonly times: number[] = [];
  private readonly ofSelf: (number | null)[] = [];
  private readonly ofWorld: (number | null)[] = [];
  private readonly plot: uPlot;

  constructor(private readonly place: HTMLElement) {
    const ink = "#8a929c";
    const axis = { stroke: ink, grid: { stroke: "#8a929c33", width: 1 }, ticks: { show: false } };
    const line = { width: 2, spanGaps: false, points: { show: false } };
    this.plot = new uPlot(
      {
        ...this.size(),
        legend: { show: false },
        cursor: { show: false },
        scales: {
          x: { time: false, range: () => [-WINDOW, 0] },
          y: { range: (_, __, most) => [0, Math.max(most || 0, 0.01) * 1.1] },
        },
        axes: [
          { ...axis, size: 24, values: (_, ticks) => ticks.map((t) => `${t} s`) },
          { ...axis, size: 62, values: (_, ticks) => ticks.map(roundLength) },
        ],
        series: [{}, { ...line, stroke: SELF }, { ...line, stroke: WORLD }],
      },
      [[], [], []],
      place,
    );
    new ResizeObserver(() => this.plot.setSize(this.size())).observe(place);
  }

  private size(): { width: number; height: number } {
    return { width: this.place.clientWidth || 320, height: 150 };
  }

  /** What is unknown, or beyond the distance limit, leaves a gap. */
  note(update: Update): void {
    const now = performance.now() / 1000;
    this.times.push(now);
    this.ofSelf.push(distance(update.self_nearest));
    this.ofWorld.push(distance(update.world_nearest));
    const old = this.times.findIndex((time) => time > now - WINDOW);
    for (const list of [this.times, this.ofSelf, this.ofWorld]) list.splice(0, old);
  }

  draw(): void {
    const now = performance.now() / 1000;
    this.plot.setData([this.times.map((time) => time - now), this.ofSelf, this.ofWorld]);
  }
}

const distance = (nearest: Nearest | undefined) => nearest?.pair?.distance ?? null;
