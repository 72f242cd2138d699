// A running simulation behind the page: its states come as events, changes go as requests.
import * as THREE from "three";
import { Track } from "./track.js";
import { make } from "./panel.js";

const KEPT = 60; // of the past [s]
const RATE = 30; // states per second
const NOTICE = 5; // for which a refusal is shown [s]

/** The connection to `skybody view --live`. */
export class Live {
  /** @param {object} content the page's data of the only flight */
  constructor(content) {
    this.content = content;
    const { track, world } = content.flights[0];
    const sizes = {
      bodies: world.bodies.length,
      rotors: world.rotors.length,
      goals: track.goals,
      series: track.series,
    };
    this.track = new Track(sizes, KEPT * RATE);
    this.state = {};
  }

  /** Waits for the first state. */
  async connect() {
    const events = new EventSource("states");
    await new Promise((resolve, reject) => {
      events.onmessage = (event) => {
        this.receive(JSON.parse(event.data));
        resolve();
      };
      events.onerror = () => {
        this.say?.("the simulation has ended");
        reject(new Error("the simulation cannot be reached"));
      };
    });
  }

  receive(state) {
    if (state.episode !== this.state.episode || state.time < this.state.time) this.track.clear();
    if (state.time !== this.state.time || this.track.rows === 0) this.track.append(state);
    this.state = state;
    this.show?.();
  }

  /** Sends a change to the simulation. */
  async send(change) {
    const reply = await fetch("change", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(change),
    });
    if (!reply.ok) this.say?.(await reply.text());
  }

  /** The buttons below the view, and the time that is shown: the simulation's. */
  playerIn(place) {
    const pause = make("button", { onclick: () => this.send({ pause: !this.state.paused }) });
    const step = make("button", { textContent: "Step", onclick: () => this.send({ step: 1 }) });
    const reset = make("button", { textContent: "Reset", onclick: () => this.send({ reset: true }) });
    const clock = make("output");
    const text = make("output");
    const speeds = make("select", { ariaLabel: "speed" });
    for (const speed of [0.1, 0.25, 0.5, 1, 2, 4]) {
      speeds.append(make("option", { value: speed, textContent: `${speed} x`, selected: speed === 1 }));
    }
    speeds.onchange = () => this.send({ speed: Number(speeds.value) });
    place.append(pause, step, reset, speeds, clock, text);
    let notice = { text: "", end: 0 };
    this.say = (message) => {
      notice = { text: message, end: performance.now() + 1000 * NOTICE };
      text.textContent = message;
    };
    this.show = () => {
      pause.textContent = this.state.paused ? "Go" : "Pause";
      clock.textContent = `episode ${this.state.episode}, ${this.state.time.toFixed(2)} s`;
      text.textContent = performance.now() < notice.end ? notice.text : this.state.text;
    };
    this.show();
    const track = this.track;
    return {
      get time() {
        return track.duration;
      },
      span: () => [Math.max(track.time[0], track.duration - 20), Math.max(track.duration, 1)],
      seek() {},
      advance() {},
    };
  }

  /** Sliders of parameters; dragging a body pulls at it. */
  control(stage, panel) {
    const section = panel.heading("Parameters");
    const { params } = this.content;
    const select = make("select", { ariaLabel: "parameter" });
    for (const { path } of params) select.append(make("option", { textContent: path }));
    const add = make("button", { textContent: "Add" });
    add.onclick = () => this.addParameter(section, params[select.selectedIndex]);
    if (params.length > 0) section.append(make("div", { className: "row" }, select, add));
    for (const one of params.slice(0, 3)) this.addParameter(section, one);
    new Drag(stage, this);
  }

  addParameter(section, { path, unit, value, low, high }) {
    const now = make("output", { textContent: `${Number(value.toPrecision(4))} ${unit}` });
    const slider = make("input", { type: "range", min: low, max: high, step: "any" });
    slider.value = value;
    slider.ariaLabel = path;
    slider.oninput = () => {
      now.textContent = `${Number(Number(slider.value).toPrecision(4))} ${unit}`;
      this.send({ param: path, value: Number(slider.value) });
    };
    section.append(make("div", {}, make("b", { textContent: path })));
    section.append(make("div", { className: "row" }, slider, now));
  }
}

/** A spring between a point of a body and the pointer, while the button is down. */
class Drag {
  constructor(stage, live) {
    Object.assign(this, { stage, live, body: null });
    this.plane = new THREE.Plane();
    this.pointer = new THREE.Vector3();
    this.arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, 0xd02020);
    this.arrow.visible = false;
    for (const part of this.arrow.children) {
      part.material.depthTest = false; // seen through the robot
      part.renderOrder = 1;
    }
    stage.scene.add(this.arrow);
    const canvas = stage.renderer.domElement;
    canvas.addEventListener("pointerdown", (event) => this.begin(event), { capture: true });
    addEventListener("pointermove", (event) => this.move(event));
    addEventListener("pointerup", () => this.end());
    addEventListener("pointercancel", () => this.end());
    setInterval(() => this.pull(), 1000 / RATE);
  }

  begin(event) {
    const { body, point } = this.stage.pick(event.clientX, event.clientY);
    if (body === null || event.button !== 0) return;
    event.stopImmediatePropagation(); // the view stays
    event.target.setPointerCapture(event.pointerId); // a release outside of the window counts, too
    this.body = body;
    const away = this.stage.camera.getWorldDirection(new THREE.Vector3());
    this.plane.setFromNormalAndCoplanarPoint(away, point);
    this.pointer.copy(point);
    this.offset = point.clone().sub(this.place());
  }

  move(event) {
    if (this.body === null) return;
    const { ray } = this.stage.pick(event.clientX, event.clientY);
    ray.ray.intersectPlane(this.plane, this.pointer);
  }

  pull() {
    if (this.body === null) return;
    const start = this.place().clone().add(this.offset);
    const along = this.pointer.clone().sub(start);
    const length = along.length();
    this.arrow.visible = length > 1e-3;
    this.arrow.position.copy(start);
    if (this.arrow.visible) {
      this.arrow.setDirection(along.clone().normalize());
      this.arrow.setLength(length, Math.min(0.3 * length, 0.2), Math.min(0.15 * length, 0.1));
    }
    this.live.send({ pull: this.body, along: along.toArray() });
  }

  end() {
    if (this.body === null) return;
    this.live.send({ pull: this.body, along: [0, 0, 0] });
    this.body = null;
    this.arrow.visible = false;
  }

  place() {
    return this.stage.worlds[0].bodies[this.body].position;
  }
}
