// The live view as its users meet it: the binary, and a browser that looks at it.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { request } from "node:http";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";

import { chromium } from "playwright-core";
import { PNG } from "pngjs";

import { Driver, NodeProcess, until } from "./node_process.mjs";

const URDF = "urdf/demo_arm/demo_arm.urdf";
const TWO_LINK = "urdf/two_link/two_link.urdf";
// Long enough for a machine that has other things to do, and draws without a graphics card (ms).
const TIMEOUT = 900_000;
const PATIENCE = 120_000;

// Nothing here needs a graphics card or a network.
const FLAGS = [
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
];

let profile, browser;

before(async () => {
  profile = await mkdtemp(join(tmpdir(), "clearance-view-"));
  browser = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM,
    args: FLAGS,
    chromiumSandbox: false,
    colorScheme: "light",
    viewport: { width: 1000, height: 580 },
  });
  browser.setDefaultTimeout(PATIENCE);
});

after(async () => {
  await browser?.close();
  await rm(profile, { recursive: true, force: true });
});

/** A page that looks at a node; what it complains about, and whom it asks. */
async function open(t, url) {
  const page = await browser.newPage();
  t.after(() => page.close());
  const faults = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("request", (asked) => {
    const to = asked.url();
    if (!to.startsWith(url) && !to.startsWith("data:")) faults.push(`it asks for ${to}`);
  });
  await page.goto(url);
  return { page, faults };
}

const text = (page, id) => page.textContent(`#${id}`);

const status = (page) => page.getAttribute("body", "data-status");

/** What the page says at one moment. */
const seen = (page) =>
  page.evaluate(() => ({
    ...Object.fromEntries([...document.querySelectorAll("[id]")].map((place) => [place.id, place.textContent])),
    code: document.body.dataset.reasonCode,
  }));

/** What an element looks like; it never stands still. */
async function picture(page, selector) {
  const clip = await page.locator(selector).boundingBox();
  return PNG.sync.read(await page.screenshot({ clip }));
}

/** How many pixels satisfy a condition, of red, green and blue. */
function count({ data }, condition) {
  let found = 0;
  for (let i = 0; i < data.length; i += 4) found += condition(data[i], data[i + 1], data[i + 2]);
  return found;
}

const isGrey = (r, g, b) => Math.max(r, g, b) - Math.min(r, g, b) < 12 && r > 90 && r < 200;
const isRed = (r, g, b) => r > 110 && r > 2 * g && r > 2 * b;

const colours = (image) => {
  const seen = new Set();
  count(image, (r, g, b) => seen.add((r << 16) | (g << 8) | b) && false);
  return seen.size;
};

test("the demo in a browser: status, robot, distances, picture", { timeout: TIMEOUT }, async (t) => {
  const node = new NodeProcess("--view", "0");
  t.after(() => node.kill());
  const { page, faults } = await open(t, await node.url());

  const free = await until(async () => {
    const now = await seen(page);
    return now.status === "FREE" && now.distance !== "–" && now;
  }, "a distance");
  assert.equal(free.reason, "");
  assert.match(free.age, /^-?\d+(\.\d)? (µs|ms|s)$/);
  assert.match(free["compute-time"], /^\d+(\.\d)? (µs|ms|s)$/);
  assert.ok(Number(free["pairs-checked"]) > 0);

  const links = readFileSync(URDF, "utf8").match(/<link\s/g).length;
  await until(async () => (await text(page, "links")) === `${links}`, `${links} links`);
  assert.equal(await text(page, "robot"), "demo_arm");
  assert.ok(Number(await text(page, "obstacles")) > 0);

  const distances = new Set();
  await until(async () => {
    const distance = await text(page, "distance");
    if (/^\d+\.\d mm$/.test(distance)) distances.add(distance);
    return distances.size >= 5;
  }, "five different distances");

  await until(async () => colours(await picture(page, "#scene")) > 200, "a picture of the robot");
  await until(async () => !(await page.isVisible("#scene-note")), "no word that the robot is not shown yet");
  if (process.env.CLEARANCE_VIEW_PICTURE) await keepPicture(page);
  const isLine = (r, g, b) => b > r + 60 && b > g + 20;
  await until(async () => count(await picture(page, "#chart canvas"), isLine) > 20, "a line in the chart");
  assert.deepEqual(faults, []);

  assert.equal(await node.stop(), 0, node.output);
  const silence = await until(async () => {
    const now = await seen(page);
    return /heard nothing from the node/.test(now.reason) && now;
  }, "UNKNOWN after the end of the node");
  assert.deepEqual([silence.status, silence.distance], ["UNKNOWN", "–"]);
});

