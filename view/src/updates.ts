// What the node says, and the rule that its silence means UNKNOWN.

import type { Update } from "./messages";

/** The node speaks at least every half second (ms). */
const PATIENCE = 2000;
const RETRY = 1000;

const unknown = (reason: string): Update => ({
  status: "UNKNOWN",
  reason,
  reason_code: "no_connection",
  warnings: [],
  model: 0,
  world: 0,
  age: null,
  poses: null,
});

/** Hands on every update, and an UNKNOWN of its own while none come. */
export function follow(heed: (update: Update) => void): void {
  let heard = performance.now();
  let refusal = "";

  const listen = () => {
    const source = new EventSource("updates");
    source.onmessage = (event: MessageEvent<string>) => {
      heard = performance.now();
      refusal = "";
      heed(JSON.parse(event.data) as Update);
    };
    source.onerror = () => {
      // the browser tries again by itself, unless it was refused
      if (source.readyState !== EventSource.CLOSED) return;
      void why().then((text) => (refusal = text));
      setTimeout(listen, RETRY);
    };
  };
  listen();

  setInterval(() => {
    const silence = performance.now() - heard;
    if (silence < PATIENCE) return;
    const lost = `This page has heard nothing from the node for ${(silence / 1000).toFixed(0)} s.`;
    heed(unknown([lost, refusal].join(" ").trim()));
  }, 250);
}

/** Why the node refuses to speak. */
async function why(): Promise<string> {
  const abort = new AbortController();
  try {
    const answer = await fetch("updates", { signal: abort.signal });
    return answer.ok ? "" : await answer.text();
  } catch {
    return "";
  } finally {
    abort.abort();
  }
}
