// What the badge says of a robot, and what its evidence is: what came last, and how long ago that was.

import {describeFleet, isFleet} from "./fleet.js";
import {isKnown} from "./layers.js";

export const SILENT_S = 3;  // three statuses are missing
const NO_SCAN_S = 3;        // no laser is so slow
const RESULTS_S = 30;       // that a run which has ended may take until it is shown as a finished one
const ON_THE_WAY = ["ray_selector", "rrhc_matcher", "map_updater"];  // of a scan
const TRUST = {good: ["good", "GOOD"], doubtful: ["warn", "DOUBTFUL"], bad: ["bad", "BAD"], none: ["none", "FINISHED"]};

export const seconds = (age_s) => (age_s < 120 ? `${Math.floor(age_s)} s` : `${Math.floor(age_s / 60)} min`);

// What the robot's pose is worth on the map, where it is none of it.
const describeFloating = ({robot, timeline}) =>
  `floating: ${timeline ? "on another piece than the one that is shown" : "not joined to the map yet"} (trajectory ${robot.trajectory})`;

// Why the map was drawn anew. is_loop: a loop was closed; most_m: how far it moved the path.
export const describeCorrection = ({is_loop, most_m}) =>
  `${is_loop ? "loop closed: " : ""}the map was corrected${most_m > 0 ? ` by up to ${most_m.toFixed(2)} m` : ""}`;

// 0 to 179: an axis has no sign.
export const toAxisDegrees = (angle_rad) => (Math.round((angle_rad * 180) / Math.PI) + 180) % 180;

// How long the last scans have been in the state of the last one.
function ageOfState(samples) {
  const last = samples.at(-1);
  if (!last) return 0;
  let first = last;
  for (let i = samples.length - 1; i >= 0 && samples[i].state === last.state; --i) first = samples[i];
  return Math.max(0, last.time_s - first.time_s);
}

function describeRobot(model) {
  const {robot, samples, timeline, info} = model;
  if (model.is_nowhere && localises(model)) {
    return {tone: "bad", text: "NOT LOCALISED", why: "no scan fits the map so far: with the pin (O) you say where the robot is"};
  }
  if (robot.state === "LOST") {
    const age_s = timeline ? 0 : ageOfState(samples);
    return {tone: "bad", text: age_s >= 1 ? `LOST for ${seconds(age_s)}` : "LOST",
            why: "the scan fits nowhere on the map, and is not drawn"};
  }
  if (robot.state === "NO RAYS") return {tone: "bad", text: "NO RAYS", why: "nothing of the scan is a measurement"};
  if (robot.floating) return {tone: "floating", text: "FLOATING", why: describeFloating({robot, timeline})};
  if (robot.state === "DEGENERATE") {
    const {axis} = robot;
    return {tone: "warn", text: isKnown(axis) ? `DEGENERATE along ${toAxisDegrees(Math.atan2(axis.y, axis.x))}°` : "DEGENERATE",
            why: "the scan does not fix the position in this direction"};
  }
  if (info.another_piece) {
    return {tone: "warn", text: "ANOTHER PIECE", why: "another piece is the larger one now and is shown; the first one floats"};
  }
  if (robot.state === "START") return {tone: "start", text: "START", why: ""};
  return {tone: "good", text: localises({info}) ? "LOCALISED" : "OK", why: ""};
}

// Whether the map is a finished one, on which the robot is found.
export const localises = ({info}) =>
  Boolean(info.localised) || info.services.some(({state}) => /^localising/.test(state ?? ""));

function describeFinished(model) {
  const {timeline, info} = model;
  if (timeline && !timeline.is_at_end && model.robot) return describeRobot(model);
  const {trust = "none", lines = []} = info.verdict ?? {};
  const [tone, text] = TRUST[trust] ?? TRUST.none;
  const why = lines.find((line) => /map is|no verdict/.test(line)) ?? lines[0] ?? "";
  const off = lines.find((line) => /may be off by/.test(line)) ?? "";
  return {tone, text, why: [why, off.replace(/,.*/, "")].filter(Boolean).join("; ")};
}

