// The writers behind export_pieces, one a format. Internal: include io/export.h instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/export.h"

namespace brittle::fracture {

struct OutputFile {
    std::string suffix; // of the name: "" for the file itself, or such as ".mtl", "_base.png"
    std::vector<std::byte> bytes;
};

// What goes into one file.
struct ExportJob {
    const Fragments& fragments;
    const Certificate& certificate;
    const ExportOptions& options;
    std::span<const uint32_t> pieces; // of the fragments
    std::string stem;                 // of the file, for names of files beside it
};

// NAME_000, ...
[[nodiscard]] std::string piece_name(const ExportOptions& options, uint32_t piece);

// Where a point and a direction of a piece come to by its pose, if it has one.
[[nodiscard]] glm::dvec3 placed(const ExportJob& job, uint32_t piece, const glm::dvec3& point);
[[nodiscard]] glm::vec3 turned(const ExportJob& job, uint32_t piece, const glm::vec3& direction);

// The material of the cuts: what the options say, or the default.
[[nodiscard]] Material interior_material(const ExportOptions& options);
// For parts of the exterior that have none.
[[nodiscard]] Material exterior_material(const ExportOptions& options);

// All give files to be written in their order, the one that names the others last.
[[nodiscard]] Result<std::vector<OutputFile>> write_glb(const ExportJob& job);
[[nodiscard]] Result<std::vector<OutputFile>> write_obj(const ExportJob& job);
[[nodiscard]] Result<std::vector<OutputFile>> write_ply(const ExportJob& job);
[[nodiscard]] Result<std::vector<OutputFile>> write_stl(const ExportJob& job);

} // namespace brittle::fracture
