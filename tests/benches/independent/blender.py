"""Draws glb files with Blender's importer and Cycles.

  PY blender.py WORK NAME...

PY is a Python with `bpy`; WORK/NAME.glb becomes WORK/NAME.cycles.exr: linear radiance.
"""
import json, math, os, sys

import bpy
from mathutils import Vector

work, names = sys.argv[1], sys.argv[2:]
setting = json.load(open(os.path.join(work, "scene.json")))["scene"]


def blender(v):
    """A point of glTF, +Y up, in Blender's axes, +Z up: what its importer does."""
    return Vector((v[0], -v[2], v[1]))


def environment(scene):
    scene.world = bpy.data.worlds.new("environment")
    scene.world.use_nodes = True
    nodes = scene.world.node_tree.nodes
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(os.path.join(work, "environment-quarter.exr"))
    scene.world.node_tree.links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])


def camera(scene):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle, data.clip_start = "VERTICAL", math.radians(setting["fov_deg"]), 0.01
    scene.camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(scene.camera)
    scene.camera.location = blender(setting["origin"])
    forward = blender(setting["target"]) - scene.camera.location
    scene.camera.rotation_euler = forward.to_track_quat("-Z", "Y").to_euler()


def draw(name):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.join(work, f"{name}.glb"))
    scene = bpy.context.scene
    environment(scene)
    camera(scene)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = setting["spp"], False, False
    scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.render.resolution_x = scene.render.resolution_y = setting["size"]
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"
    scene.render.filepath = os.path.join(work, f"{name}.cycles.exr")
    bpy.ops.render.render(write_still=True)
    print(f"Cycles: {name}", file=sys.stderr, flush=True)


for name in names:
    draw(name)
