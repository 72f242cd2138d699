// Starts the page: worlds, controls, time.
import { Unpacker } from "./pack.js";
import { Track } from "./track.js";
import { World } from "./world.js";
import { Stage } from "./stage.js";
import { Panel, make } from "./panel.js";
import { Live } from "./live.js";

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];

/** The time that is shown. */
class Player {
  constructor(place, tracks) {
    this.tracks = tracks;
    this.time = 0;
    this.speed = 1;
    this.isPlaying = true;
    this.button = make("button", { ariaLabel: "play or pause", onclick: () => this.toggle() });
    this.slider = make("input", { type: "range", min: 0, step: "any", ariaLabel: "time" });
    this.slider.max = this.duration;
    this.slider.oninput = () => this.seek(Number(this.slider.value));
    this.clock = make("output");
    const speeds = make("select", { ariaLabel: "speed" });
    for (const speed of SPEEDS) {
      speeds.append(make("option", { value: speed, textContent: `${speed} x`, selected: speed === 1 }));
    }
    speeds.onchange = () => (this.speed = Number(speeds.value));
    place.append(this.button, this.slider, this.clock, speeds);
    addEventListener("keydown", (event) => this.press(event));
    this.show();
  }

  get duration() {
    return Math.max(...this.tracks.map((track) => track.duration));
  }

  /** The times that curves show. */
  span = () => [0, this.duration];

  toggle() {
    this.isPlaying = !this.isPlaying;
    if (this.isPlaying && this.time >= this.duration) this.time = 0;
    this.show();
  }

  /** Shows a time and stops there. */
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    this.isPlaying = false;
    this.show();
  }

  /** Moves on by a span of the clock on the wall [s]. */
  advance(span) {
    if (!this.isPlaying) return;
    this.time = Math.min(this.time + this.speed * span, this.duration);
    if (this.time >= this.duration) this.isPlaying = false;
    this.show();
  }

  show() {
    this.button.textContent = this.isPlaying ? "Pause" : "Play";
    this.slider.value = this.time;
    this.clock.textContent = `${this.time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
  }

  press(event) {
    if (event.target.matches("select, input[type=number]")) return;
    const jump = { ArrowLeft: -0.1, ArrowRight: 0.1 }[event.key];
    if (jump !== undefined) this.seek(this.time + jump);
    else if (event.key === " ") this.toggle();
    else return;
    event.preventDefault();
  }
}

/** Draws frames for ever. */
function run(stage, panel, player, look) {
  let before = performance.now();
  const frame = (now) => {
    player.advance(Math.min((now - before) / 1000, 0.25));
    before = now;
    for (const world of stage.worlds) world.update(player.time, look);
    stage.draw();
    panel.draw();
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

/** Shows the page's content; called by loader.js. */
export async function start(content, packed) {
  const unpacker = new Unpacker(packed);
  const live = content.live ? new Live(content) : null;
  const tracks = live
    ? [live.track]
    : content.flights.map((flight) =>
        Track.of(flight.track, flight.world.bodies.length, unpacker),
      );
  const worlds = content.flights.map(
    (flight, k) => new World(flight, tracks[k], unpacker, k > 0),
  );
  if (live) await live.connect();
  const look = { trail: 2, thrust: false, goals: true };
  for (const world of worlds) world.update(0, look);
  const stage = new Stage(document.getElementById("stage"), worlds);
  if (live) stage.setView("follow");
  const footer = document.getElementById("player");
  const player = live ? live.playerIn(footer) : new Player(footer, tracks);
  const panel = new Panel(document.getElementById("panel"), content, stage, look, player);
  if (live) live.control(stage, panel);
  const labels = document.getElementById("labels");
  labels.append(make("h1", { textContent: content.title }));
  labels.append(make("p", { textContent: content.flights.map((f) => f.label).join(" · ") }));
  globalThis.skybody = { stage, player, panel, tracks, live }; // for tests and curious users
  run(stage, panel, player, look);
}
