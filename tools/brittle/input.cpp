#include "tools/brittle/input.h"

#include <filesystem>
#include <optional>

#include <nlohmann/json.hpp>

#include "fracture/certificate.h"
#include "fracture/io/import.h"
#include "fracture/shapes.h"
#include "fracture/sites.h"
#include "tools/brittle/failure.h"
#include "tools/brittle/stopwatch.h"

namespace brittle::tools {

namespace {

constexpr std::string_view shape_prefix = "shape:";

fracture::TriangleMesh load_mesh(const std::string& mesh) {
    if (!mesh.starts_with(shape_prefix)) return must(fracture::import_mesh(mesh));
    const std::string_view name = std::string_view(mesh).substr(shape_prefix.size());
    if (std::optional<fracture::TriangleMesh> shape = fracture::shape(name)) return std::move(*shape);
    std::string known;
    for (const std::string_view s : fracture::shape_names()) known.append(known.empty() ? "" : ", ").append(s);
    throw Failure(exit_input, "there is no shape named '" + std::string(name) + "'; there are: " + known);
}

std::string mesh_name(const std::string& mesh) {
    if (mesh.starts_with(shape_prefix)) return mesh.substr(shape_prefix.size());
    return std::filesystem::path(mesh).stem().string();
}

} // namespace

Input load_input(const FractureOptions& options, const std::function<void(fracture::TriangleMesh&)>& prepare) {
    Input input;
    input.name = mesh_name(options.mesh);
    const Stopwatch import;
    input.mesh = load_mesh(options.mesh);
    input.import_milliseconds = import.milliseconds();
    if (prepare) prepare(input.mesh);
    input.sites = options.sites_file.empty()
                      ? fracture::uniform_sites(fracture::bounds(input.mesh), options.pieces, options.seed)
                      : must(fracture::read_sites(options.sites_file));
    return input;
}

Broken break_input(const Input& input, const FractureOptions& options,
                   const std::function<void(double)>& progress) {
    const fracture::Settings settings{
        .algorithm = options.algorithm, .threads = options.threads, .progress = progress};
    const Stopwatch stopwatch;
    Broken broken;
    broken.fragments = must(fracture::fracture(input.mesh, input.sites, settings));
    broken.milliseconds = stopwatch.milliseconds();
    broken.certificate = fracture::certify(input.mesh, broken.fragments);
    return broken;
}

std::string recipe_json(const FractureOptions& options) {
    nlohmann::ordered_json recipe{{"mesh", options.mesh}};
    if (options.sites_file.empty()) {
        recipe["pattern"] = {{"type", "uniform"}, {"count", options.pieces}, {"seed", options.seed}};
    } else {
        recipe["pattern"] = {{"type", "points"}, {"file", options.sites_file}};
    }
    recipe["algorithm"] = fracture::to_string(options.algorithm);
    return recipe.dump();
}

} // namespace brittle::tools
