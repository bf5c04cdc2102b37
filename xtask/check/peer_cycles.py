"""Draws the hair that renderers are compared by with Blender's Cycles: peer_cycles.py CURVES.txt SAMPLES"""
import math
import os
import resource
import sys
import tempfile

import bpy
import numpy as np
from mathutils import Vector

# Cycles draws curves through their points: where the B-spline passes.
with open(sys.argv[1]) as file:
    blocks = [np.array([line.split() for line in block.splitlines()], float)
              for block in file.read().strip().split("\n\n")]
strands = [(b[:-2, :3] + 4 * b[1:-1, :3] + b[2:, :3]) / 6 for b in blocks]
radius = blocks[0][0, 3]

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
curves = bpy.data.hair_curves.new("hair")
curves.add_curves([len(strand) for strand in strands])
points = np.concatenate(strands).astype(np.float32)
curves.attributes["position"].data.foreach_set("vector", points.ravel())
radii = curves.attributes.get("radius") or curves.attributes.new("radius", "FLOAT", "POINT")
radii.data.foreach_set("value", np.full(len(points), radius, np.float32))
scene.collection.objects.link(bpy.data.objects.new("hair", curves))

material = bpy.data.materials.new("hair")
if not material.node_tree:
    material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
output, hair = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfHairPrincipled")
hair.model, hair.parametrization = "CHIANG", "ABSORPTION"
values = {"Absorption Coefficient": (0.06, 0.10, 0.20), "Roughness": 0.3, "Radial Roughness": 0.3,
          "IOR": 1.55, "Offset": math.radians(3), "Random Roughness": 0}
for socket in hair.inputs:
    if socket.name in values:
        socket.default_value = values[socket.name]
material.node_tree.links.new(hair.outputs[0], output.inputs["Surface"])
curves.materials.append(material)


def placed(name, data, at):
    thing = bpy.data.objects.new(name, data)
    thing.location = at
    thing.rotation_euler = (Vector((0, 0, 15)) - Vector(at)).to_track_quat("-Z", "Y").to_euler()
    scene.collection.objects.link(thing)
    return thing


camera = bpy.data.cameras.new("camera")
camera.angle = math.radians(36)
scene.camera = placed("camera", camera, (0, -48, 15))
lamp = bpy.data.lights.new("lamp", "AREA")
# Power of a square of 12 by 12 with the radiance 20.
lamp.size, lamp.energy = 12, 20 * 144 * math.pi
placed("lamp", lamp, (20, -30, 45))
scene.world = bpy.data.worlds.new("sky")
if not scene.world.node_tree:
    scene.world.use_nodes = True
sky = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
sky.inputs[0].default_value, sky.inputs[1].default_value = (0.3, 0.3, 0.3, 1), 1

scene.render.engine = "CYCLES"
cycles = scene.cycles
cycles.device, cycles.samples = "CPU", int(sys.argv[2])
cycles.use_adaptive_sampling = cycles.use_denoising = False
for bounces in ["max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces"]:
    setattr(cycles, bounces, 5)
cycles.sample_clamp_indirect, cycles.pixel_filter_type = 0, "BOX"
scene.cycles_curves.shape, scene.cycles_curves.subdivisions = "THICK", 2
render = scene.render
render.resolution_x = render.resolution_y = 256
render.resolution_percentage = 100
scene.view_settings.view_transform, render.image_settings.file_format = "Raw", "OPEN_EXR"
render.filepath = os.path.join(tempfile.mkdtemp(), "picture.exr")


def seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


begun = seconds()
bpy.ops.render.render(write_still=True)
print(f"cpu_seconds {seconds() - begun:.3f}")
picture = np.array(bpy.data.images.load(render.filepath).pixels[:]).reshape(-1, 4)[:, :3]
print("mean", *(f"{x:.5f}" for x in picture.mean(axis=0)))
print(f"memory_mib {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f}")
