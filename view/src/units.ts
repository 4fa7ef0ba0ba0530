// Numbers with their units, in one way everywhere on the page.

/** A length (m): in millimetres below a metre. */
export function length(metres: number): string {
  return Math.abs(metres) < 0.99995 ? `${(1000 * metres).toFixed(1)} mm` : `${metres.toFixed(3)} m`;
}

/** The same without digits that are zero, for an axis. */
export function roundLength(metres: number): string {
  if (metres === 0) return "0";
  return metres < 0.99995 ? `${parseFloat((1000 * metres).toFixed(2))} mm` : `${parseFloat(metres.toFixed(3))} m`;
}

/** A time (s); a dash where there is none. */
export function duration(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined) return "–";
  if (Math.abs(seconds) < 1e-3) return `${(1e6 * seconds).toFixed(0)} µs`;
  return Math.abs(seconds) < 1 ? `${(1e3 * seconds).toFixed(1)} ms` : `${seconds.toFixed(1)} s`;
}
