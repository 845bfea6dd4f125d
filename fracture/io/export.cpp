#include "fracture/io/export.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>

#include "fracture/io/atomic_file.h"
#include "fracture/io/tangents.h"
#include "fracture/io/writers.h"

namespace brittle::fracture {

namespace {

constexpr double unit_slack = 1e-4; // of a quaternion's length: covers the rounding of single precision

using Files = std::vector<std::filesystem::path>;
using Writer = Result<std::vector<OutputFile>> (*)(const ExportJob&);

// Null for an unknown extension.
Writer writer_of(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (ending == ".glb") return &write_glb;
    if (ending == ".obj") return &write_obj;
    if (ending == ".ply") return &write_ply;
    if (ending == ".stl") return &write_stl;
    return nullptr;
}

Error unsupported(const std::filesystem::path& file) {
    const std::string ending = file.extension().string();
    std::string known;
    for (const std::string& one : exportable_extensions()) known += (known.empty() ? "" : ", ") + one;
    return Error{Status::unsupported_format,
                 file.string() + ": "
                     + (ending.empty() ? "the name has no extension" : ending + " files are not written")
                     + "; choose one of " + known};
}

// Checks that lists with one entry per piece are complete.
Result<void> check_lists(const Fragments& fragments, const ExportOptions& options) {
    const auto wrong = [&](size_t count, const char* what) {
        return Error{Status::invalid_setting, "there are " + std::to_string(count) + " " + what + " for "
                                                  + std::to_string(fragments.pieces.size()) + " pieces"};
    };
    if (!options.hulls.empty() && options.hulls.size() != fragments.pieces.size())
        return wrong(options.hulls.size(), "lists of hulls");
    if (!options.poses.empty() && options.poses.size() != fragments.pieces.size())
        return wrong(options.poses.size(), "poses");
    for (size_t p = 0; p < options.poses.size(); ++p) {
        const PiecePose& pose = options.poses[p];
        const double sum = pose.position.x + pose.position.y + pose.position.z, length = glm::length(pose.orientation);
        if (!std::isfinite(sum) || !(std::abs(length - 1.0) < unit_slack))
            return Error{Status::invalid_setting, "the pose of piece " + std::to_string(p)
                                                      + " is invalid: its position must be finite "
                                                        "and its orientation a unit quaternion"};
    }
    return {};
}

// Checks that no piece would be written with a negative mass.
Result<void> check_volumes(const Fragments& fragments) {
    for (size_t p = 0; p < fragments.pieces.size(); ++p) {
        const double volume = fragments.pieces[p].mass.volume;
        if (volume < 0.0)
            return Error{Status::inverted_part, "piece " + std::to_string(p) + " has a volume of "
                                                    + std::to_string(volume) + ", so it is not written"};
    }
    return {};
}

// Receives the content of each file under its path.
using Sink = std::function<Result<void>(const std::filesystem::path&, std::vector<std::byte>)>;

Result<void> make_files(const std::filesystem::path& file, Writer writer, const ExportJob& job, const Sink& sink) {
    Result<std::vector<OutputFile>> outputs = writer(job);
    if (!outputs) return Error{outputs.error().status, file.string() + ": " + outputs.error().message};
    for (OutputFile& output : *outputs) {
        const std::filesystem::path path =
            output.suffix.empty() ? file : file.parent_path() / (file.stem().string() + output.suffix);
        if (Result<void> done = sink(path, std::move(output.bytes)); !done) return done.error();
    }
    return {};
}

// Makes all files of an export. Returns those to open.
Result<Files> make_all(const std::filesystem::path& file, const Fragments& fragments, const Certificate& certificate,
                       const ExportOptions& options, const Sink& sink) {
    const Writer writer = writer_of(file);
    if (!writer) return unsupported(file);
    if (const Result<void> valid = check_lists(fragments, options); !valid) return valid.error();
    std::vector<uint32_t> pieces(fragments.pieces.size());
    std::iota(pieces.begin(), pieces.end(), 0u);
    Files made;
    const std::optional<TriangleTree> outside = outside_of(options);
    const TriangleTree* const tree = outside ? &*outside : nullptr;
    const std::vector<glm::vec4> tangents =
        writer == &write_glb && options.source ? corner_tangents(*options.source) : std::vector<glm::vec4>();
    if (!options.per_piece) {
        const ExportJob job{fragments, certificate, options, pieces, file.stem().string(), tree, tangents};
        if (Result<void> done = make_files(file, writer, job, sink); !done) return done.error();
        made.push_back(file);
    }
    for (size_t k = 0; options.per_piece && k < pieces.size(); ++k) {
        char number[16];
        std::snprintf(number, sizeof number, "_%03u", pieces[k]);
        const std::filesystem::path one =
            file.parent_path() / (file.stem().string() + number + file.extension().string());
        const ExportJob job{fragments,           certificate, options, std::span(pieces).subspan(k, 1),
                            one.stem().string(), tree,        tangents};
        if (Result<void> done = make_files(one, writer, job, sink); !done) return done.error();
        made.push_back(one);
    }
    return made;
}

Result<Files> write_pieces(const std::filesystem::path& file, const Fragments& fragments,
                           const Certificate& certificate, const ExportOptions& options) {
    std::vector<StagedFile> staged; // so that a full disk leaves none of several files behind
    const Result<Files> written = make_all(file, fragments, certificate, options,
                                           [&](const std::filesystem::path& path, std::vector<std::byte> bytes) {
                                               Result<StagedFile> one = StagedFile::write(path, bytes);
                                               if (!one) return Result<void>(one.error());
                                               staged.push_back(*std::move(one));
                                               return Result<void>();
                                           });
    if (!written) return written.error();
    for (StagedFile& one : staged)
        if (Result<void> done = one.commit(); !done) return done.error();
    return *written;
}

Result<std::vector<ExportedFile>> keep_pieces(const std::string& file, const Fragments& fragments,
                                              const Certificate& certificate, const ExportOptions& options) {
    std::vector<ExportedFile> all;
    const Result<Files> first = make_all(file, fragments, certificate, options,
                                         [&](const std::filesystem::path& path, std::vector<std::byte> bytes) {
                                             all.push_back({path.string(), std::move(bytes)});
                                             return Result<void>();
                                         });
    if (!first) return first.error();
    std::stable_partition(all.begin(), all.end(), [&](const ExportedFile& one) {
        return std::find(first->begin(), first->end(), std::filesystem::path(one.name)) != first->end();
    });
    return all;
}

// A model as one piece without interior.
Fragments whole_of(const Model& model) {
    Fragments whole;
    whole.positions = model.mesh.positions;
    whole.triangles = model.mesh.triangles;
    whole.vertex_point.resize(whole.positions.size());
    std::iota(whole.vertex_point.begin(), whole.vertex_point.end(), 0u);
    whole.triangle_source.resize(whole.triangles.size());
    std::iota(whole.triangle_source.begin(), whole.triangle_source.end(), 0u);
    Piece piece;
    piece.vertices.end = static_cast<uint32_t>(whole.positions.size());
    piece.triangles.end = piece.exterior_triangles = static_cast<uint32_t>(whole.triangles.size());
    piece.mass = mass_properties(whole.positions, whole.triangles);
    whole.pieces.push_back(piece);
    return whole;
}

} // namespace

Result<void> check_export(const Fragments& fragments, const ExportOptions& options) {
    if (Result<void> positive = check_volumes(fragments); !positive) return positive;
    return check_lists(fragments, options);
}

std::optional<TriangleTree> outside_of(const ExportOptions& options) {
    if (!options.rough || !options.source) return std::nullopt;
    std::vector<uint32_t> all(options.source->mesh.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    return TriangleTree(options.source->mesh, std::move(all));
}

std::string piece_name(const ExportOptions& options, uint32_t piece) {
    char number[16];
    std::snprintf(number, sizeof number, "_%03u", piece);
    return options.name + number;
}

SurfaceSettings surface_settings(const ExportJob& job) {
    return {job.options.source, job.options.sites, job.options.uv_by_plane,
            job.options.rough,  job.outside,       job.tangents};
}

glm::dvec3 placed(const ExportJob& job, uint32_t piece, const glm::dvec3& point) {
    if (job.options.poses.empty()) return point;
    const PiecePose& pose = job.options.poses[piece];
    return pose.position + pose.orientation * (point - job.fragments.pieces[piece].mass.centre_of_mass);
}

glm::vec3 turned(const ExportJob& job, uint32_t piece, const glm::vec3& direction) {
    return job.options.poses.empty() ? direction
                                     : glm::vec3(job.options.poses[piece].orientation * glm::dvec3(direction));
}

// Weathered stone outside, darker and warmer inside, so that a break is visible at once.
Material exterior_material(const ExportOptions& options) {
    return options.exterior.value_or(
        Material{.name = "exterior", .base_colour = {0.62, 0.60, 0.56, 1.0}, .roughness = 0.85});
}

Material interior_material(const ExportOptions& options) {
    return options.interior.value_or(
        Material{.name = "interior",
                 .base_colour = options.interior_image ? glm::dvec4(1.0) : glm::dvec4(0.36, 0.20, 0.13, 1.0),
                 .roughness = 0.95});
}

std::string image_ending(const Image& image) {
    return image.mime_type == "image/png" ? ".png" : (image.mime_type == "image/jpeg" ? ".jpg" : ".bin");
}

std::string image_suffix(uint32_t index, const Image& image) {
    return "_image" + std::to_string(index) + image_ending(image);
}

const std::vector<std::string>& exportable_extensions() {
    static const std::vector<std::string> extensions{".glb", ".obj", ".ply", ".stl"};
    return extensions;
}

Result<Files> export_pieces(const std::filesystem::path& file, const Fragments& fragments,
                            const Certificate& certificate, const ExportOptions& options) {
    if (const Result<void> positive = check_volumes(fragments); !positive) return positive.error();
    return write_pieces(file, fragments, certificate, options);
}

Result<std::vector<ExportedFile>> export_pieces_to_memory(const std::string& name, const Fragments& fragments,
                                                          const Certificate& certificate,
                                                          const ExportOptions& options) {
    if (const Result<void> positive = check_volumes(fragments); !positive) return positive.error();
    return keep_pieces(name, fragments, certificate, options);
}

Result<void> ObjectExport::write(const std::filesystem::path& file) {
    Result<std::vector<std::byte>> glb = bytes();
    if (!glb) return Error{glb.error().status, file.string() + ": " + glb.error().message};
    return write_file_atomically(file, *glb);
}

Result<Files> export_model(const std::filesystem::path& file, const Model& model, const std::string& name) {
    return write_pieces(file, whole_of(model), {}, {.name = name, .source = &model});
}

Result<std::vector<ExportedFile>> export_model_to_memory(const std::string& file, const Model& model,
                                                         const std::string& name, bool single_file) {
    return keep_pieces(file, whole_of(model), {}, {.name = name, .source = &model, .single_file = single_file});
}

} // namespace brittle::fracture
