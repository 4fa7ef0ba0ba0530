// One slider for each joint, where no node moves the robot.

import type { Update } from "./messages";

/** A slider as the server describes it; rad or m. */
interface Range {
  name: string;
  unit: "rad" | "m";
  lower: number;
  upper: number;
}

/** Time (ms) after a move by the user in which updates do not set the slider: they may be of earlier positions. */
const SETTLING = 500;

const DEGREES = 180 / Math.PI;

interface Slider {
  range: Range;
  input: HTMLInputElement;
  value: HTMLOutputElement;
  movedAt: number;
}

export class Sliders {
  private sliders: Slider[] = [];
  private isLoading = false;
  /** Moves that are not sent yet, by slider: only the last one of each. */
  private readonly pending = new Map<number, number>();
  private isSending = false;
  /** The slider whose move is being sent. */
  private sent = -1;
  /** Number of the robot model that the sliders are of. */
  private model = 0;

  constructor(
    private readonly place: HTMLElement,
    private readonly fault: HTMLElement,
  ) {}

  /** Sets the sliders to the state of an update; the first one creates them. */
  show({ sliders, model }: Update): void {
    if (!sliders || model === 0) return;
    if (this.model !== model || this.sliders.length !== sliders.length) {
      void this.load(model);
      return;
    }
    const now = performance.now();
    this.sliders.forEach((slider, i) => {
      const position = sliders[i];
      if (position === undefined || now - slider.movedAt < SETTLING || this.pending.has(i) || this.sent === i) return;
      if (slider.input.valueAsNumber !== position) slider.input.valueAsNumber = position;
      write(slider, position);
    });
  }

  private async load(model: number): Promise<void> {
    if (this.isLoading) return;
    this.isLoading = true;
    try {
      const answer = await fetch("joints");
      if (!answer.ok) return;
      const ranges = (await answer.json()) as Range[];
      this.pending.clear();
      this.model = model;
      this.sliders = ranges.map((range, i) => this.create(range, i));
      this.place.replaceChildren(...this.sliders.map(row));
      document.body.dataset.sliders = "";
    } catch {
      // the next update tries again
    } finally {
      this.isLoading = false;
    }
  }

  private create(range: Range, index: number): Slider {
    const input = document.createElement("input");
    input.type = "range";
    input.step = "any";
    input.min = `${range.lower}`;
    input.max = `${range.upper}`;
    input.dataset.joint = range.name;
    const slider = { range, input, value: document.createElement("output"), movedAt: -Infinity };
    input.addEventListener("input", () => {
      slider.movedAt = performance.now();
      write(slider, input.valueAsNumber);
      this.pending.set(index, input.valueAsNumber);
      void this.send();
    });
    return slider;
  }

  /** Sends the pending moves, one at a time. */
  private async send(): Promise<void> {
    if (this.isSending) return;
    this.isSending = true;
    for (const [index, position] of this.pending) {
      this.pending.delete(index);
      this.sent = index;
      this.fault.textContent = await post(this.sliders[index]?.range.name ?? "", position);
    }
    this.sent = -1;
    this.isSending = false;
  }
}

/** Why the server rejects a move; empty if it does not. */
async function post(joint: string, position: number): Promise<string> {
  try {
    const headers = { "Content-Type": "application/json" };
    const answer = await fetch("state", { method: "POST", headers, body: JSON.stringify({ joint, position }) });
    return answer.ok ? "" : await answer.text();
  } catch {
    return "The server does not respond.";
  }
}

function write({ range, value }: Slider, position: number): void {
  const text = range.unit === "rad" ? `${(position * DEGREES).toFixed(1)}°` : `${(1000 * position).toFixed(1)} mm`;
  if (value.textContent !== text) value.textContent = text;
  value.title = `${position.toFixed(4)} ${range.unit}`;
}

function row({ range, input, value }: Slider): HTMLElement {
  const label = document.createElement("label");
  const name = document.createElement("span");
  name.textContent = range.name;
  label.append(name, value, input);
  return label;
}
