// The writers behind export_pieces(), one per format. Internal: include io/export.h instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fracture/base/error.h"
#include "fracture/io/export.h"
#include "fracture/io/piece_surface.h"

namespace brittle::fracture {

struct OutputFile {
    std::string suffix; // appended to the stem: "" for the file itself, ".mtl", "_base.png"
    std::vector<std::byte> bytes;
};

// The content of one exported file.
struct ExportJob {
    const Fragments& fragments;
    const Certificate& certificate;
    const ExportOptions& options;
    std::span<const uint32_t> pieces;      // indices into Fragments::pieces
    std::string stem;                      // of the file name, for the names of files beside it
    const TriangleTree* outside;           // of the source's mesh, for rough cuts; else null
    std::span<const glm::vec4> tangents{}; // of the source's corners; GLB only
};

// Checks that lists with one entry per piece are complete, that poses are valid, and that no piece would be written with
// a negative mass.
[[nodiscard]] Result<void> check_export(const Fragments& fragments, const ExportOptions& options);

// The tree of ExportJob::outside; nothing where it is not needed.
[[nodiscard]] std::optional<TriangleTree> outside_of(const ExportOptions& options);

// The name of a piece: NAME_000, ...
[[nodiscard]] std::string piece_name(const ExportOptions& options, uint32_t piece);

// How to draw the surface of the pieces.
[[nodiscard]] SurfaceSettings surface_settings(const ExportJob& job);

// A point and a direction of a piece after its pose, if it has one.
[[nodiscard]] glm::dvec3 placed(const ExportJob& job, uint32_t piece, const glm::dvec3& point);
[[nodiscard]] glm::vec3 turned(const ExportJob& job, uint32_t piece, const glm::vec3& direction);

// The material of the cuts: that of the options, or the default.
[[nodiscard]] Material interior_material(const ExportOptions& options);
// The material for parts of the exterior without a source material.
[[nodiscard]] Material exterior_material(const ExportOptions& options);

// The ending of a file for an image, and the suffix of the file for image `index` of the source.
[[nodiscard]] std::string image_ending(const Image& image);
[[nodiscard]] std::string image_suffix(uint32_t index, const Image& image);

// All return the files to write, in order; the file that refers to the others is the last one.
[[nodiscard]] Result<std::vector<OutputFile>> write_glb(const ExportJob& job);
[[nodiscard]] Result<std::vector<OutputFile>> write_obj(const ExportJob& job);
[[nodiscard]] Result<std::vector<OutputFile>> write_ply(const ExportJob& job);
[[nodiscard]] Result<std::vector<OutputFile>> write_stl(const ExportJob& job);

} // namespace brittle::fracture
