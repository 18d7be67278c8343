"""Opens USD files with OpenUSD itself: every validator must accept them, and every material must show its three networks.

Usage: check_usd.py FILE...
Prints one JSON object: for each file its faults, and the values that OpenUSD reads of each input of each Adobe Standard Material.
"""

import json
import sys

from pxr import Usd, UsdShade, UsdValidation

ASM = "AdobeStandardMaterial_4_0"
# The wheel brings neither MaterialX's definitions nor Adobe's, so OpenUSD cannot know these shaders.
UNKNOWN_SHADERS = (ASM, "ND_")
NETWORKS = ("", "adobe", "mtlx")


def plain(value):
    return list(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def faults_of(stage):
    registry = UsdValidation.ValidationRegistry()
    for error in UsdValidation.ValidationContext(registry.GetOrLoadAllValidators()).Validate(stage):
        message = error.GetMessage()
        if error.GetName() == "MissingShaderIdInRegistry" and any(f"'{name}" in message for name in UNKNOWN_SHADERS):
            continue
        yield f"{error.GetName()}: {message}"
    materials = [UsdShade.Material(prim) for prim in stage.Traverse() if prim.IsA(UsdShade.Material)]
    if not materials:
        yield "there is no material"
    for material in materials:
        for network in NETWORKS:
            output = material.GetSurfaceOutput(network) if network else material.GetSurfaceOutput()
            if not (output and output.GetValueProducingAttributes()):
                yield f"{material.GetPath()}: nothing is connected to its output '{network}'"


def inputs_of(stage):
    found = {}
    for prim in stage.Traverse():
        shader = UsdShade.Shader(prim)
        if not prim.IsA(UsdShade.Shader) or shader.GetIdAttr().Get() != ASM:
            continue
        values = {}
        for entry in shader.GetInputs():
            producers = entry.GetValueProducingAttributes()
            values[entry.GetBaseName()] = plain(producers[0].Get()) if producers else None
        found[prim.GetParent().GetDisplayName() or prim.GetParent().GetName()] = values
    return found


report = {}
for path in sys.argv[1:]:
    stage = Usd.Stage.Open(path)
    report[path] = {"faults": list(faults_of(stage)), "inputs": inputs_of(stage)}
json.dump(report, sys.stdout)
