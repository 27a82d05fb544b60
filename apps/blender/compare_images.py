"""Compares images with a reference: relative mean squared error, and the difference as a picture.

    blender -b -noaudio --factory-startup --python-exit-code 1 --python compare_images.py -- REFERENCE.exr OUT.png NAME=IMAGE.exr...

relMSE = mean over the pixels that the reference or the image lights, and channels, of
(image - reference)^2 / (reference^2 + 0.01 mean(reference)^2). OUT.png: the
reference, then for each image the image itself and under it its difference, grey 0.5 + 2 (image - reference) / scale, where
scale is the 99th percentile of the reference. Also prints relMSE after a 4 x 4 box filter, which noise hardly touches.
Needs numpy and an EXR reader: Blender has both.
"""

import sys

import bpy
import numpy


def load(path):
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Raw" if "Raw" in [c.name for c in image.colorspace_settings.bl_rna.properties["name"].enum_items] else "Non-Color"
    pixels = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(pixels)
    width, height = image.size
    return pixels.reshape(height, width, -1)[..., :3].astype(numpy.float64)


def relative_error(image, reference):
    lit = (reference + image).sum(2) > 0
    floor = 0.01 * numpy.mean(reference[lit]) ** 2
    return float(numpy.mean((image[lit] - reference[lit]) ** 2 / (reference[lit] ** 2 + floor)))


def box(image, size=4):
    height, width = image.shape[0] // size * size, image.shape[1] // size * size
    return image[:height, :width].reshape(height // size, size, width // size, size, 3).mean((1, 3))


def save(path, picture):
    height, width = picture.shape[:2]
    image = bpy.data.images.new("comparison", width, height)
    srgb = numpy.where(picture <= 0.0031308, 12.92 * picture, 1.055 * numpy.clip(picture, 1e-9, None) ** (1 / 2.4) - 0.055)
    rgba = numpy.ones((height, width, 4), numpy.float32)
    rgba[..., :3] = numpy.clip(srgb, 0, 1)
    image.pixels.foreach_set(rgba.ravel())
    image.filepath_raw, image.file_format = path, "PNG"
    image.save()


def main():
    words = sys.argv[sys.argv.index("--") + 1 :]
    reference = load(words[0])
    scale = numpy.percentile(reference, 99)
    columns = [numpy.concatenate([numpy.full_like(reference, 0.05), reference / scale], 0)]  # rows run upwards
    for word in words[2:]:
        name, path = word.split("=", 1)
        image = load(path)
        assert image.shape == reference.shape, (name, image.shape, reference.shape)
        print(f"relMSE {name} {relative_error(image, reference):.6g} filtered {relative_error(box(image), box(reference)):.6g}")
        difference = 0.5 + 2 * (image - reference) / scale
        grey = numpy.clip(difference, 0, 1) ** 2.2  # so that 0.5 is mid grey on screen
        columns.append(numpy.concatenate([grey, image / scale], 0))
    save(words[1], numpy.concatenate(columns, 1))


main()
