// Reads the materials, textures and images of a glTF document.
#pragma once

#include "fracture/io/gltf_document.h"
#include "fracture/io/model.h"

namespace brittle::fracture::gltf {

// Fills materials, textures and images of the model, with the indices of the document. A fault in one of them gives a
// note, not an error.
void read_materials(Document& document, Model& model);

} // namespace brittle::fracture::gltf
