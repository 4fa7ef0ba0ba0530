// The binary under test, as a process of its own.

import { spawn } from "node:child_process";
import { once } from "node:events";

const EXIT_DEADLINE = 60_000; // ms

/** `clearance` with some arguments; `url` is where it says its view is. */
export class NodeProcess {
  output = "";

  constructor(...args) {
    this.process = spawn(process.env.CLEARANCE_BIN, args, { stdio: ["ignore", "pipe", "pipe"] });
    this.process.stdout.on("data", (text) => (this.output += text));
    this.process.stderr.on("data", (text) => (this.output += text));
    this.ended = once(this.process, "exit").then(([code]) => code);
  }

  /** Where its view is. */
  async url() {
    const url = await until(() => {
      const found = /^view: (http:\S+)$/m.exec(this.output);
      if (!found && this.process.exitCode !== null) throw new Error(`it ended:\n${this.output}`);
      return found?.[1];
    }, "the address of the view");
    return url;
  }

  /** Asks it to end; one that does not is killed, and fails the test. */
  async stop() {
    this.process.kill("SIGINT");
    const late = new Promise((_, fail) => setTimeout(fail, EXIT_DEADLINE, new Error("it does not end")).unref());
    try {
      return await Promise.race([this.ended, late]);
    } finally {
      this.process.kill("SIGKILL");
    }
  }

  kill() {
    this.process.kill("SIGKILL");
  }
}

/** Real rclpy that publishes joint states (joint_states.py). */
export class Driver {
  constructor(t) {
    this.process = spawn(process.env.PYTHON, ["-B", "tests/view/joint_states.py"], { stdio: ["pipe", "inherit", "inherit"] });
    t.after(() => this.process.kill("SIGKILL"));
  }

  /** From now on these positions (rad) are published; none without any. */
  report(...positions) {
    this.process.stdin.write(`${positions.join(" ")}\n`);
  }
}

/** The first true value of a condition; an error that names it after a deadline (ms). */
export async function until(condition, what, deadline = 180_000) {
  const end = performance.now() + deadline;
  for (;;) {
    const value = await condition();
    if (value) return value;
    if (performance.now() > end) throw new Error(`${what} did not come within ${deadline / 1000} s`);
    await new Promise((go) => setTimeout(go, 50));
  }
}