/** Near, and not colliding: lines with distances are seen. */
async function keepPicture(page) {
  await until(async () => {
    const now = await seen(page);
    return now.status === "FREE" && Number.parseFloat(now.distance) < 50 && now.pairs !== "";
  }, "near pairs");
  await writeFile(process.env.CLEARANCE_VIEW_PICTURE, await page.screenshot());
}

test("contacts: the depth in the list, a dot and a line in the picture", { timeout: TIMEOUT }, async (t) => {
  process.env.ROS_DOMAIN_ID = "8";
  const parameters = ["-p", "stale_after:=3600.0", "-p", "contacts_per_pair:=3"];
  const node = new NodeProcess("node", "--urdf", TWO_LINK, "--view", "0", "--ros-args", ...parameters);
  t.after(() => {
    node.kill();
    delete process.env.ROS_DOMAIN_ID;
  });
  const { page, faults } = await open(t, await node.url());
  const driver = new Driver(t);
  const isContact = (r, g, b) => r > 150 && b > 130 && g < 90;

  driver.report(0, 0);
  await until(async () => (await seen(page)).status === "FREE", "the stretched robot");
  await until(async () => colours(await picture(page, "#scene")) > 100, "a picture of the robot");
  assert.equal(count(await picture(page, "#scene"), isContact), 0);
  driver.report(0, Math.PI);
  const collision = await until(async () => {
    const now = await seen(page);
    return now.status === "COLLIDING" && now;
  }, "the collision");
  assert.equal(collision.pairs, "base – tiptouches, 300.0 mm deep");
  await until(async () => count(await picture(page, "#scene"), isContact) > 20, "a contact");
  assert.deepEqual(faults, []);
});

test("joint states of rclpy: distances, collision, silence", { timeout: TIMEOUT }, async (t) => {
  process.env.ROS_DOMAIN_ID = "7";
  const node = new NodeProcess("node", "--urdf", TWO_LINK, "--view", "0", "--ros-args", "-p", "stale_after:=2.0");
  t.after(() => {
    node.kill();
    delete process.env.ROS_DOMAIN_ID;
  });
  const { page, faults } = await open(t, await node.url());
  const driver = new Driver(t);
  const says = (word, distance) => async () => {
    const now = await seen(page);
    return now.status === word && now.distance === distance && now;
  };

  driver.report(0, 0);
  const stretched = await until(says("FREE", "700.0 mm"), "the stretched robot");
  assert.equal(stretched.nearest, "base – tip");
  await until(async () => (await text(page, "links")) === "3", "the links");
  driver.report(0, (5 * Math.PI) / 6);
  await until(says("FREE", "200.0 mm"), "the robot folded");
  const red = count(await picture(page, "#scene"), isRed);

  driver.report(0, Math.PI);
  const collision = await until(says("COLLIDING", "0.0 mm"), "the collision");
  assert.equal(collision.pairs, "base – tiptouches");
  await until(async () => count(await picture(page, "#scene"), isRed) > red + 500, "colliding links in red");

  driver.report();
  const silence = await until(async () => {
    const now = await seen(page);
    return now.code === "stale" && now;
  }, "UNKNOWN (stale)");
  assert.deepEqual([silence.status, silence.distance, silence.pairs], ["UNKNOWN", "–", ""]);
  await until(async () => count(await picture(page, "#scene"), isRed) <= red + 50, "no link in red");

  driver.report(0, 0);
  await until(says("FREE", "700.0 mm"), "the stretched robot again");
  assert.deepEqual(faults, []);
  assert.equal(await node.stop(), 0, node.output);
});

