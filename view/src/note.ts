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
      return `Not the robot's pose: it is drawn in its default pose. ${reason}`.trim();
    case "last":
      return `Not the robot's pose now: it is drawn where it was last. ${reason}`.trim();
    case "current":
      return isWhole ? "" : "The picture does not show the present world yet.";
  }
}
