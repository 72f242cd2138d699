// The world of a flight in three.js: bodies, rotors, couplings, obstacles, trails, goals.
import * as THREE from "three";

const ROPE_PARTS = 16;
const TRAIL_PARTS = 120; // of each robot, at most
const ROPE_COLOR = 0x222224;
const THRUST_COLOR = 0xe5b719;
const GOAL_COLOR = 0x1a9e47;
const TOUCH_COLOR = 0xff5a1f;
const Z = new THREE.Vector3(0, 0, 1);

const here = new THREE.Vector3();
const there = new THREE.Vector3();
const turn = new THREE.Quaternion();
const spread = new THREE.Object3D();

/** A unit cylinder or capsule along z, as skybody has them; those of three.js are along y. */
function alongZ(geometry) {
  return geometry.rotateX(Math.PI / 2);
}

const GEOMETRIES = {
  box: ({ half: [x, y, z] }) => new THREE.BoxGeometry(2 * x, 2 * y, 2 * z),
  sphere: ({ half: [radius] }) => new THREE.SphereGeometry(radius, 32, 20),
  cylinder: ({ half: [radius, , half] }) =>
    alongZ(new THREE.CylinderGeometry(radius, radius, 2 * half, 32)),
  capsule: ({ half: [radius, , half] }) =>
    alongZ(new THREE.CapsuleGeometry(radius, 2 * half, 8, 24)),
  plane: () => new THREE.PlaneGeometry(200, 200),
  mesh: ({ corners }, unpacker) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(unpacker.table(corners), 3));
    geometry.computeVertexNormals();
    return geometry;
  },
};

/** A shape of a body or of the world. */
function meshOf(shape, unpacker, tint) {
  const [red, green, blue] = tint ?? shape.color;
  const color = new THREE.Color().setRGB(red, green, blue, THREE.SRGBColorSpace);
  const material = new THREE.MeshStandardMaterial({
    color,
    roughness: 0.65,
    metalness: 0.05,
    side: shape.kind === "mesh" ? THREE.DoubleSide : THREE.FrontSide,
    transparent: Boolean(tint),
    opacity: tint ? 0.55 : 1,
  });
  const mesh = new THREE.Mesh(GEOMETRIES[shape.kind](shape, unpacker), material);
  const [a, b, c, d, e, f, g, h, i] = shape.axes;
  const axes = new THREE.Matrix4().set(a, b, c, 0, d, e, f, 0, g, h, i, 0, 0, 0, 0, 1);
  mesh.quaternion.setFromRotationMatrix(axes);
  mesh.position.set(...shape.position);
  mesh.castShadow = !tint;
  mesh.receiveShadow = true;
  return mesh;
}

/** A cylinder from point to point, changed by `between`. */
function stick(color, radius, opacity = 1) {
  const geometry = alongZ(new THREE.CylinderGeometry(radius, radius, 1, 10));
  const material = new THREE.MeshStandardMaterial({ color, transparent: opacity < 1, opacity });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.castShadow = opacity === 1;
  return mesh;
}

function between(mesh, start, end) {
  there.subVectors(end, start);
  const length = there.length();
  mesh.visible = length > 1e-6;
  if (!mesh.visible) return;
  mesh.position.addVectors(start, end).multiplyScalar(0.5);
  mesh.quaternion.setFromUnitVectors(Z, there.divideScalar(length));
  mesh.scale.set(1, 1, length);
}

/** Depth of a rope's parabola between ends at a distance, by bisection. */
function sagOf(distance, length) {
  if (length <= distance * 1.0001) return 0;
  let low = 0;
  let high = length;
  for (let k = 0; k < 30; ++k) {
    const sag = 0.5 * (low + high);
    let drawn = 0;
    for (let n = 0; n < ROPE_PARTS; ++n) {
      const [a, b] = [n / ROPE_PARTS, (n + 1) / ROPE_PARTS];
      drawn += Math.hypot(distance / ROPE_PARTS, 4 * sag * (b * (1 - b) - a * (1 - a)));
    }
    if (drawn < length) low = sag;
    else high = sag;
  }
  return low;
}

/** From blue (slow) over green and yellow to red (fast). */
function blend(share, color) {
  return color.setHSL(0.62 * (1 - Math.min(Math.max(share, 0), 1)), 0.85, 0.5);
}

/** Everything that is drawn of one flight. */
export class World {
  /**
   * @param {object} flight the page's data of a flight
   * @param {import("./track.js").Track} track
   * @param {import("./pack.js").Unpacker} unpacker
   * @param {boolean} ghost in its own colour alone, without obstacles
   */
  constructor(flight, track, unpacker, ghost) {
    this.data = flight.world;
    this.track = track;
    this.group = new THREE.Group();
    this.color = new THREE.Color().setRGB(...flight.color, THREE.SRGBColorSpace);
    this.solid = new THREE.Group(); // the parts that a ghost does not have
    this.bodies = this.data.bodies.map((name) => this.addBody(name));
    this.looks = [false, true].map((isGhost) => this.addShapes(unpacker, isGhost, flight.color));
    for (const shape of this.data.obstacles) this.solid.add(meshOf(shape, unpacker, null));
    this.group.add(this.solid);
    this.rotors = this.data.rotors.map((rotor) => this.addRotor(rotor));
    this.couplings = this.data.couplings.map((coupling) => this.addCoupling(coupling));
    this.size = this.sizeOf();
    this.touch = this.addTouch();
    this.trails = this.data.robots.map((robot) => this.addTrail(robot));
    this.goals = track.goalNames.map(() => this.addGoal());
    this.setGhost(ghost);
  }

