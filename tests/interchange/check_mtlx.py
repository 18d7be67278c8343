"""Opens MaterialX files with the reference library: they must be valid, use only what it defines, and become shader code.

Usage: check_mtlx.py FILE...
Prints one JSON object: for each file its faults, and the length of the GLSL that was made of its first material.
"""

import json
import os
import sys

import MaterialX as mx
import MaterialX.PyMaterialXGenGlsl as glsl
import MaterialX.PyMaterialXGenShader as shader

library = mx.createDocument()
mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), library)


def faults_of(document, folder):
    is_valid, message = document.validate()
    if not is_valid:
        yield message
    if not document.getMaterialNodes():
        yield "there is no material"
    for element in document.traverseTree():
        if element.isA(mx.Node):
            definition = element.getNodeDef()
            if definition is None:
                # validate() says nothing about these.
                yield f"{element.getNamePath()}: nothing defines {element.getCategory()} of type {element.getType()}"
                continue
            for entry in element.getInputs():
                known = definition.getActiveInput(entry.getName())
                if known is None or known.getType() != entry.getType():
                    yield f"{entry.getNamePath()}: expected another input or type"
        if element.isA(mx.Input) and element.getType() == "filename":
            name = element.getResolvedValueString()
            if os.path.isabs(name) or not os.path.isfile(os.path.join(folder, name)):
                yield f"{element.getNamePath()}: no file {name}"


def code_of(document):
    generator = glsl.GlslShaderGenerator.create()
    context = shader.GenContext(generator)
    context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
    colors = shader.DefaultColorManagementSystem.create(generator.getTarget())
    colors.loadLibrary(library)
    generator.setColorManagementSystem(colors)
    whole = mx.createDocument()
    whole.importLibrary(library)
    whole.importLibrary(document)
    generator.registerTypeDefs(whole)
    node = mx.getShaderNodes(whole.getMaterialNodes()[0])[0]
    return generator.generate(node.getName(), node, context).getSourceCode("pixel")


report = {}
for path in sys.argv[1:]:
    document = mx.createDocument()
    mx.readFromXmlFile(document, path)
    document.setDataLibrary(library)
    faults = list(faults_of(document, os.path.dirname(os.path.abspath(path))))
    report[path] = {"faults": faults, "code": 0 if faults else len(code_of(document))}
json.dump(report, sys.stdout)
