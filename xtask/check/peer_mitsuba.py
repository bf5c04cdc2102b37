"""Draws the hair that renderers are compared by with Mitsuba 3: peer_mitsuba.py CURVES.txt SAMPLES"""
import os
import resource
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
look_at = mi.ScalarTransform4f().look_at
middle, up = [0, 0, 15], [0, 0, 1]
scene = mi.load_dict({
    "type": "scene",
    # Five events: order 4.
    "integrator": {"type": "path", "max_depth": 6, "rr_depth": 1000},
    "sensor": {
        "type": "perspective", "fov": 36, "to_world": look_at(origin=[0, -48, 15], target=middle, up=up),
        "film": {"type": "hdrfilm", "width": 256, "height": 256, "rfilter": {"type": "box"}},
        "sampler": {"type": "independent"},
    },
    "sky": {"type": "constant", "radiance": {"type": "rgb", "value": 0.3}},
    "lamp": {
        "type": "rectangle",
        "to_world": look_at(origin=[20, -30, 45], target=middle, up=up) @ mi.ScalarTransform4f().scale(6),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 20}},
    },
    "hair": {
        "type": "bsplinecurve", "filename": os.path.abspath(sys.argv[1]),
        "bsdf": {
            "type": "hair", "int_ior": 1.55, "longitudinal_roughness": 0.3, "azimuthal_roughness": 0.3,
            "scale_tilt": 3.0, "sigma_a": {"type": "rgb", "value": [0.06, 0.10, 0.20]},
        },
    },
})


def seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


begun = seconds()
picture = np.array(mi.render(scene, spp=int(sys.argv[2]), seed=1))[..., :3]
print(f"cpu_seconds {seconds() - begun:.3f}")
print("mean", *(f"{x:.5f}" for x in picture.mean(axis=(0, 1))))
print(f"memory_mib {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f}")
