// The controls beside the view: views, flights, looks, curves, events.
import { VIEWS } from "./stage.js";
import { Plot } from "./plots.js";

const DEFAULT_PLOTS = 3;

/** An element with properties and children. */
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  Object.assign(element, properties);
  element.append(...children);
  return element;
}

/** CSS colour of numbers from 0 to 1. */
export function css([red, green, blue]) {
  return `rgb(${[red, green, blue].map((part) => Math.round(255 * part)).join(" ")})`;
}

/** The controls. `player` has time, duration and seek(). */
export class Panel {
  /**
   * @param {HTMLElement} place
   * @param {object} content the page's data
   * @param {import("./stage.js").Stage} stage
   * @param {{trail: number, thrust: boolean, goals: boolean}} look changed by the controls
   */
  constructor(place, content, stage, look, player) {
    Object.assign(this, { place, content, stage, look, player });
    this.plots = [];
    this.addViews();
    if (content.flights.length > 1) this.addFlights();
    this.addLooks();
    if (content.curve) this.addCurve(content.curve);
    this.addPlots();
    if (content.flights.some((flight) => flight.events.length > 0)) this.addEvents();
  }

  /** Draws the curves at the present time. */
  draw() {
    const { time, span } = this.player;
    for (const plot of this.plots) this.drawPlot(plot, time, span());
  }

  // --- parts --------------------------------------------------------------------------------------

  heading(text) {
    const section = make("section");
    section.append(make("h2", { textContent: text }));
    this.place.append(section);
    return section;
  }

  addViews() {
    const section = this.heading("View");
    const buttons = VIEWS.map((view) =>
      make("button", {
        textContent: view[0].toUpperCase() + view.slice(1),
        ariaPressed: String(view === this.stage.view),
        onclick: () => choose(view),
      }),
    );
    const choose = (view) => {
      this.stage.setView(view);
      buttons.forEach((button, k) => (button.ariaPressed = String(VIEWS[k] === view)));
    };
    const home = make("button", { textContent: "Center", onclick: () => this.stage.home() });
    section.append(make("div", { className: "row" }, ...buttons, home));
    this.addFollowed(section);
  }

  addFollowed(section) {
    const flights = this.content.flights;
    const options = flights.flatMap((flight, world) =>
      flight.world.robots.map((robot, k) => ({
        text: flights.length > 1 ? `${robot.name} in ${flight.label}` : robot.name,
        followed: { world, robot: k },
      })),
    );
    if (options.length < 2) return;
    const select = make(
      "select",
      { ariaLabel: "robot to follow" },
      ...options.map(({ text }) => make("option", { textContent: text })),
    );
    select.onchange = () => {
      this.stage.followed = options[select.selectedIndex].followed;
      this.stage.setView(this.stage.view);
    };
    section.append(make("div", { className: "row" }, "of", select));
  }

  addFlights() {
    const section = this.heading("Flights");
    this.content.flights.forEach((flight, k) => {
      const box = make("input", { type: "checkbox", checked: true });
      box.onchange = () => (this.stage.shown[k] = box.checked);
      const swatch = make("span", { className: "swatch" });
      swatch.style.background = css(flight.color);
      section.append(make("label", {}, box, swatch, make("b", { textContent: flight.label })));
    });
    const button = make("button", { textContent: "Side by side", ariaPressed: "false" });
    button.onclick = () => {
      this.stage.apart = !this.stage.apart;
      button.ariaPressed = String(this.stage.apart);
      this.stage.worlds.forEach((world, k) => world.setGhost(k > 0 && !this.stage.apart));
    };
    section.append(make("div", { className: "row" }, button));
  }

  addLooks() {
    const section = this.heading("Show");
    const length = make("output", { textContent: `${this.look.trail} s` });
    const trail = make("input", { type: "range", min: 0, max: 20, step: 0.5 });
    trail.value = this.look.trail;
    trail.oninput = () => {
      this.look.trail = Number(trail.value);
      length.textContent = `${trail.value} s`;
    };
    section.append(make("label", {}, "trail", trail, length));
    for (const name of ["thrust", "goals"]) {
      const box = make("input", { type: "checkbox", checked: this.look[name] });
      box.onchange = () => (this.look[name] = box.checked);
      section.append(make("label", {}, box, name));
    }
  }

  addCurve(curve) {
    const section = this.heading(curve.title);
    const place = make("div", { className: "plot" });
    section.append(place, make("output", { textContent: `${curve.x_label}; ${curve.y_label}` }));
    const plot = new Plot(place, 130);
    const xs = curve.points.map(([x]) => x);
    const marks = curve.marks.map(([x], k) => ({ x, color: this.colorOf(k) }));
    const one = [{ color: "#39424a", points: curve.points }];
    const draw = () => plot.draw(one, [Math.min(...xs), Math.max(...xs)], marks);
    requestAnimationFrame(draw);
  }

  addPlots() {
    this.plotSection = this.heading("Values");
    const names = this.content.flights[0].track.series.map(({ name }) => name);
    names.slice(0, DEFAULT_PLOTS).forEach((name) => this.addPlot(name));
    const more = make("button", { textContent: "Add a plot" });
    more.onclick = () => this.addPlot(names[Math.min(this.plots.length, names.length - 1)]);
    this.place.append(more);
  }

  addPlot(name) {
    const series = this.content.flights[0].track.series;
    const select = make("select", { ariaLabel: "value of the plot" });
    for (const one of series) {
      const text = one.unit ? `${one.name} [${one.unit}]` : one.name;
      select.append(make("option", { value: one.name, textContent: text }));
    }
    select.value = name;
    const now = make("output");
    const place = make("div", { className: "plot" });
    place.append(make("div", { className: "row" }, select, now));
    this.plotSection.append(place);
    const plot = new Plot(place);
    const seek = (event) => {
      if (event.buttons === 1) this.player.seek(plot.valueAt(event.clientX));
    };
    plot.canvas.onpointerdown = seek;
    plot.canvas.onpointermove = seek;
    this.plots.push({ plot, select, now });
  }

  drawPlot({ plot, select, now }, time, span) {
    const curves = [];
    let text = "";
    this.stage.worlds.forEach(({ track }, k) => {
      const column = track.series.findIndex(({ name }) => name === select.value);
      if (column < 0 || !this.stage.shown[k] || track.rows === 0) return;
      curves.push({ color: this.colorOf(k), points: pointsOf(track, column, span) });
      const value = track.value(column, track.at(time));
      if (text === "" && Number.isFinite(value)) text = value.toPrecision(4);
    });
    now.textContent = text;
    plot.draw(curves, span, [{ x: time, color: "#9aa4ac" }]);
  }

  colorOf(k) {
    return css(this.content.flights[k].color);
  }

  addEvents() {
    const section = this.heading("Events");
    const list = make("ul", { className: "events" });
    for (const flight of this.content.flights) {
      for (const [time, text] of flight.events) {
        const button = make("button", { textContent: `${time.toFixed(2)} s  ${text}` });
        button.onclick = () => this.player.seek(time);
        list.append(make("li", {}, button));
      }
    }
    section.append(list);
  }
}

/** At most 600 points of a column within a span. */
function pointsOf(track, column, [first, last]) {
  const start = track.at(first).row;
  const end = track.at(last).next;
  const step = Math.max(1, Math.floor((end - start) / 600));
  const points = [];
  for (let row = start; row <= end && row < track.rows; row += step) {
    points.push([track.time[row], track.values.values[row * track.values.width + column]]);
  }
  return points;
}
