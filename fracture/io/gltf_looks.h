// Materials, textures and images of a glTF document.
#pragma once

#include "fracture/io/gltf_document.h"
#include "fracture/io/model.h"

namespace brittle::fracture::gltf {

// Indices of the document stay: materials, textures and images of the model are those of the file, one for one.
// Whatever is wrong with them is a note.
void read_looks(Document& document, Model& model);

} // namespace brittle::fracture::gltf