  /** Whether bodies have the flight's colour, and obstacles are hidden. */
  setGhost(ghost) {
    for (const [k, meshes] of this.looks.entries()) {
      for (const mesh of meshes) mesh.visible = (k === 1) === ghost;
    }
    this.solid.visible = !ghost;
  }

  /**
   * Moves everything to a time [s].
   * @param {{trail: number, thrust: boolean, goals: boolean}} look
   */
  update(time, look) {
    const place = this.track.at(time);
    this.bodies.forEach((body, k) => this.track.pose(k, place, body.position, body.quaternion));
    this.rotors.forEach((rotor, k) => this.moveRotor(rotor, k, place, look.thrust));
    for (const coupling of this.couplings) this.moveCoupling(coupling);
    this.trails.forEach((trail) => this.moveTrail(trail, time, place, look.trail));
    this.goals.forEach((goal, k) => {
      const at = look.goals ? this.track.goal(k, place) : null;
      goal.visible = at !== null;
      if (at !== null) goal.position.set(at[0], at[1], at[2]);
    });
    this.touch.visible = this.track.touches(place);
    if (this.touch.visible) this.touch.position.copy(this.bodies[0].position);
  }

  /** Middle of the robots at their present place. */
  center(target) {
    target.set(0, 0, 0);
    for (const { first } of this.data.robots) target.add(this.bodies[first].position);
    return target.divideScalar(this.data.robots.length);
  }

  /** A sphere about the places of the robots over the flight, of about 60 rows. */
  sphere() {
    if (this.sphereRows === this.track.rows) return this.sphereFound;
    const box = new THREE.Box3();
    const step = Math.max(1, Math.floor(this.track.rows / 60));
    for (const { first } of this.data.robots) {
      for (let row = 0; row < this.track.rows; row += step) {
        this.track.pose(first, { row, next: row, share: 0 }, here, turn);
        if (Number.isFinite(here.x + here.y + here.z)) box.expandByPoint(here);
      }
    }
    const middle = box.isEmpty() ? new THREE.Vector3() : box.getCenter(new THREE.Vector3());
    const radius = box.isEmpty() ? 1 : 0.5 * box.getSize(there).length();
    [this.sphereRows, this.sphereFound] = [this.track.rows, { middle, radius }];
    return this.sphereFound;
  }

  // --- parts --------------------------------------------------------------------------------------

  addBody(name) {
    const body = new THREE.Group();
    body.name = name;
    this.group.add(body);
    return body;
  }

  addShapes(unpacker, isGhost, color) {
    return this.data.shapes.map((shape) => {
      const mesh = meshOf(shape, unpacker, isGhost ? color : null);
      mesh.userData.body = shape.body;
      this.bodies[shape.body].add(mesh);
      return mesh;
    });
  }

  addRotor(rotor) {
    const hub = new THREE.Group();
    hub.position.set(...rotor.position);
    const axis = new THREE.Vector3(...rotor.axis);
    hub.quaternion.setFromUnitVectors(Z, axis);
    const dark = new THREE.MeshStandardMaterial({ color: 0x1a1a1c, roughness: 0.5 });
    const blades = new THREE.Mesh(
      new THREE.BoxGeometry(2 * rotor.radius, 0.18 * rotor.radius, 0.024 * rotor.radius + 2e-4),
      dark,
    );
    blades.position.z = 0.006;
    const radius = 0.13 * rotor.radius;
    const motor = alongZ(new THREE.CylinderGeometry(radius, radius, 0.2 * rotor.radius, 16));
    const disc = new THREE.Mesh(
      new THREE.CircleGeometry(rotor.radius, 32),
      new THREE.MeshBasicMaterial({
        color: 0x555560, transparent: true, opacity: 0.12, side: THREE.DoubleSide, depthWrite: false,
      }),
    );
    disc.position.z = 0.007;
    const thrust = stick(THRUST_COLOR, 0.05 * rotor.radius);
    hub.add(blades, disc, new THREE.Mesh(motor, dark));
    this.bodies[rotor.body].add(hub, thrust);
    return { hub, blades, disc, thrust, axis, spec: rotor };
  }

  moveRotor({ blades, hub, thrust, axis, spec }, k, place, showThrust) {
    const known = k < this.track.rotors.width;
    const { angle, speed } = known ? this.track.rotor(k, place) : { angle: 0, speed: 0 };
    blades.rotation.z = spec.direction * this.data.blades_shown * angle;
    thrust.visible = showThrust && known;
    if (!thrust.visible) return;
    const length = spec.thrust * speed * speed * this.data.arrow;
    between(thrust, hub.position, here.copy(axis).multiplyScalar(length).add(hub.position));
  }

