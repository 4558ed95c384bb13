"""Renders a frame of Meniscus, exported as OBJ, with the path tracer of Blender 3.4 or newer:

    meniscus export out/my-scene --to obj --frames 4:4 --scale 100 --wetted sink --out blend
    blender --background --python docs/into-blender.py -- blend/liquid_0004.obj picture.png
"""

import math
import pathlib
import sys

import bpy
from mathutils import Vector

liquid, picture = (pathlib.Path(a).resolve() for a in sys.argv[sys.argv.index("--") + 1 :][:2])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def load(path, name, **inputs):
    """An OBJ file, smooth, with a material of these inputs of the principled shader."""
    bpy.ops.wm.obj_import(filepath=str(path), forward_axis="Y", up_axis="Z")
    thing = bpy.context.selected_objects[0]
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    for key, value in inputs.items():
        names = [n for n in shader.inputs.keys() if n.lower().replace(" ", "_").startswith(key)]
        shader.inputs[names[0]].default_value = value
    thing.data.materials.clear()
    thing.data.materials.append(material)
    return thing


water = load(liquid, "water", base_color=(0.9, 0.97, 1, 1), transmission=1, ior=1.33, roughness=0)
bpy.ops.object.shade_smooth()
# Light passes through water to what lies below it, without the noise of caustics.
tree = water.active_material.node_tree
new, link = tree.nodes.new, tree.links.new
rays, clear, mix = new("ShaderNodeLightPath"), new("ShaderNodeBsdfTransparent"), new("ShaderNodeMixShader")
clear.inputs[0].default_value = (0.85, 0.94, 1, 1)
link(rays.outputs["Is Shadow Ray"], mix.inputs[0])
link(tree.nodes["Principled BSDF"].outputs[0], mix.inputs[1])
link(clear.outputs[0], mix.inputs[2])
link(mix.outputs[0], tree.nodes["Material Output"].inputs[0])
for path in sorted(liquid.parent.glob(liquid.name.replace("liquid", "solid_*"))):
    load(path, path.stem, base_color=(0.18, 0.1, 0.06, 1), roughness=0.6)

corners = [Vector(corner) for corner in water.bound_box]
low, high = (Vector([f(c[a] for c in corners) for a in range(3)]) for f in (min, max))
middle, size = (low + high) / 2, (high - low).length
sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
sun.data.energy, sun.data.angle, sun.rotation_euler = 4, 0.2, (0.7, 0.1, 0.6)
eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
eye.data.lens = 60
eye.location = middle + size * Vector((1.6, -2.6, 1.3))
eye.rotation_euler = (middle - eye.location).to_track_quat("-Z", "Y").to_euler()
for thing in (sun, eye):
    scene.collection.objects.link(thing)
scene.world = bpy.data.worlds.new("sky")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs[0].default_value = (0.75, 0.82, 0.9, 1)

scene.camera, scene.render.engine, scene.render.filepath = eye, "CYCLES", str(picture)
scene.render.resolution_x, scene.render.resolution_y = 800, 500
scene.cycles.samples, scene.cycles.use_denoising = 200, False
scene.view_settings.view_transform = "Standard"
if picture.suffix.lower() in (".jpg", ".jpeg"):
    scene.render.image_settings.file_format = "JPEG"
bpy.ops.render.render(write_still=True)