test("without joint states the page says UNKNOWN and why", { timeout: TIMEOUT }, async (t) => {
  const node = new NodeProcess("node", "--urdf", URDF, "--view", "0");
  t.after(() => node.kill());
  const { page, faults } = await open(t, await node.url());
  const silence = await until(async () => {
    const now = await seen(page);
    return now.code === "no_joint_state" && now;
  }, "the reason");
  assert.deepEqual([silence.status, silence.distance], ["UNKNOWN", "–"]);
  assert.match(silence.reason, /joint state/);
  await until(async () => (await text(page, "robot")) === "demo_arm", "the robot");
  const note = await until(async () => {
    const now = await text(page, "scene-note");
    return now.includes("default pose") && now;
  }, "the robot in its default pose, and a word about it");
  assert.match(note, /joint state/, "the note says what is missing");
  await until(async () => count(await picture(page, "#scene"), isGrey) > 1000, "a greyed robot");
  assert.deepEqual(faults, []);
  assert.equal(await node.stop(), 0, node.output);
});

test("lengths have one unit, and what is padding is said", { timeout: TIMEOUT }, async (t) => {
  process.env.ROS_DOMAIN_ID = "8";
  const parameters = ["-p", "pad_self:=true", "-p", "influence_distance:=5.0"];
  const node = new NodeProcess("node", "--urdf", TWO_LINK, "--padding", "0.1", "--view", "0", "--ros-args", ...parameters);
  t.after(() => {
    node.kill();
    delete process.env.ROS_DOMAIN_ID;
  });
  const { page, faults } = await open(t, await node.url());
  const driver = new Driver(t);
  driver.report(0, 0);
  const shown = await until(async () => {
    const now = await seen(page);
    return now.status === "FREE" && now.labels !== "" && now;
  }, "a label at the line between nearest points");
  assert.equal(shown.distance, "500.0 mm");
  assert.match(shown.labels, /^500\.0 mm700\.0 mm less 200\.0 mm padding/, "numbers and labels are of the same state");
  assert.match(shown.padding, /^up to 200\.0 mm/);
  assert.doesNotMatch(shown.pairs, /\d\.\d{4} m/);
  assert.deepEqual(faults, []);
});

/** The box around the pixels that satisfy a condition, as shares of the picture: left, top, right, bottom. */
function boxOf({ data, width, height }, condition) {
  const box = [1, 1, 0, 0];
  for (let i = 0; i < data.length; i += 4) {
    if (!condition(data[i], data[i + 1], data[i + 2])) continue;
    const [x, y] = [((i / 4) % width) / width, Math.floor(i / 4 / width) / height];
    [box[0], box[1], box[2], box[3]] = [Math.min(box[0], x), Math.min(box[1], y), Math.max(box[2], x), Math.max(box[3], y)];
  }
  return box;
}

test("the camera shows robot and world whole, and does so again on request", { timeout: TIMEOUT }, async (t) => {
  const node = new NodeProcess("node", "--urdf", URDF, "--world", "config/demo_world.yaml", "--view", "0");
  t.after(() => node.kill());
  const { page } = await open(t, await node.url());
  const isObstacle = (r, g, b) => b > r + 35 && b > g + 15;
  const isWhole = async () => {
    const image = await picture(page, "#scene");
    const [left, top, right, bottom] = boxOf(image, isObstacle);
    return count(image, isObstacle) > 1000 && left > 0.005 && top > 0.005 && right < 0.995 && bottom < 0.995;
  };
  await until(isWhole, "all obstacles in the picture");
  const middle = [300, 290];
  await page.mouse.move(...middle);
  for (let i = 0; i < 12; i++) await page.mouse.wheel(0, -400);
  await until(async () => !(await isWhole()), "a camera that the user has moved");
  await page.click("#fit");
  await until(isWhole, "all obstacles in the picture again");
  await page.setViewportSize({ width: 420, height: 900 });
  await until(isWhole, "all obstacles in a narrow picture");
});

