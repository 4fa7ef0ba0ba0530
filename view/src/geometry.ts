// The geometry of the robot and world that the updates are about.

import { Document, type Robot, type Update, type World } from "./messages";

/** Time between two downloads at least (ms). */
const PAUSE = 250;

export class Geometry {
  robot: Document<Robot> | null = null;
  world: Document<World> | null = null;
  private loading = false;

  constructor(private readonly changed: () => void) {}

  /** Loads what an update is about, if that is not what is here. */
  follow({ model, world }: Update): void {
    const newRobot = model !== (this.robot?.text.model ?? 0);
    const newWorld = model !== this.world?.text.model || world !== this.world.text.world;
    if (model === 0 || this.loading || !(newRobot || newWorld)) return;
    this.loading = true;
    void this.load(newRobot)
      .catch(() => undefined) // the next update asks again
      .finally(() => setTimeout(() => (this.loading = false), PAUSE));
  }

  private async load(newRobot: boolean): Promise<void> {
    if (newRobot) this.robot = await download<Robot>("robot");
    this.world = await download<World>("world");
    this.changed();
  }
}

async function download<T>(path: string): Promise<Document<T>> {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(await answer.text());
  return new Document<T>(await answer.arrayBuffer());
}
