// What files of pieces contain: options of `brittle fracture`, of --export of `brittle render`, and the "export" of a
// recipe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace brittle::tools {

struct ExportSettings {
    std::string output{}; // file whose ending gives the format; empty: no export. A recipe does not keep it
    std::string stream{}; // format of one file in memory, in place of `output`: "glb", "obj", "ply" or "stl"; or empty
    std::string name{};   // of the root node, and the start of each piece's name; empty: the name of the mesh
    bool per_piece = false; // one file per piece
    bool one_file = false;  // one file for all pieces, also in a format that does not tell them apart
    std::string hulls{}; // "godot" or "unreal": the engine that makes bodies of the pieces by their names; may be empty
    bool rigid_bodies = false;
    uint32_t hull_parts = 0;        // at most, of one piece, for unreal and rigid_bodies; 0: the default
    double density = 0.0;           // kg/m^3, for rigid_bodies; 0: the material's
    std::string interior_texture{}; // image file for the cut faces; empty: none
    std::string as = "lie";         // lie or made: pose of the pieces at the end of a run (pieces_as())
};

inline constexpr uint32_t max_hull_parts = 256; // of ExportSettings::hull_parts
inline constexpr double max_density = 1e300;    // kg/m^3, of ExportSettings::density
inline constexpr size_t max_name_bytes = 200;   // of ExportSettings::name

// Returns what is wrong with a name for pieces: control characters, more than max_name_bytes, bytes that are not UTF-8.
// Empty where nothing is.
[[nodiscard]] std::string refusal_of_name(const std::string& name);

} // namespace brittle::tools