test("a page that was pointed here by another name is refused", { timeout: TIMEOUT }, async (t) => {
  const node = new NodeProcess("node", "--urdf", URDF, "--view", "0");
  t.after(() => node.kill());
  const { port } = new URL(await node.url());
  const ask = (path, headers) =>
    new Promise((done, fail) => {
      request({ host: "127.0.0.1", port, path, headers }, (answer) => {
        answer.resume();
        done(answer.statusCode);
      }).on("error", fail).end();
    });
  assert.equal(await ask("/", { host: `localhost:${port}` }), 200);
  assert.equal(await ask("/", { host: `evil.example:${port}` }), 421);
  assert.equal(await ask("/robot", { host: "evil.example" }), 421);
  assert.equal(await ask("/../Cargo.toml", {}), 404);
});

test("the usual port may be taken, a named one may not", { timeout: TIMEOUT }, async (t) => {
  const first = new NodeProcess("node", "--view");
  const second = new NodeProcess("node", "--view");
  t.after(() => [first, second].forEach((node) => node.kill()));
  const urls = [await first.url(), await second.url()];
  assert.notEqual(urls[0], urls[1]);
  assert.ok(urls.includes("http://127.0.0.1:8642/"), `${urls}`);
  assert.ok(urls.every((url) => url.startsWith("http://127.0.0.1:")), `${urls}`);

  const taken = createServer().listen(0, "127.0.0.1");
  t.after(() => taken.close());
  await until(() => taken.listening, "a taken port");
  const refused = new NodeProcess("node", "--view", `${taken.address().port}`);
  assert.equal(await refused.ended, 2);
  assert.match(refused.output, new RegExp(`127.0.0.1:${taken.address().port}`));
});

test("an address that others reach is served only when it is named, with a warning", { timeout: TIMEOUT }, async (t) => {
  const node = new NodeProcess("node", "--view", "0.0.0.0:0");
  t.after(() => node.kill());
  const { port } = new URL(await node.url());
  assert.match(node.output, /open to everyone who can reach/);
  const answer = await fetch(`http://127.0.0.1:${port}/`);
  assert.equal(answer.status, 200);

  const wrong = new NodeProcess("node", "--view", "robot.example:80");
  assert.equal(await wrong.ended, 2);
  assert.match(wrong.output, /IP:PORT/);
});

test("without a node: a slider moves the robot, and the distance changes", { timeout: TIMEOUT }, async (t) => {
  const node = new NodeProcess("view", "--urdf", TWO_LINK, "--address", "0");
  t.after(() => node.kill());
  const { page, faults } = await open(t, await node.url());
  const says = (word, distance) => async () => {
    const now = await seen(page);
    return now.status === word && now.distance === distance && now;
  };
  await until(says("FREE", "700.0 mm"), "the stretched robot");
  await until(async () => (await page.locator("#sliders input").count()) === 2, "two sliders");
  assert.equal(await page.isVisible("#age"), false);
  const slide = (position) =>
    page.locator('#sliders input[data-joint="joint2"]').evaluate((input, position) => {
      input.value = position;
      input.dispatchEvent(new Event("input"));
    }, position);

  await slide((5 * Math.PI) / 6);
  await until(says("FREE", "200.0 mm"), "the robot folded");
  assert.match(await text(page, "sliders"), /150\.0°/);
  await until(async () => colours(await picture(page, "#scene")) > 100, "a picture of the robot");
  const red = count(await picture(page, "#scene"), isRed);
  await slide(Math.PI);
  const collision = await until(says("COLLIDING", "0.0 mm"), "the collision");
  assert.match(collision.pairs, /^base – tiptouches, 300\.0 mm deep/);
  await until(async () => count(await picture(page, "#scene"), isRed) > red + 500, "colliding links in red");
  assert.deepEqual(faults, []);
  assert.equal(await node.stop(), 0, node.output);
});
