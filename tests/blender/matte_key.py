"""Keys objects of a multi-layer EXR with the Cryptomatte node of Blender's compositor.

    blender -b --factory-startup -P matte_key.py -- IMAGE WIDTH HEIGHT OUTPUT LAYER NAME

Prints "pass NAME" for every output that an image node of IMAGE has, and writes the matte of NAME in LAYER (CryptoObject) as OUTPUT, a
float EXR whose R is the matte.
"""

import sys

import bpy

path, width, height, output, layer, name = sys.argv[sys.argv.index("--") + 1:]
scene = bpy.context.scene
image = bpy.data.images.load(path)
scene.use_nodes = True
nodes = scene.node_tree.nodes
nodes.clear()
shown = nodes.new("CompositorNodeImage")
shown.image = image
for socket in shown.outputs:
    print("pass", socket.name)

key = nodes.new("CompositorNodeCryptomatteV2")
key.source = "IMAGE"
key.image = image
key.layer_name = layer
key.matte_id = name
composite = nodes.new("CompositorNodeComposite")
composite.use_alpha = False
scene.node_tree.links.new(key.outputs["Matte"], composite.inputs["Image"])

scene.render.resolution_x, scene.render.resolution_y = int(width), int(height)  # an image of several layers does not tell
scene.render.resolution_percentage = 100
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.image_settings.color_mode = "RGB"
scene.render.filepath = output
bpy.ops.render.render(write_still=True)