function describeLive(model, now_ms) {
  const {info, robot} = model;
  const since_s = Math.max(0, (now_ms - model.info_at_ms) / 1000);  // since the viewer said it
  if (since_s > 5) return {tone: "bad", text: `map_viewer silent for ${seconds(since_s)}`, why: "it hangs, or the network does"};
  const silent = info.services.filter(({silent_s}) => silent_s + since_s > SILENT_S);
  const stopped = silent.find(({name}) => [...ON_THE_WAY, "fleet_mapper"].includes(name));
  if (stopped) {
    return {tone: "bad", text: `${stopped.name} silent for ${seconds(stopped.silent_s + since_s)}`,
            why: "it was stopped, or it hangs: scans are not mapped"};
  }
  if (isFleet(model)) return describeFleet(model);
  if (!(info.scan_age_s >= 0)) {
    const missing = ON_THE_WAY.filter((name) => !info.services.some((service) => service.name === name));
    return {tone: "none", text: "waiting for scans",
            why: missing.length ? `${missing.join(", ")} not heard yet` : "no scan has come yet: is the driver of the laser running?"};
  }
  const publisher = info.services.find(({name}) => name === "laser_publisher");
  const scan_age_s = info.scan_age_s + since_s;
  if (scan_age_s > NO_SCAN_S && hasEnded(info)) {
    return {tone: "none", text: "LOG ENDED", why: "all scans of the log are published"};
  }
  if (scan_age_s > NO_SCAN_S) {
    return {tone: "bad", text: `no scan for ${seconds(scan_age_s)}`,
            why: publisher && silent.includes(publisher) ? "laser_publisher is silent" : "laser unplugged, or its driver stopped?"};
  }
  const match_age_s = (info.match_age_s ?? Infinity) + since_s;
  if (robot && match_age_s > scan_age_s + NO_SCAN_S) {
    return {tone: "bad", text: `no pose for ${seconds(match_age_s)}`, why: "scans come, but none is matched"};
  }
  if (!robot) return {tone: "none", text: "waiting for a pose", why: "scans come, none is matched yet"};
  const state = describeRobot(model);
  if (silent.length === 0) return state;
  const other = silent[0];
  return {...state, tone: state.tone === "good" ? "warn" : state.tone,
          why: [state.why, `${other.name} silent for ${seconds(other.silent_s + since_s)}`].filter(Boolean).join("; ")};
}

const hasEnded = ({services}) => services.some(({name, state}) => name === "laser_publisher" && state === "finished");

// tone: good, warn, bad, floating, start or none; text: of the badge; why: a few words more, which may be empty.
export function describeState(model, now_ms) {
  const {connected, refusal, trouble, info} = model;
  const loaded = model.loadedShare();
  if (trouble) return {tone: "bad", text: `page error: ${trouble}`, why: "reload the page"};
  if (refusal) {
    return {tone: "bad", text: refusal, why: refusal.startsWith("token") ?
            "open the whole link, with #token=..., that map_viewer prints when it starts; run_stack --view keeps it in log/map_viewer.log" :
            "of this number; remove it from the link"};
  }
  if (!connected) {
    const age_s = (now_ms - model.connection_at_ms) / 1000;
    if (hasEnded(info) && age_s < RESULTS_S) {
      return {tone: "none", text: "LOG ENDED", why: "the results are written; the finished run is here in a moment"};
    }
    return {tone: "bad", text: age_s < 1 ? "no connection" : `no connection for ${seconds(age_s)}`,
            why: "is map_viewer running? The page connects again by itself"};
  }
  if (loaded !== null) return {tone: "none", text: `loading, ${Math.floor(100 * loaded)} %`, why: ""};
  if (info.live === false) return describeFinished(model);
  if (info.live === undefined) return {tone: "none", text: "waiting", why: "connected, nothing was told yet"};
  return describeLive(model, now_ms);
}
