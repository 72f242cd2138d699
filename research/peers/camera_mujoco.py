"""MuJoCo: frames of depth and geometries of many vehicles, rendered by Mesa on the processor.

    python camera_mujoco.py --scene FILE [--gl egl|osmesa] [--seconds S] [--trials T] [--quick]

Two processes; each draws all its worlds with one OpenGL context, without shadows, textures and
multisampling. Two ways: mujoco.Renderer, which draws a frame for the depth and one for the
segmentation, and its functions in C called from Python, one frame for both.
"""

from __future__ import annotations

import functools
import os
import sys

if "--gl" in sys.argv:
    os.environ["MUJOCO_GL"] = sys.argv[sys.argv.index("--gl") + 1]
os.environ.setdefault("MUJOCO_GL", "egl")
os.environ["LP_NUM_THREADS"] = "0"  # of Mesa, in each process; tried: 0, 1, 2

import camera_scene
import measure
import mujoco
import numpy as np
import processes
import vehicle
from camera_scene import Scene

NEAR = 0.01  # [m]
DIFFERS = "no contact; no rotor lag; no reward, ends or resets; thrusts as commands"
LOOK = 'xyaxes="0 -1 0 0 0 1"'  # forward
SEGMENTATION = (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR)
OFF = (
    *(mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION),
    *(mujoco.mjtRndFlag.mjRND_SKYBOX, mujoco.mjtRndFlag.mjRND_HAZE),
)


def geom(shape: dict) -> str:
    """A shape in MJCF, whose sizes are halves, except radii."""
    size = shape["size"]
    if shape["kind"] == "box":
        size = [0.5 * x for x in size]
    elif len(size) > 1:
        size = [size[0], 0.5 * size[1]]
    numbers = {"size": size, "pos": shape["position"], "quat": shape["rotation"]}
    words = " ".join(f'{name}="{vehicle.words(x)}"' for name, x in numbers.items())
    return f'<geom type="{shape["kind"]}" {words}/>'


def model_of(scene: Scene) -> mujoco.MjModel:
    """The world of one environment: the ground is geometry 0, the shapes follow."""
    shapes = "".join(map(geom, scene.shapes))
    place = vehicle.words(tuple(scene.camera))
    camera = f'<camera name="front" pos="{place}" fovy="{scene.field_of_view}" {LOOK}/>'
    visual = f"""<statistic extent="1"/><visual>
      <global offwidth="{scene.pixels}" offheight="{scene.pixels}"/>
      <quality offsamples="0" shadowsize="0"/>
      <map znear="{NEAR}" zfar="{scene.farthest}"/></visual>"""
    text = vehicle.mjcf()
    text = text.replace("<worldbody>", f'<worldbody><geom type="plane" size="90 90 1"/>{shapes}')
    text = text.replace("<freejoint/>", f"<freejoint/>{camera}")
    return mujoco.MjModel.from_xml_string(text.replace("<option", f"{visual}<option"))


class Worlds:
    """A process's environments."""

    def __init__(self, scene: Scene, poses: processes.Array) -> None:
        self.scene, self.model = scene, model_of(scene)
        self.instances = scene.instances()
        self.data = [mujoco.MjData(self.model) for _ in poses]
        for data, pose in zip(self.data, poses, strict=True):
            data.qpos[:] = pose
            mujoco.mj_forward(self.model, data)

    def step(self, commands: processes.Array, states: processes.Array) -> None:
        """Physics, then an image of each world: depth [m] and instance."""
        for data, command, images in zip(self.data, commands, states, strict=True):
            data.ctrl[:] = command
            mujoco.mj_step(self.model, data, self.scene.substeps)
            mujoco.mj_camlight(self.model, data)
            self.draw(data, images)

    def draw(self, data: mujoco.MjData, images: processes.Array) -> None:
        raise NotImplementedError


class TwoPasses(Worlds):
    """By mujoco.Renderer."""

    def __init__(self, scene: Scene, poses: processes.Array) -> None:
        super().__init__(scene, poses)
        self.renderer = mujoco.Renderer(self.model, scene.pixels, scene.pixels)
        for flag in OFF:
            self.renderer.scene.flags[flag] = False

    def draw(self, data: mujoco.MjData, images: processes.Array) -> None:
        self.renderer.update_scene(data, 0)
        self.renderer.enable_depth_rendering()
        images[0] = self.renderer.render()
        self.renderer.enable_segmentation_rendering()
        numbers = self.renderer.render()[:, :, 0]
        images[1] = np.where(numbers < 0, 0.0, self.instances[numbers])


class OnePass(Worlds):
    """By the functions that mujoco.Renderer calls: colours are the geometries' numbers."""

    def __init__(self, scene: Scene, poses: processes.Array) -> None:
        super().__init__(scene, poses)
        self.gl = mujoco.GLContext(scene.pixels, scene.pixels)
        self.gl.make_current()
        self.context = mujoco.MjrContext(self.model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self.context)
        self.context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self.seen = mujoco.MjvScene(self.model, 1000)
        for flag in OFF:
            self.seen.flags[flag] = False
        for flag in SEGMENTATION:
            self.seen.flags[flag] = True
        self.options, self.camera = mujoco.MjvOption(), mujoco.MjvCamera()
        self.camera.fixedcamid, self.camera.type = 0, mujoco.mjtCamera.mjCAMERA_FIXED
        self.rectangle = mujoco.MjrRect(0, 0, scene.pixels, scene.pixels)
        self.colors = np.empty((scene.pixels, scene.pixels, 3), np.uint8)
        self.depth = np.empty((scene.pixels, scene.pixels), np.float32)
        # Of the colours: nothing, then the geometries in the order of the model.
        self.numbers = np.concatenate([[0.0], self.instances])

    def draw(self, data: mujoco.MjData, images: processes.Array) -> None:
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(
            self.model, data, self.options, None, self.camera, everything, self.seen
        )
        mujoco.mjr_render(self.rectangle, self.seen, self.context)
        mujoco.mjr_readPixels(self.colors, self.depth, self.rectangle, self.context)
        far = self.scene.farthest  # depths are 1 at NEAR and 0 at `far`
        images[0] = NEAR * far / (NEAR + self.depth[::-1] * (far - NEAR))
        images[1] = self.numbers[self.colors[::-1, :, 0]]


def main() -> None:
    effort, scene, options = camera_scene.read(__doc__)
    measure.use_cores(camera_scene.CORES)
    version = mujoco.__version__
    peer = measure.Peer("MuJoCo", version, f"MuJoCo {version}", DIFFERS)
    for make, way in (
        (TwoPasses, "mujoco.Renderer, two passes"),
        (OnePass, "mjr_render, one pass"),
    ):
        mode = f"{way}, {options.gl}, 2 processes"
        peer.attempt(mode, functools.partial(camera_scene.row, peer, effort, scene, make, mode))


if __name__ == "__main__":
    main()