  addCoupling(spec) {
    const parts = spec.kind === "rope" ? ROPE_PARTS : 1;
    const sticks = Array.from({ length: parts }, () => stick(ROPE_COLOR, 0.006));
    this.group.add(...sticks);
    return { spec, sticks, ends: [new THREE.Vector3(), new THREE.Vector3()] };
  }

  moveCoupling({ spec, sticks, ends }) {
    ends.forEach((end, k) => {
      end.set(...spec.points[k]);
      const body = this.bodies[spec.bodies[k]];
      if (body) end.applyQuaternion(body.quaternion).add(body.position);
    });
    const sag = sticks.length > 1 ? sagOf(ends[0].distanceTo(ends[1]), spec.length) : 0;
    const point = (share) => {
      const at = new THREE.Vector3().lerpVectors(ends[0], ends[1], share);
      at.z -= 4 * sag * share * (1 - share);
      return at;
    };
    sticks.forEach((one, k) =>
      between(one, point(k / sticks.length), point((k + 1) / sticks.length)),
    );
  }

  addTrail(robot) {
    const geometry = alongZ(new THREE.CylinderGeometry(1, 1, 1, 6, 1, true));
    const sticks = new THREE.InstancedMesh(geometry, new THREE.MeshBasicMaterial(), TRAIL_PARTS);
    sticks.frustumCulled = false;
    this.group.add(sticks);
    return { sticks, robot };
  }

  /** Sticks along the last seconds of a robot's way, thinner towards the past. */
  moveTrail({ sticks, robot }, time, place, length) {
    const start = this.track.at(time - length).row;
    const count = Math.min(length > 0 ? place.row - start : 0, TRAIL_PARTS);
    sticks.visible = count > 0;
    sticks.count = Math.max(count, 0);
    if (!sticks.visible) return;
    const fastest = this.fastest();
    const mixed = new THREE.Color();
    const end = new THREE.Vector3();
    const row = (k) => Math.round(start + ((place.row - start) * k) / count);
    this.track.pose(robot.first, { row: start, next: start, share: 0 }, end, turn);
    for (let k = 0; k < count; ++k) {
      const next = row(k + 1);
      here.copy(end);
      if (k + 1 === count) end.copy(this.bodies[robot.first].position);
      else this.track.pose(robot.first, { row: next, next, share: 0 }, end, turn);
      spread.position.addVectors(here, end).multiplyScalar(0.5);
      there.subVectors(end, here);
      const long = Math.max(there.length(), 1e-6);
      spread.quaternion.setFromUnitVectors(Z, there.divideScalar(long));
      const thick = 0.05 * this.size * (0.3 + (0.7 * (k + 1)) / count);
      spread.scale.set(thick, thick, long);
      spread.updateMatrix();
      sticks.setMatrixAt(k, spread.matrix);
      sticks.setColorAt(k, blend(this.speed(robot.first, Math.max(next, 1)) / fastest, mixed));
    }
    sticks.instanceMatrix.needsUpdate = true;
    sticks.instanceColor.needsUpdate = true;
  }

  /** Speed between a row and the one before [m/s]. */
  speed(body, row) {
    if (row === 0) return 0;
    const { width, values } = this.track.poses;
    const [a, b] = [(row - 1) * width + 7 * body, row * width + 7 * body];
    const span = this.track.time[row] - this.track.time[row - 1];
    const apart = Math.hypot(...[0, 1, 2].map((k) => values[b + k] - values[a + k]));
    return span > 0 ? apart / span : 0;
  }

  fastest() {
    if (this.fastestRows === this.track.rows) return this.fastestFound;
    let most = 1e-3;
    for (const { first } of this.data.robots) {
      for (let row = 1; row < this.track.rows; ++row) {
        most = Math.max(most, this.speed(first, row) || 0);
      }
    }
    [this.fastestRows, this.fastestFound] = [this.track.rows, most];
    return most;
  }

  addGoal() {
    const arm = 0.25 * this.size;
    const goal = new THREE.Group();
    for (const axis of [[1, 0, 0], [0, 1, 0], [0, 0, 1]]) {
      const one = stick(GOAL_COLOR, 0.06 * arm);
      one.castShadow = false;
      const end = new THREE.Vector3(...axis).multiplyScalar(arm);
      between(one, end.clone().negate(), end);
      goal.add(one);
    }
    this.group.add(goal);
    return goal;
  }

  /** The ring about the first body while something touches. */
  addTouch() {
    const ring = new THREE.TorusGeometry(1.15 * this.size, 0.05 * this.size, 8, 40);
    const touch = new THREE.Mesh(ring, new THREE.MeshBasicMaterial({ color: TOUCH_COLOR }));
    this.group.add(touch);
    return touch;
  }

  /** Radius of the largest body with its rotors, at least 0.05 [m]. */
  sizeOf() {
    const far = [0.05];
    for (const r of this.data.rotors) far.push(Math.hypot(...r.position) + r.radius);
    for (const s of this.data.shapes) {
      if (s.kind !== "plane") far.push(Math.max(...s.half) + Math.hypot(...s.position));
    }
    return Math.max(...far);
  }
}
