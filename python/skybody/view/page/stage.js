// The 3-D view: sky, ground, light, cameras, one view or several side by side.
import * as THREE from "three";
import { OrbitControls } from "three/OrbitControls.js";

export const VIEWS = ["orbit", "follow", "onboard"];

const SKY = 0xe6ebf1;
const FORWARD_UP = new THREE.Quaternion().setFromRotationMatrix(
  new THREE.Matrix4().makeBasis(
    new THREE.Vector3(0, -1, 0), // right of the picture: -y of the body
    new THREE.Vector3(0, 0, 1),
    new THREE.Vector3(-1, 0, 0), // a camera looks along its -z: x of the body
  ),
);

/** A ground of squares of one metre. */
function groundOf() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 128;
  const context = canvas.getContext("2d");
  context.fillStyle = "#d2d6d8"; // the floor of films
  context.fillRect(0, 0, 128, 128);
  context.fillStyle = "#c1c6c8";
  context.fillRect(0, 0, 64, 64);
  context.fillRect(64, 64, 64, 64);
  const texture = new THREE.CanvasTexture(canvas);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.repeat.set(100, 100);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.anisotropy = 8;
  const ground = new THREE.Mesh(
    new THREE.PlaneGeometry(200, 200),
    new THREE.MeshStandardMaterial({ map: texture, roughness: 1 }),
  );
  ground.receiveShadow = true;
  return ground;
}

/** The view and its cameras. */
export class Stage {
  /**
   * @param {HTMLElement} place
   * @param {import("./world.js").World[]} worlds one a flight
   */
  constructor(place, worlds) {
    this.place = place;
    this.worlds = worlds;
    this.view = "orbit";
    this.followed = { world: 0, robot: 0 };
    this.apart = false; // flights side by side
    this.shown = worlds.map(() => true);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(SKY);
    this.scene.fog = new THREE.Fog(SKY, 40, 120);
    this.scene.add(groundOf(), new THREE.HemisphereLight(0xffffff, 0x8b8f86, 1.6));
    this.sun = this.sunOf();
    for (const world of worlds) this.scene.add(world.group);
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    place.append(this.renderer.domElement);
    this.camera = new THREE.PerspectiveCamera(50, 1, 0.01, 400);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.target = new THREE.Vector3(); // of the last frame, in the view that follows
    new ResizeObserver(() => this.resize()).observe(place);
    this.resize();
    this.home();
  }

  /** Places the eye so that the whole flight is seen. */
  home() {
    const world = this.worlds[this.followed.world];
    const { middle, radius } = world.sphere();
    const away = 4 * world.size + 2 * radius;
    const azimuth = (-125 * Math.PI) / 180;
    this.controls.target.copy(middle);
    this.camera.position
      .set(Math.cos(azimuth) * 0.9, Math.sin(azimuth) * 0.9, 0.45)
      .multiplyScalar(away)
      .add(middle);
    this.target.copy(middle);
    this.camera.near = Math.max(0.005, 0.05 * world.size);
    this.camera.updateProjectionMatrix();
  }

  /** Chooses one of VIEWS. */
  setView(view) {
    const leaves = this.view === "onboard" && view !== "onboard";
    this.view = view;
    this.controls.enabled = view !== "onboard";
    if (leaves) this.home();
    if (view === "follow") this.comeNear();
    this.target.copy(this.followedPlace());
  }

  /** Draws a frame. */
  draw() {
    this.moveCamera();
    const visible = this.worlds.filter((_, k) => this.shown[k]);
    const cells = this.apart && visible.length > 1 ? visible.map((world) => [world]) : [visible];
    const columns = Math.ceil(Math.sqrt(cells.length));
    const rows = Math.ceil(cells.length / columns);
    const [width, height] = [this.width / columns, this.height / rows];
    this.renderer.setScissorTest(cells.length > 1);
    cells.forEach((cell, k) => {
      for (const world of this.worlds) world.group.visible = cell.includes(world);
      const left = (k % columns) * width;
      const bottom = this.height - (Math.floor(k / columns) + 1) * height;
      this.renderer.setViewport(left, bottom, width, height);
      this.renderer.setScissor(left, bottom, width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      if (this.view === "onboard") this.board(cell[0] ?? this.worlds[0]);
      this.lightFrom(cell[0] ?? this.worlds[0]);
      this.renderer.render(this.scene, this.camera);
    });
  }

  /** Position and body under a point of the page, or null. */
  pick(x, y) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(
      (2 * (x - box.left)) / box.width - 1,
      1 - (2 * (y - box.top)) / box.height,
    );
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const hits = ray.intersectObjects(this.worlds[0].bodies, true);
    if (hits.length > 0) return { body: this.bodyOf(hits[0].object), point: hits[0].point, ray };
    return { body: null, point: null, ray };
  }

  /** The point of the page (0 to 1 from the left and the top of the view) where a body is seen. */
  seen(body) {
    const at = this.worlds[0].bodies[body].position.clone().project(this.camera);
    return [0.5 * (at.x + 1), 0.5 * (1 - at.y)];
  }

  // --- parts --------------------------------------------------------------------------------------

  bodyOf(object) {
    for (let one = object; one !== null; one = one.parent) {
      const found = this.worlds[0].bodies.indexOf(one);
      if (found >= 0) return found;
    }
    return null;
  }

  sunOf() {
    const sun = new THREE.DirectionalLight(0xfff4e0, 2.2);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    this.scene.add(sun, sun.target);
    return sun;
  }

  /** Shadows are sharp about the robots of a world. */
  lightFrom(world) {
    world.center(this.sun.target.position);
    this.sun.position.copy(this.sun.target.position).add(new THREE.Vector3(-6, -4, 12));
    const half = Math.min(4 * world.size + world.sphere().radius, 20);
    const camera = this.sun.shadow.camera;
    if (camera.right === half) return;
    [camera.left, camera.right, camera.bottom, camera.top] = [-half, half, -half, half];
    [camera.near, camera.far] = [0.5, 40];
    camera.updateProjectionMatrix();
  }

  followedPlace() {
    const world = this.worlds[this.followed.world];
    return world.bodies[world.data.robots[this.followed.robot].first].position;
  }

  comeNear() {
    const world = this.worlds[this.followed.world];
    const toEye = this.camera.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(this.followedPlace());
    this.camera.position.copy(this.controls.target).addScaledVector(toEye, 9 * world.size);
  }

  moveCamera() {
    if (this.view === "follow") {
      const place = this.followedPlace();
      this.camera.position.add(place).sub(this.target);
      this.controls.target.copy(place);
      this.target.copy(place);
    }
    if (this.view !== "onboard") this.controls.update();
  }

  board(world) {
    const robot = world.data.robots[Math.min(this.followed.robot, world.data.robots.length - 1)];
    const body = world.bodies[robot.first];
    const above = new THREE.Vector3(0, 0, 0.45 * world.size).applyQuaternion(body.quaternion);
    this.camera.position.copy(body.position).add(above);
    this.camera.quaternion.copy(body.quaternion).multiply(FORWARD_UP);
  }

  resize() {
    this.width = Math.max(this.place.clientWidth, 1);
    this.height = Math.max(this.place.clientHeight, 1);
    this.renderer.setSize(this.width, this.height);
  }
}
