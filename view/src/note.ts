// The text over the picture: what is missing in it.

import type { DrawnPose } from "./stage";
import type { Update } from "./messages";

/** What the user has to know about the picture of an update; empty if nothing is missing. */
export function pictureNote(update: Update, drawn: DrawnPose, isWhole: boolean): string {
  const reason = update.reason ?? "";
  switch (drawn) {
    case "none":
      return `The robot is not shown yet. ${reason}`.trim();
    case "default":
      return `Shown in its default pose, which is not the robot's: ${reason}`.trim();
    case "last":
      return `Shown where it was last, which may not be where it is now: ${reason}`.trim();
    case "current":
      return isWhole ? "" : "The picture does not show the present world yet.";
  }
}
