// What a glTF file has that pieces do not keep. Internal to read_gltf().
#pragma once

#include <string>

#include "fracture/io/gltf_document.h"

namespace brittle::fracture::gltf {

// Returns one sentence with the number of skins, animations, morph targets, tangents, further attributes, points and
// lines, instances, cameras and lights of the file; empty if it has none. The whole file counts, not only its default
// scene.
[[nodiscard]] std::string left_out(const Json& document);

// Returns why a file with this extension is refused and how to convert the file, or an empty text for an extension that
// the converter does not undo.
[[nodiscard]] std::string compression_refusal(const std::string& extension);

} // namespace brittle::fracture::gltf
